#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "experiments/trial_record.h"
#include "models/config_visitor.h"
#include "models/random.h"

namespace binpick {

/// The seeds of one trial: hash(master seed, experiment, cell, trial, purpose).
class TrialSeeds {
 public:
  TrialSeeds(Seed master, std::string_view experiment, std::string_view cell, std::int64_t trial);

  /// For draws that all cells share (pile, pose error, physics of the trial): the cell is left out,
  /// so that cells are compared under common random numbers.
  [[nodiscard]] Seed shared(std::string_view purpose) const noexcept;
  /// For draws of this cell alone.
  [[nodiscard]] Seed own(std::string_view purpose) const noexcept;

 private:
  Seed shared_;
  Seed own_;
};

/// What one trial gets.
struct TrialContext {
  TrialSeeds seeds;
  std::int64_t trial = 0;
  /// Where to film the trial and where to write its traces (`binpick reproduce`), absolute.
  /// Recording never changes the record.
  std::optional<std::filesystem::path> video;
  std::optional<std::filesystem::path> trace;
  /// Tells the runner which stage begins, so that a crash or a hang is booked where it happened.
  std::function<void(TrialStage)> report_stage;

  void enter(TrialStage stage) const {
    if (report_stage) report_stage(stage);
  }
};

/// Remembers the stage that a trial entered last, so that whatever ends it is booked there.
class StageWatch {
 public:
  /// `context` and the watch must outlive the trial.
  explicit StageWatch(const TrialContext& context) : watched_(context) {
    watched_.report_stage = [this, &context](TrialStage entered) {
      stage_ = entered;
      context.enter(entered);
    };
  }
  StageWatch(const StageWatch&) = delete;
  StageWatch& operator=(const StageWatch&) = delete;

  /// To be handed to the trial in place of its context.
  [[nodiscard]] const TrialContext& context() const noexcept { return watched_; }
  [[nodiscard]] TrialStage stage() const noexcept { return stage_; }

 private:
  TrialContext watched_;
  TrialStage stage_ = TrialStage::kSetup;
};

/// A protocol: how one trial is set up, run and scored.
///
/// The runner makes one instance per worker process and uses it for many trials of many cells:
/// parameters by `visit`, then `prepare`, then `run` for each trial of that cell; then the next
/// cell's values by `visit`, `prepare`, `run`... A record may depend on nothing but the parameters
/// and the context.
class TrialKind {
 public:
  virtual ~TrialKind() = default;

  /// Names the parameters: read from `parameters:` of the configuration, then the values of the
  /// cell's axes are put in their places.
  virtual void visit(ConfigVisitor& visitor) = 0;

  /// Called whenever parameters have been set and before `run`. Loads what is dear to load, and
  /// keeps what has been loaded when the parameters that name it did not change.
  /// Relative paths among the parameters start at `config_directory` (absolute).
  /// @throws InputError for files that cannot be used: ends the run with exit code 2.
  virtual void prepare(const std::filesystem::path& config_directory) { (void)config_directory; }

  /// The files whose contents decide the results (scenes, models). Their hash is part of the run's
  /// identity: results from other contents are never mixed in.
  [[nodiscard]] virtual std::vector<std::filesystem::path> input_files(
      const std::filesystem::path& config_directory) const {
    (void)config_directory;
    return {};
  }

  /// Raised whenever the meaning of a record changes; results of different versions never mix.
  [[nodiscard]] virtual int protocol_version() const { return 1; }

  /// Runs one trial. Expected failures are outcomes; whatever it throws is booked as kCrashed.
  [[nodiscard]] virtual TrialRecord run(const TrialContext& context) = 0;
};

/// The trial kinds that a program knows.
class TrialKindRegistry {
 public:
  using Factory = std::function<std::unique_ptr<TrialKind>()>;

  void add(std::string name, Factory factory);
  /// Null when no kind has this name.
  [[nodiscard]] std::unique_ptr<TrialKind> make(const std::string& name) const;
  [[nodiscard]] std::vector<std::string> names() const;

 private:
  std::map<std::string, Factory> factories_;
};

}  // namespace binpick
