#include "experiments/result_export.h"

#include <fmt/format.h>

#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <vector>

#include "experiments/result_summary.h"

namespace binpick {
namespace {

/// RFC 4180: quoted when it has to be.
std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted(1, '"');
  for (const char c : text) quoted.append(c == '"' ? 2 : 1, c);
  quoted += '"';
  return quoted;
}

std::string json_text(const std::string& text) {
  return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace

std::string results_to_csv(const Experiment& experiment, const RunResults& results) {
  const TrialTable trials = trials_of(experiment, results.trials);
  std::set<std::string> measures;
  for (const auto& [key, trial] : trials) {
    for (const auto& [name, value] : trial.record.measures) measures.insert(name);
  }
  std::string csv = "cell";
  for (const AxisConfig& axis : experiment.config().axes)
    csv += fmt::format(",{}", csv_field(axis.name));
  csv += ",trial,outcome,stage,note";
  for (const std::string& name : measures) csv += fmt::format(",{}", csv_field(name));
  csv += "\n";
  for (const auto& [key, trial] : trials) {
    const Cell& cell = experiment.cell(key.cell);
    csv += csv_field(key.cell);
    for (std::size_t i = 0; i < cell.values.size(); ++i) {
      csv += fmt::format(",{}", csv_field(experiment.config().axes[i].values[cell.values[i]]));
    }
    csv += fmt::format(",{},{},{},{}", key.trial, to_text(trial.record.outcome),
                       to_text(trial.record.stage), csv_field(trial.record.note));
    for (const std::string& name : measures) {
      const auto value = trial.record.measures.find(name);
      csv += ',';
      if (value != trial.record.measures.end()) csv += number_text(value->second);
    }
    csv += "\n";
  }
  return csv;
}

std::string results_to_json(const Experiment& experiment, const RunResults& results) {
  const RunManifest& manifest = results.manifest;
  std::string json = fmt::format(
      "{{\"experiment\":{},\"seed\":{},\"identity\":{},\"inputs\":{},\"protocol\":{},"
      "\"program\":{},\"trials\":[",
      json_text(manifest.experiment), experiment.config().seed, json_text(manifest.identity),
      json_text(manifest.inputs), json_text(manifest.protocol), json_text(manifest.program));
  const char* separator = "\n";
  for (const auto& [key, trial] : trials_of(experiment, results.trials)) {
    json += fmt::format("{}{{\"cell\":{},\"trial\":{},\"record\":{}}}", separator,
                        json_text(key.cell), key.trial, to_json(trial.record));
    separator = ",\n";
  }
  return json + "\n]}\n";
}

}  // namespace binpick
