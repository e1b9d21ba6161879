#include "experiments/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "experiments/contact_figures.h"
#include "experiments/html.h"
#include "experiments/recognition_report.h"
#include "experiments/report_figures.h"
#include "experiments/report_page.h"
#include "experiments/report_stiffness.h"
#include "experiments/reproduce_line.h"
#include "experiments/result_export.h"
#include "experiments/result_summary.h"
#include "experiments/result_table.h"
#include "experiments/write_file.h"

namespace binpick {
namespace {

/// How strongly a share of trials colours its field.
std::string heat(std::int64_t count, std::int64_t total) {
  if (count == 0) return "";
  const double share = static_cast<double>(count) / static_cast<double>(total);
  return fmt::format(" style=\"background:color-mix(in srgb,var(--paper) {:.0f}%,transparent)\"",
                     15.0 + 60.0 * share);
}

class ReportPage {
 public:
  ReportPage(const Experiment& experiment, const RunResults& results, const ResultSummary& summary,
             const std::string& folder, const TraceSection& shown)
      : experiment_(experiment),
        results_(results),
        trials_(trials_of(experiment, results.trials)),
        summary_(summary),
        folder_(folder),
        shown_(shown) {}

  std::string html() {
    add_head();
    html_ += recognition_section(experiment_, trials_);
    html_ += contact_section(experiment_);
    add_table();
    add_statements();
    html_ += stiffness_section(experiment_, trials_, summary_);
    add_outcomes();
    add_measures();
    add_failures();
    html_ += shown_.html;
    add_origin();
    return report_page(experiment_.config().heading(), html_);
  }

 private:
  void add_head() {
    html_ += fmt::format(
        "<p class=\"lead\">{} of {} trials in {} cells, seed {}: {} succeeded "
        "({}, 95 % interval {}).</p>\n",
        summary_.pooled.counts.trials, summary_.expected_trials, experiment_.cells().size(),
        experiment_.config().seed, summary_.pooled.counts.successes,
        percent_text(summary_.pooled.counts.rate()), interval_text(summary_.pooled.interval));
    if (!summary_.complete()) {
      html_ += fmt::format(
          "<p class=\"bad\">Not finished: {} of {} trials are missing. <code>binpick run</code> "
          "makes "
          "them, "
          "<code>binpick merge</code> joins other shards.</p>\n",
          summary_.expected_trials - summary_.pooled.counts.trials, summary_.expected_trials);
    }
    if (!results_.conflicts.empty()) {
      html_ += fmt::format(
          "<p class=\"bad\">{} trials have two different records: these results "
          "are not reproducible.</p>\n",
          results_.conflicts.size());
    }
  }

  [[nodiscard]] std::string table_header() const {
    const auto axis = column_axis(experiment_.config());
    std::string html = "<tr>";
    for (std::size_t i = 0; i < experiment_.config().axes.size(); ++i) {
      if (i != axis) html += th(axis_heading(experiment_.config().axes[i]));
    }
    if (summary_.has_paper()) html += th("paper");
    for (const ColumnSummary& column : summary_.columns) {
      const std::string name =
          axis ? experiment_.config().axes[*axis].name + " " + column.label : "ours";
      html += th(name) + th("%") + th("95 % interval");
      html += "<th class=\"text\">" + rate_legend_svg(summary_.has_paper()) + "</th>";
      if (summary_.has_paper()) html += th("p");
    }
    return html + "</tr>\n";
  }

  [[nodiscard]] std::string cell_html(std::size_t index) const {
    const CellSummary& cell = summary_.cells[index];
    const bool any = cell.ours.trials > 0;
    std::string html =
        cell.ours.successes == cell.ours.trials
            ? td(counts_text(cell.ours))
            : fmt::format("<td><a href=\"#cell-{}\" title=\"failed trials\">{}</a></td>", index,
                          counts_text(cell.ours));
    html += td(any ? fmt::format("{:.1f}", 100.0 * cell.ours.rate()) : "");
    html += td(any ? interval_text(cell.interval) : "");
    html += "<td class=\"text\">" + rate_bar_svg(cell) + "</td>";
    if (!summary_.has_paper()) return html;
    const bool fits = !cell.paper_p || *cell.paper_p >= 0.05;
    return html + fmt::format("<td class=\"{}\">{}</td>", fits ? "good" : "bad",
                              cell.paper_p ? fmt::format("{:.2g}", *cell.paper_p) : "");
  }

