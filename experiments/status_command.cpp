#include "experiments/status_command.h"

#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "experiments/exit_codes.h"
#include "experiments/present_results.h"
#include "experiments/progress.h"
#include "experiments/result_table.h"
#include "experiments/run_status.h"

namespace binpick {
namespace {

std::string left_text(const std::optional<double>& time_left) {
  return time_left ? fmt::format(", about {} left", clock_text(*time_left)) : "";
}

std::string part_line(const PartStatus& part) {
  std::string doing = part.done == part.expected ? "complete" : "stopped";
  if (part.writer) {
    doing = fmt::format("running: {}, {} worker{}{}", part.writer->text(), part.writer->workers,
                        part.writer->workers == 1 ? "" : "s", left_text(part.time_left));
  }
  return fmt::format("  {}: {} of {}, {}\n", part.store.filename().string(), part.done,
                     part.expected, doing);
}

std::string status_text(const Experiment& experiment, const RunStatus& status,
                        const ResultSummary& summary) {
  std::string text = fmt::format(
      "{}: {} of {}{} trials, {}{}{}; {} of trials' time so far\n", experiment.config().name,
      status.done, status.open_ended ? "at most " : "", status.expected, status.state(),
      left_text(status.time_left()), status.state() == "stopped" ? ", `binpick run` goes on" : "",
      clock_text(status.work_time));
  for (const PartStatus& part : status.parts) text += part_line(part);
  if (!status.missing.empty()) {
    text += fmt::format("  without a store: {}\n", missing_text(status.missing));
  }
  return text + "\n" + result_table(experiment, summary);
}

nlohmann::ordered_json optional_number(const std::optional<double>& value) {
  return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(nullptr);
}

nlohmann::ordered_json part_json(const PartStatus& part) {
  nlohmann::ordered_json json{{"store", part.store.filename().string()}};
  if (part.shard) json["shard"] = fmt::format("{}/{}", part.shard->index, part.shard->count);
  json["done"] = part.done;
  json["expected"] = part.expected;
  json["running"] = part.writer.has_value();
  if (part.writer) {
    json["host"] = part.writer->host;
    json["process"] = part.writer->process;
    json["workers"] = part.writer->workers;
    json["time_left_s"] = optional_number(part.time_left);
  }
  return json;
}

nlohmann::ordered_json cell_json(const Cell& cell, const CellSummary& summary) {
  return {{"cell", cell.key},
          {"successes", summary.ours.successes},
          {"trials", summary.ours.trials},
          {"interval_low", summary.interval.low},
          {"interval_high", summary.interval.high}};
}

std::string status_json(const Experiment& experiment, const RunStatus& status,
                        const ResultSummary& summary) {
  nlohmann::ordered_json json{{"experiment", experiment.config().name},
                              {"state", status.state()},
                              {"done", status.done},
                              {"expected", status.expected},
                              {"successes", summary.pooled.counts.successes},
                              {"time_left_s", optional_number(status.time_left())},
                              {"work_time_s", status.work_time}};
  json["parts"] = nlohmann::ordered_json::array();
  for (const PartStatus& part : status.parts) json["parts"].push_back(part_json(part));
  json["missing"] = nlohmann::ordered_json::array();
  for (const Shard& shard : status.missing) {
    json["missing"].push_back(fmt::format("{}/{}", shard.index, shard.count));
  }
  json["cells"] = nlohmann::ordered_json::array();
  for (const Cell& cell : experiment.cells()) {
    json["cells"].push_back(cell_json(cell, summary.cells[cell.index]));
  }
  return json.dump(1) + "\n";
}

}  // namespace

void add_status_command(CLI::App& app, const TrialKindRegistry& registry, int& exit_code) {
  struct Arguments {
    std::string folder;
    bool json = false;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command =
      app.add_subcommand("status", "Show how far a run is, running or not, and its table so far");
  command->add_option("DIR", arguments->folder, "results folder")->required();
  command->add_flag("--json", arguments->json, "as JSON on stdout");
  command->callback([arguments, &registry, &exit_code] {
    const ResultFolder folder(arguments->folder);
    const RunResults results = folder.read();
    print_conflicts(results);
    const Experiment experiment = experiment_of(results.manifest, registry);
    const ResultSummary summary = summarize(experiment, results.trials);
    const RunStatus status = run_status(experiment, folder.stores(), results, summary);
    const auto text = arguments->json ? status_json : status_text;
    fmt::print("{}", text(experiment, status, summary));
    exit_code = kExitOk;
  });
}

}  // namespace binpick
