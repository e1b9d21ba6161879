#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "experiments/config_override.h"
#include "experiments/experiment_config.h"
#include "experiments/trial_kind.h"

namespace binpick {

/// One point of the sweep.
struct Cell {
  std::size_t index = 0;
  std::vector<std::size_t> values;  ///< per axis, index into its values
  /// `axis=value,axis=value` in the order of the axes; "all" when there are none.
  std::string key;
};

/// One trial of one cell, the unit of work. Jobs are numbered trial-major (all cells' first trials
/// come first), so that a sweep that is stopped early is balanced.
struct Job {
  std::size_t cell = 0;
  std::int64_t trial = 0;
};

/// An experiment that has been read and checked, ready to run.
class Experiment {
 public:
  /// Reads `file`, applies the overrides in order and checks the whole again.
  /// @throws InputError with every problem found.
  [[nodiscard]] static Experiment load(const std::filesystem::path& file,
                                       const std::vector<ConfigOverride>& overrides,
                                       const TrialKindRegistry& registry);
  /// From an effective configuration; `name` stands for the file in messages.
  [[nodiscard]] static Experiment from_text(const std::string& yaml, const std::string& name,
                                            const std::filesystem::path& directory,
                                            const TrialKindRegistry& registry);

  [[nodiscard]] const ExperimentConfig& config() const { return config_; }
  /// All values that took part, defaults included, as YAML.
  [[nodiscard]] const std::string& effective_yaml() const { return effective_yaml_; }
  /// Where relative paths of the parameters start, absolute.
  [[nodiscard]] const std::filesystem::path& directory() const { return directory_; }
  /// 16 hexadecimal digits over the effective configuration.
  [[nodiscard]] std::string config_hash() const;
  /// 16 hexadecimal digits over what decides a record: name, kind, seed, parameters, axes. Number
  /// of trials, stopping rule, titles, paper counts and gates may change while results stay valid.
  [[nodiscard]] std::string identity_hash() const;
  /// 16 hexadecimal digits over the contents of the input files of all cells.
  /// @throws InputError when one cannot be read.
  [[nodiscard]] std::string inputs_hash() const;
  [[nodiscard]] int protocol_version() const;

  [[nodiscard]] const std::vector<Cell>& cells() const { return cells_; }
  /// @throws InputError when no cell has this key; it lists those that come near.
  [[nodiscard]] const Cell& cell(const std::string& key) const;
  [[nodiscard]] std::int64_t job_count() const;
  [[nodiscard]] Job job(std::int64_t index) const;

  /// A trial kind with the parameters of this experiment.
  [[nodiscard]] std::unique_ptr<TrialKind> make_kind() const;
  /// Puts the values of `cell` into a kind made by make_kind.
  void assign(const Cell& cell, TrialKind& kind) const;
  [[nodiscard]] TrialSeeds seeds(const Cell& cell, std::int64_t trial) const;

 private:
  Experiment(const TrialKindRegistry& registry, std::filesystem::path directory)
      : registry_(registry), directory_(std::move(directory)) {}
  void enumerate_cells();

  TrialKindRegistry registry_;
  std::filesystem::path directory_;
  ExperimentConfig config_;
  std::string effective_yaml_;
  std::string parameters_yaml_;
  std::vector<Cell> cells_;
};

/// Does `cell` have the values that `wanted` names? Axes that it leaves out match.
[[nodiscard]] bool matches(const std::map<std::string, std::string>& wanted,
                           const std::vector<AxisConfig>& axes, const Cell& cell);

}  // namespace binpick