  [[nodiscard]] std::string table_row(std::size_t row) const {
    const auto axis = column_axis(experiment_.config());
    const Cell& first = experiment_.cells()[summary_.columns.front().cells[row]];
    std::string html = "<tr>";
    for (std::size_t i = 0; i < first.values.size(); ++i) {
      if (i != axis) html += td(experiment_.config().axes[i].label(first.values[i]));
    }
    if (summary_.has_paper()) {
      const auto& paper = summary_.cells[first.index].paper;
      html += td(paper ? counts_text(*paper) : "");
    }
    for (const ColumnSummary& column : summary_.columns) html += cell_html(column.cells[row]);
    return html + "</tr>\n";
  }

  void add_table() {
    const std::size_t rows = summary_.columns.front().cells.size();
    std::string table = table_header();
    for (std::size_t row = 0; row < rows; ++row) table += table_row(row);
    html_ +=
        "<h2>Success rates</h2>\n<div class=\"rates\">" + scrolling_table(table, rows) + "</div>\n";
    if (summary_.has_paper()) {
      html_ += "<p class=\"lead\">p: Fisher's exact test, ours against the paper's.</p>\n";
    }
  }

  void add_statements() {
    html_ += "<h2>What the table supports</h2>\n<ul>\n";
    for (const std::string& statement : table_statements(experiment_, summary_)) {
      html_ += "<li>" + html_escape(statement) + "</li>\n";
    }
    for (const GateResult& gate : summary_.gates) {
      html_ += fmt::format("<li class=\"{}\">gate {}: {} = {} {}, demanded {}: {}</li>\n",
                           gate.passed ? "good" : "bad", gate.passed ? "passed" : "failed",
                           counts_text(gate.ours), percent_text(gate.ours.rate()),
                           interval_text(gate.interval), percent_text(gate.minimum_rate),
                           html_escape(gate.cell));
    }
    html_ += "</ul>\n";
  }

  [[nodiscard]] std::int64_t count_of(TrialOutcome outcome, TrialStage stage) const {
    for (const OutcomeCount& each : summary_.outcomes) {
      if (each.outcome == outcome && each.stage == stage) return each.count;
    }
    return 0;
  }

  void add_outcomes() {
    // Stages at which nothing ended are left out, for narrow screens.
    std::vector<TrialStage> stages;
    for (const TrialStage stage : kTrialStages) {
      const auto at_stage = [&](const OutcomeCount& each) { return each.stage == stage; };
      if (std::any_of(summary_.outcomes.begin(), summary_.outcomes.end(), at_stage)) {
        stages.push_back(stage);
      }
    }
    html_ += "<h2>How trials ended, and at which stage</h2>\n<div class=\"wide\"><table>\n<tr>" +
             th("outcome", true);
    for (const TrialStage stage : stages) html_ += th(std::string(to_text(stage)));
    html_ += th("all") + "</tr>\n";
    for (const TrialOutcome outcome : kTrialOutcomes) {
      std::string row;
      std::int64_t sum = 0;
      for (const TrialStage stage : stages) {
        const std::int64_t count = count_of(outcome, stage);
        sum += count;
        const std::string colour =
            outcome == TrialOutcome::kSuccess ? "" : heat(count, summary_.pooled.counts.trials);
        row += fmt::format("<td{}>{}</td>", colour, count == 0 ? "" : fmt::format("{}", count));
      }
      if (sum == 0) continue;
      html_ += fmt::format("<tr><td class=\"text\">{}</td>{}<td>{}</td></tr>\n", to_text(outcome),
                           row, sum);
    }
    html_ += "</table></div>\n";
  }

  void add_measures() {
    std::map<std::string, std::vector<double>> measures;
    for (const auto& [key, trial] : trials_) {
      // The measures `name.<i>` of single objects are one.
      for (const auto& [name, value] : trial.record.measures) {
        measures[name.substr(0, name.find('.'))].push_back(value);
      }
    }
    if (measures.empty()) return;
    html_ += "<h2>Measures over all trials</h2>\n<div class=\"wide\"><table>\n<tr>" +
             th("measure", true) + th("trials") + th("lowest") + th("median") + th("highest") +
             "</tr>\n";
    for (auto& [name, values] : measures) {
      std::sort(values.begin(), values.end());
      html_ += fmt::format(
          "<tr><td class=\"text\">{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n",
          html_escape(name), values.size(), digits_text(values.front(), 4),
          digits_text(values[values.size() / 2], 4), digits_text(values.back(), 4));
    }
    html_ += "</table></div>\n";
  }

