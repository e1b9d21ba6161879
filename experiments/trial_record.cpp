#include "experiments/trial_record.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>

#include "models/errors.h"

namespace binpick {
namespace {

constexpr std::array<std::string_view, kTrialOutcomes.size()> kOutcomeNames = {
    "success", "nothing_detected", "wrong_pose", "unreachable", "collision_abort", "failed_grasp",
    "slipped", "dropped",          "timeout",    "diverged",    "safety_stop",     "crashed"};
constexpr std::array<std::string_view, kTrialStages.size()> kStageNames = {
    "setup", "overview", "recognize", "select", "approach", "grasp", "carry", "place", "judge"};

std::string quoted(const std::string& text) {
  return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

double measure_from_json(const nlohmann::json& value) {
  if (value.is_number()) return value.get<double>();
  const std::string text = value.get<std::string>();
  if (text == "nan") return std::numeric_limits<double>::quiet_NaN();
  if (text == "inf") return std::numeric_limits<double>::infinity();
  if (text == "-inf") return -std::numeric_limits<double>::infinity();
  throw InputError(fmt::format("a measure is the text '{}', not a number", text));
}

std::map<std::string, double> measures_from(const nlohmann::json& json) {
  std::map<std::string, double> measures;
  for (const auto& [name, value] : json.items()) measures[name] = measure_from_json(value);
  return measures;
}

}  // namespace

std::string_view to_text(TrialOutcome outcome) noexcept {
  return kOutcomeNames[static_cast<std::size_t>(outcome)];
}

std::string_view to_text(TrialStage stage) noexcept {
  return kStageNames[static_cast<std::size_t>(stage)];
}

std::optional<TrialOutcome> outcome_from_text(std::string_view text) noexcept {
  const auto* found = std::find(kOutcomeNames.begin(), kOutcomeNames.end(), text);
  if (found == kOutcomeNames.end()) return std::nullopt;
  return kTrialOutcomes[static_cast<std::size_t>(found - kOutcomeNames.begin())];
}

std::optional<TrialStage> stage_from_text(std::string_view text) noexcept {
  const auto* found = std::find(kStageNames.begin(), kStageNames.end(), text);
  if (found == kStageNames.end()) return std::nullopt;
  return kTrialStages[static_cast<std::size_t>(found - kStageNames.begin())];
}

bool identical(const TrialRecord& a, const TrialRecord& b) noexcept {
  const auto same_measure = [](const auto& left, const auto& right) {
    return left.first == right.first &&
           std::bit_cast<std::uint64_t>(left.second) == std::bit_cast<std::uint64_t>(right.second);
  };
  return a.outcome == b.outcome && a.stage == b.stage && a.note == b.note &&
         std::equal(a.measures.begin(), a.measures.end(), b.measures.begin(), b.measures.end(),
                    same_measure);
}

std::string number_text(double value) {
  if (std::isnan(value)) return "nan";
  if (std::isinf(value)) return value > 0.0 ? "inf" : "-inf";
  // "-0" would be read back as the integer zero, without its sign.
  if (value == 0.0) return std::signbit(value) ? "-0.0" : "0";
  std::array<char, 32> buffer{};
  const auto result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  return {buffer.data(), result.ptr};
}

std::string measures_to_json(const std::map<std::string, double>& measures) {
  std::string json = "{";
  for (const auto& [name, value] : measures) {
    if (json.size() > 1) json += ",";
    const std::string number = number_text(value);
    json += quoted(name) + ":" + (std::isfinite(value) ? number : "\"" + number + "\"");
  }
  return json + "}";
}

std::map<std::string, double> measures_from_json(std::string_view json) {
  try {
    return measures_from(nlohmann::json::parse(json));
  } catch (const nlohmann::json::exception& error) {
    throw InputError(fmt::format("not a list of measures: {}", error.what()));
  }
}

std::string to_json(const TrialRecord& record) {
  return fmt::format(R"({{"outcome":"{}","stage":"{}","note":{},"measures":{}}})",
                     to_text(record.outcome), to_text(record.stage), quoted(record.note),
                     measures_to_json(record.measures));
}

TrialRecord record_from_json(std::string_view text) {
  try {
    const nlohmann::json json = nlohmann::json::parse(text);
    const auto outcome = outcome_from_text(json.at("outcome").get<std::string>());
    const auto stage = stage_from_text(json.at("stage").get<std::string>());
    if (!outcome || !stage) throw InputError("a trial record names an unknown outcome or stage");
    return {*outcome, *stage, json.at("note").get<std::string>(),
            measures_from(json.at("measures"))};
  } catch (const nlohmann::json::exception& error) {
    throw InputError(fmt::format("not a trial record: {}", error.what()));
  }
}

}  // namespace binpick
