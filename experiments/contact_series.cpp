#include "experiments/contact_series.h"

#include <fmt/format.h>

#include <algorithm>

#include "experiments/write_file.h"

namespace binpick {
namespace {

constexpr const char* kHeader =
    "time_s,desired_height_m,height_m,desired_velocity_m_s,velocity_m_s,spring_force_n,"
    "true_force_n,estimated_force_n,hf1";
constexpr double kPeakEnds = 0.8;

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

double first_force_peak(const ContactSeries& series) {
  double peak = 0.0;
  for (const ContactSample& sample : series) {
    if (sample.true_force < kPeakEnds * peak) break;
    peak = std::max(peak, sample.true_force);
  }
  return peak;
}

}  // namespace binpick
