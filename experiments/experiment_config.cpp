#include "experiments/experiment_config.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <set>

#include "experiments/config_override.h"
#include "models/errors.h"
#include "models/yaml_config.h"

namespace binpick {
namespace {

constexpr std::int64_t kMaxTrials = 10'000'000;
constexpr std::int64_t kMaxSeed = std::int64_t{1} << 62;
constexpr double kMaxTimeLimit = 86'400.0;

bool is_plain_name(const std::string& name) {
  constexpr std::string_view kAllowed =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-";
  return !name.empty() && name.find_first_not_of(kAllowed) == std::string::npos;
}

/// Cell keys read `axis=value,axis=value`.
bool fits_cell_key(const std::string& text) {
  return !text.empty() && text.find_first_of(",=\n\r") == std::string::npos;
}

void visit_cell(ConfigVisitor& visitor, std::map<std::string, std::string>& cell) {
  visitor.group("cell", [&](ConfigVisitor& inner) {
    if (inner.reading()) {
      for (const std::string& axis : inner.keys()) inner.text(axis, cell[axis]);
    } else {
      for (auto& [axis, value] : cell) inner.text(axis, value);
    }
  });
}

void check_cell(ConfigVisitor& visitor, const std::map<std::string, std::string>& cell,
                const std::vector<AxisConfig>& axes) {
  for (const auto& [name, value] : cell) {
    const auto axis = std::find_if(axes.begin(), axes.end(),
                                   [&](const AxisConfig& each) { return each.name == name; });
    if (axis == axes.end()) {
      visitor.problem("cell", fmt::format("'cell' names '{}', which is no axis", name));
    } else if (std::find(axis->values.begin(), axis->values.end(), value) == axis->values.end()) {
      visitor.problem("cell", fmt::format("'cell' gives '{}' the value {}, not one of: {}", name,
                                          value, fmt::join(axis->values, ", ")));
    }
  }
}

void check_axis(ConfigVisitor& visitor, const std::vector<AxisConfig>& axes, std::size_t i) {
  const AxisConfig& axis = axes[i];
  if (!is_plain_name(axis.name)) {
    visitor.problem("name", "an axis name consists of letters, digits, '_' and '-'");
  }
  for (std::size_t other = 0; other < i; ++other) {
    if (axes[other].name == axis.name) visitor.problem("name", "two axes have this name");
    if (axes[other].key == axis.key) visitor.problem("key", "two axes sweep this key");
    if (axes[other].columns && axis.columns) {
      visitor.problem("columns", "one axis at most can be printed as columns");
    }
  }
  if (axis.values.empty()) visitor.problem("values", "'values' needs at least one value");
  const std::set<std::string> distinct(axis.values.begin(), axis.values.end());
  if (distinct.size() != axis.values.size()) {
    visitor.problem("values", "'values' lists a value twice");
  }
  if (!std::all_of(axis.values.begin(), axis.values.end(), fits_cell_key)) {
    visitor.problem("values", "a value is empty or contains ',', '=' or a line break");
  }
  if (!axis.labels.empty() && axis.labels.size() != axis.values.size()) {
    visitor.problem("labels", "'labels' needs one entry per value");
  }
}

/// Tries every value of the axis on a copy of the parameters.
void check_axis_values(ConfigVisitor& visitor, const AxisConfig& axis, const std::string& kind,
                       TrialKind& parameters, const TrialKindRegistry& registry) {
  const std::unique_ptr<TrialKind> copy = registry.make(kind);
  const auto fields = [&](ConfigVisitor& inner) { copy->visit(inner); };
  try {
    const std::string saved = write_yaml([&](ConfigVisitor& writer) { parameters.visit(writer); });
    read_yaml_text(saved, "parameters", fields);
  } catch (const InputError&) {
    return;  // parameters that are wrong by themselves have been reported already
  }
  for (const std::string& value : axis.values) {
    try {
      apply_override(ConfigOverride::literal(axis.key, value), axis.name, fields);
    } catch (const InputError& error) {
      visitor.problem("values", fmt::format("axis '{}': {}", axis.name, error.what()));
    }
  }
}

}  // namespace

void AxisConfig::visit(ConfigVisitor& visitor) {
  visitor.text("name", name, Presence::kRequired);
  visitor.text("key", key, Presence::kRequired);
  visitor.texts("values", values, Presence::kRequired);
  visitor.texts("labels", labels);
  visitor.boolean("columns", columns);
}

const std::string& AxisConfig::label(std::size_t value) const {
  return labels.empty() ? values[value] : labels[value];
}

void PaperCount::visit(ConfigVisitor& visitor) {
  visit_cell(visitor, cell);
  visitor.integer("successes", successes, 0, kMaxTrials, Presence::kRequired);
  visitor.integer("trials", trials, 1, kMaxTrials, Presence::kRequired);
  if (successes > trials) visitor.problem("successes", "'successes' exceeds 'trials'");
}

void GateConfig::visit(ConfigVisitor& visitor) {
  visit_cell(visitor, cell);
  visitor.number("minimum_rate", minimum_rate, {.min = 0.0, .max = 1.0}, Presence::kRequired);
}

void ExperimentConfig::visit(ConfigVisitor& visitor, const TrialKindRegistry& registry,
                             std::unique_ptr<TrialKind>& parameters) {
  visitor.integer("format", format, 0, std::numeric_limits<std::int64_t>::max());
  if (visitor.reading() && format != kConfigFormat) {
    visitor.problem("format", fmt::format("a file of format {}, this program reads format {}: use "
                                          "the binpick that it was written for, or bring it up to "
                                          "date (docs/running.md)",
                                          format, kConfigFormat));
  }
  visitor.text("experiment", name, Presence::kRequired);
  if (visitor.reading() && !is_plain_name(name)) {
    visitor.problem("experiment", "'experiment' consists of letters, digits, '_' and '-'");
  }
  visitor.text("title", title);
  const std::string kind_before = kind;
  visitor.choice("kind", kind, registry.names(), Presence::kRequired);
  visitor.integer("seed", seed, 0, kMaxSeed);
  visitor.integer("trials", trials, 1, kMaxTrials);
  visitor.group("stopping", [&](ConfigVisitor& inner) {
    stopping.visit(inner);
    if (inner.reading() && stopping.active() && trials > kMostSequentialTrials) {
      inner.problem("half_width", fmt::format("a stopping rule goes with at most {} trials",
                                              kMostSequentialTrials));
    }
  });
  visitor.number("time_limit_s", time_limit, {.min = 0.001, .max = kMaxTimeLimit});
  if (!parameters || kind != kind_before) parameters = registry.make(kind);
  if (parameters) {
    visitor.group("parameters", [&](ConfigVisitor& inner) { parameters->visit(inner); });
  }
  visit_sweep(visitor, registry, parameters.get());
}

void ExperimentConfig::visit_sweep(ConfigVisitor& visitor, const TrialKindRegistry& registry,
                                   TrialKind* parameters) {
  visitor.list(
      "axes", axes.size(), [&](std::size_t size) { axes.assign(size, {}); },
      [&](ConfigVisitor& inner, std::size_t i) {
        axes[i].visit(inner);
        if (!inner.reading()) return;
        check_axis(inner, axes, i);
        if (parameters) check_axis_values(inner, axes[i], kind, *parameters, registry);
      });
  visitor.list(
      "paper", paper.size(), [&](std::size_t size) { paper.assign(size, {}); },
      [&](ConfigVisitor& inner, std::size_t i) {
        paper[i].visit(inner);
        check_cell(inner, paper[i].cell, axes);
      });
  visitor.list(
      "gates", gates.size(), [&](std::size_t size) { gates.assign(size, {}); },
      [&](ConfigVisitor& inner, std::size_t i) {
        gates[i].visit(inner);
        check_cell(inner, gates[i].cell, axes);
      });
}

}  // namespace binpick
