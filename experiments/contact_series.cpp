#include "experiments/contact_series.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <fstream>

#include "experiments/write_file.h"
#include "models/errors.h"

namespace binpick {
namespace {

constexpr const char* kHeader =
    "time_s,desired_height_m,height_m,desired_velocity_m_s,velocity_m_s,spring_force_n,"
    "true_force_n,estimated_force_n,hf1";
constexpr std::size_t kColumns = 9;
constexpr double kPeakEnds = 0.8;

std::array<double, kColumns> parse_row(const std::string& line, const std::string& where) {
  std::array<double, kColumns> values{};
  const char* next = line.data();
  const char* end = next + line.size();
  for (std::size_t i = 0; i < kColumns; ++i) {
    const auto result = std::from_chars(next, end, values[i]);
    const bool last = i + 1 == kColumns;
    if (result.ec != std::errc() || (last ? result.ptr != end : *result.ptr != ',')) {
      throw InputError(fmt::format("{}: wants {} numbers separated by commas", where, kColumns));
    }
    next = result.ptr + (last ? 0 : 1);
  }
  return values;
}

}  // namespace

void write_contact_series(const std::filesystem::path& file, const ContactSeries& series) {
  std::string text = std::string(kHeader) + "\n";
  for (const ContactSample& s : series) {
    text += fmt::format("{:.3f},{:.6f},{:.6f},{:.5f},{:.5f},{:.3f},{:.3f},{:.3f},{}\n", s.time,
                        s.desired_height, s.height, s.desired_velocity, s.velocity, s.spring_force,
                        s.true_force, s.estimated_force, s.collision ? 1 : 0);
  }
  write_file(file, text);
}

ContactSeries read_contact_series(const std::filesystem::path& file) {
  std::ifstream stream(file);
  if (!stream) throw IoError(fmt::format("{}: cannot be read", file.string()));
  std::string line;
  if (!std::getline(stream, line) || line != kHeader) {
    throw InputError(fmt::format("{}:1: is not the head of a contact series", file.string()));
  }
  ContactSeries series;
  for (int number = 2; std::getline(stream, line); ++number) {
    const auto v = parse_row(line, fmt::format("{}:{}", file.string(), number));
    series.push_back({v[0], v[1], v[2], v[3], v[4], v[5], v[6], v[7], v[8] != 0.0});
  }
  return series;
}

double first_force_peak(const ContactSeries& series) {
  double peak = 0.0;
  for (const ContactSample& sample : series) {
    if (sample.true_force < kPeakEnds * peak) break;
    peak = std::max(peak, sample.true_force);
  }
  return peak;
}

}  // namespace binpick