  void add_failures() {
    html_ += "<h2>Failed trials</h2>\n";
    if (summary_.pooled.counts.successes == summary_.pooled.counts.trials)
      html_ += "<p>None.</p>\n";
    for (const Cell& cell : experiment_.cells()) {
      const Proportion& ours = summary_.cells[cell.index].ours;
      if (ours.successes == ours.trials) continue;
      html_ += fmt::format(
          "<details><summary>{}: {} of {}</summary>\n<div class=\"wide\" "
          "id=\"cell-{}\"><table>\n",
          html_escape(cell.key), ours.trials - ours.successes, ours.trials, cell.index);
      html_ += "<tr>" + th("trial") + th("outcome", true) + th("stage", true) + th("note", true) +
               th("reproduce", true) + "</tr>\n";
      const auto last = trials_.lower_bound({cell.key, experiment_.config().trials});
      for (auto each = trials_.lower_bound({cell.key, 0}); each != last; ++each) {
        add_failure(each->first, each->second.record);
      }
      html_ += "</table></div></details>\n";
    }
  }

  void add_failure(const TrialKey& key, const TrialRecord& record) {
    if (record.outcome == TrialOutcome::kSuccess) return;
    const auto anchor = shown_.anchors.find(key);
    const std::string number =
        anchor == shown_.anchors.end()
            ? fmt::format("{}", key.trial)
            : fmt::format("<a href=\"#{}\">{}</a>", anchor->second, key.trial);
    html_ += fmt::format(
        "<tr><td>{}</td><td class=\"text\">{}</td><td class=\"text\">{}</td>"
        "<td class=\"note\">{}</td><td class=\"text\"><code>{}</code></td></tr>\n",
        number, to_text(record.outcome), to_text(record.stage), html_escape(record.note),
        html_escape(reproduce_line(folder_, key)));
  }

  void add_origin() {
    const RunManifest& manifest = results_.manifest;
    html_ += "<h2>Effective configuration</h2>\n<pre>" + html_escape(experiment_.effective_yaml()) +
             "</pre>\n<h2>Origin</h2>\n<div class=\"wide\"><table>\n";
    const std::array<std::pair<const char*, std::string>, 8> rows{{
        {"binpick", manifest.program},
        {"build", manifest.build},
        {"protocol version", manifest.protocol},
        {"configuration", manifest.config},
        {"input files", manifest.inputs},
        {"relative paths start at", manifest.directory},
        {"processor class", manifest.cpu},
        {"host", manifest.host},
    }};
    for (const auto& [name, value] : rows) {
      html_ += fmt::format(
          "<tr><td class=\"text\">{}</td><td class=\"text\"><code>{}</code></td>"
          "</tr>\n",
          name, html_escape(value));
    }
    html_ += "</table></div>\n";
  }

  static std::string th(const std::string& text, bool left = false) {
    return fmt::format("<th{}>{}</th>", left ? " class=\"text\"" : "", html_escape(text));
  }
  static std::string td(const std::string& text) { return "<td>" + html_escape(text) + "</td>"; }

  const Experiment& experiment_;
  const RunResults& results_;
  TrialTable trials_;
  const ResultSummary& summary_;
  std::string folder_;
  const TraceSection& shown_;
  std::string html_;
};

}  // namespace

std::string report_html(const Experiment& experiment, const RunResults& results,
                        const ResultSummary& summary, const std::string& folder,
                        const TraceSection& shown) {
  return ReportPage(experiment, results, summary, folder, shown).html();
}

std::filesystem::path write_report(const ResultFolder& folder, const Experiment& experiment,
                                   const RunResults& results, const ResultSummary& summary) {
  const std::filesystem::path page = folder.path() / "report.html";
  write_file(folder.path() / "trials.csv", results_to_csv(experiment, results));
  write_file(folder.path() / "trials.json", results_to_json(experiment, results));
  const TraceSection shown =
      trace_section(folder.path(), results, find_traces(folder.path(), results), replay_script(),
                    kMostTraceBytes);
  write_file(page, report_html(experiment, results, summary, folder.path().string(), shown));
  return page;
}

}  // namespace binpick
