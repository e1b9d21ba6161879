#include "experiments/experiment.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "experiments/content_hash.h"
#include "models/errors.h"
#include "models/yaml_config.h"

namespace binpick {
namespace {

constexpr std::size_t kMaxCells = 100'000;

}  // namespace

Experiment Experiment::load(const std::filesystem::path& file,
                            const std::vector<ConfigOverride>& overrides,
                            const TrialKindRegistry& registry) {
  ExperimentConfig config;
  std::unique_ptr<TrialKind> parameters;
  const auto fields = [&](ConfigVisitor& visitor) { config.visit(visitor, registry, parameters); };
  read_yaml(file, fields);
  for (const ConfigOverride& change : overrides) {
    apply_override(change, fmt::format("--set {}", change.path), fields);
  }
  const std::filesystem::path directory =
      std::filesystem::weakly_canonical(std::filesystem::absolute(file)).parent_path();
  const std::string name = file.string() + (overrides.empty() ? "" : " (with overrides)");
  return from_text(write_yaml(fields), name, directory, registry);
}

Experiment Experiment::from_text(const std::string& yaml, const std::string& name,
                                 const std::filesystem::path& directory,
                                 const TrialKindRegistry& registry) {
  Experiment experiment(registry, directory);
  std::unique_ptr<TrialKind> parameters;
  const auto fields = [&](ConfigVisitor& visitor) {
    experiment.config_.visit(visitor, registry, parameters);
  };
  read_yaml_text(yaml, name, fields);
  experiment.effective_yaml_ = write_yaml(fields);
  experiment.parameters_yaml_ =
      write_yaml([&](ConfigVisitor& visitor) { parameters->visit(visitor); });
  experiment.enumerate_cells();
  return experiment;
}

void Experiment::enumerate_cells() {
  std::size_t count = 1;
  for (const AxisConfig& axis : config_.axes) {
    count *= axis.values.size();
    if (count > kMaxCells) {
      throw InputError(fmt::format("{}: the axes make more than {} cells, sweep fewer values",
                                   config_.name, kMaxCells));
    }
  }
  for (std::size_t index = 0; index < count; ++index) {
    Cell cell{index, std::vector<std::size_t>(config_.axes.size()), ""};
    std::size_t rest = index;
    for (std::size_t axis = config_.axes.size(); axis-- > 0;) {
      const std::size_t size = config_.axes[axis].values.size();
      cell.values[axis] = rest % size;
      rest /= size;
    }
    for (std::size_t axis = 0; axis < config_.axes.size(); ++axis) {
      const AxisConfig& swept = config_.axes[axis];
      cell.key +=
          fmt::format("{}{}={}", axis == 0 ? "" : ",", swept.name, swept.values[cell.values[axis]]);
    }
    if (cell.key.empty()) cell.key = "all";
    cells_.push_back(std::move(cell));
  }
}

std::string Experiment::config_hash() const {
  ContentHash hash;
  hash.add(effective_yaml_);
  return hash.hex();
}

std::string Experiment::identity_hash() const {
  std::string text =
      fmt::format("{}\n{}\n{}\n{}", config_.name, config_.kind, config_.seed, parameters_yaml_);
  for (const AxisConfig& axis : config_.axes) {
    text += fmt::format("{}={}:{}\n", axis.name, axis.key, fmt::join(axis.values, ","));
  }
  ContentHash hash;
  hash.add(text);
  return hash.hex();
}

std::string Experiment::inputs_hash() const {
  std::set<std::filesystem::path> files;
  const std::unique_ptr<TrialKind> kind = make_kind();
  for (const Cell& each : cells_) {
    assign(each, *kind);
    for (const std::filesystem::path& file : kind->input_files(directory_)) files.insert(file);
  }
  ContentHash hash;
  for (const std::filesystem::path& file : files) {
    // The place of the checkout is not part of an experiment's identity.
    hash.add(file.filename().string());
    hash.add_file(file);
  }
  return hash.hex();
}

int Experiment::protocol_version() const { return make_kind()->protocol_version(); }

const Cell& Experiment::cell(const std::string& key) const {
  const auto found =
      std::find_if(cells_.begin(), cells_.end(), [&](const Cell& c) { return c.key == key; });
  if (found != cells_.end()) return *found;
  std::vector<std::string> some;
  for (std::size_t i = 0; i < std::min<std::size_t>(cells_.size(), 20); ++i) {
    some.push_back(cells_[i].key);
  }
  throw InputError(fmt::format("--cell '{}': no such cell; there are {}: {}{}", key, cells_.size(),
                               fmt::join(some, " "), cells_.size() > some.size() ? " ..." : ""));
}

std::int64_t Experiment::job_count() const {
  return config_.trials * static_cast<std::int64_t>(cells_.size());
}

Job Experiment::job(std::int64_t index) const {
  const auto cells = static_cast<std::int64_t>(cells_.size());
  return {static_cast<std::size_t>(index % cells), index / cells};
}

std::unique_ptr<TrialKind> Experiment::make_kind() const {
  std::unique_ptr<TrialKind> kind = registry_.make(config_.kind);
  read_yaml_text(parameters_yaml_, "parameters",
                 [&](ConfigVisitor& visitor) { kind->visit(visitor); });
  return kind;
}

void Experiment::assign(const Cell& cell, TrialKind& kind) const {
  for (std::size_t i = 0; i < config_.axes.size(); ++i) {
    const AxisConfig& axis = config_.axes[i];
    apply_override(ConfigOverride::literal(axis.key, axis.values[cell.values[i]]), axis.name,
                   [&](ConfigVisitor& visitor) { kind.visit(visitor); });
  }
}

TrialSeeds Experiment::seeds(const Cell& cell, std::int64_t trial) const {
  return {static_cast<Seed>(config_.seed), config_.name, cell.key, trial};
}

bool matches(const std::map<std::string, std::string>& wanted, const std::vector<AxisConfig>& axes,
             const Cell& cell) {
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const auto value = wanted.find(axes[i].name);
    if (value != wanted.end() && value->second != axes[i].values[cell.values[i]]) return false;
  }
  return true;
}

}  // namespace binpick
