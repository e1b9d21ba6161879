#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace binpick {

/// How a trial ended: a closed list, so that every failure of a sweep has a name.
enum class TrialOutcome {
  kSuccess,
  kNothingDetected,
  kWrongPose,
  kUnreachable,
  kCollisionAbort,
  kFailedGrasp,
  kSlipped,
  kDropped,
  kTimeout,   ///< the trial's own limit or, as a backstop, that of the runner
  kDiverged,  ///< the simulation left the physical range
  /// The arm's own safety closed the brakes: a limit on torque, rate, position or speed was
  /// exceeded, or a sensor failed. The note says which.
  kSafetyStop,
  kCrashed,  ///< the worker process died or the trial threw
};

/// Where in the trial that happened.
enum class TrialStage {
  kSetup,
  kOverview,
  kRecognize,
  kSelect,
  kApproach,
  kGrasp,
  kCarry,
  kPlace,
  kJudge,
};

inline constexpr std::array kTrialOutcomes = {
    TrialOutcome::kSuccess,     TrialOutcome::kNothingDetected, TrialOutcome::kWrongPose,
    TrialOutcome::kUnreachable, TrialOutcome::kCollisionAbort,  TrialOutcome::kFailedGrasp,
    TrialOutcome::kSlipped,     TrialOutcome::kDropped,         TrialOutcome::kTimeout,
    TrialOutcome::kDiverged,    TrialOutcome::kSafetyStop,      TrialOutcome::kCrashed};
inline constexpr std::array kTrialStages = {
    TrialStage::kSetup,  TrialStage::kOverview, TrialStage::kRecognize,
    TrialStage::kSelect, TrialStage::kApproach, TrialStage::kGrasp,
    TrialStage::kCarry,  TrialStage::kPlace,    TrialStage::kJudge};

/// The name in files and tables, e.g. "collision_abort".
[[nodiscard]] std::string_view to_text(TrialOutcome outcome) noexcept;
[[nodiscard]] std::string_view to_text(TrialStage stage) noexcept;
/// The inverse; nothing for a text that names none.
[[nodiscard]] std::optional<TrialOutcome> outcome_from_text(std::string_view text) noexcept;
[[nodiscard]] std::optional<TrialStage> stage_from_text(std::string_view text) noexcept;

/// The result of one trial. A pure function of configuration, cell and seeds: it carries neither
/// wall-clock times nor anything of the host, for its bytes are compared across runs.
struct TrialRecord {
  TrialOutcome outcome = TrialOutcome::kSuccess;
  TrialStage stage = TrialStage::kJudge;   ///< where it ended; kJudge for a success
  std::string note;                        ///< one line for a person, UTF-8
  std::map<std::string, double> measures;  ///< SI units; names end in the unit, e.g. "peak_force_n"
};

/// Equality of bits: NaN equals the same NaN, +0 differs from -0.
[[nodiscard]] bool identical(const TrialRecord& a, const TrialRecord& b) noexcept;

/// One line of JSON with the keys outcome, stage, note, measures. Numbers have the shortest form
/// that reads back bit for bit; infinities and NaN are the texts "inf", "-inf", "nan".
/// Invalid UTF-8 in the note is replaced.
[[nodiscard]] std::string to_json(const TrialRecord& record);
/// @throws InputError for anything that to_json cannot have written.
[[nodiscard]] TrialRecord record_from_json(std::string_view json);

/// The `measures` part alone.
[[nodiscard]] std::string measures_to_json(const std::map<std::string, double>& measures);
[[nodiscard]] std::map<std::string, double> measures_from_json(std::string_view json);

/// The shortest decimal form that reads back bit for bit.
[[nodiscard]] std::string number_text(double value);

}  // namespace binpick
