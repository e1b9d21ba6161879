#include "experiments/report_stiffness.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

#include "experiments/html.h"
#include "experiments/report_plot.h"
#include "experiments/result_table.h"
#include "experiments/stiffness_claims.h"

namespace binpick {
namespace {

class StiffnessSection {
 public:
  StiffnessSection(const Experiment& experiment, const TrialTable& trials,
                   const ResultSummary& summary)
      : experiment_(experiment), summary_(summary), planes_(stiffness_planes(experiment, trials)) {}

  std::string html() {
    if (planes_.empty()) return "";
    html_ = "<h2>The stiffness plane</h2>\n";
    if (planes_.size() <= kMostMaps) {
      html_ += "<div class=\"maps\">\n";
      for (const StiffnessPlane& plane : planes_) add_map(plane);
      html_ += "</div>\n";
    } else {
      add_curves();
    }
    add_main_effects();
    add_claims();
    return html_;
  }

 private:
  [[nodiscard]] Proportion ours(std::size_t cell) const { return summary_.cells[cell].ours; }

  void add_map(const StiffnessPlane& plane) {
    html_ += "<div class=\"wide\"><table class=\"map\"><caption>Success in %: " +
             html_escape(plane.name()) + "</caption>\n<tr><th>K_t,y in N/m \\ K_r,x in Nm/rad</th>";
    for (const std::string& value : plane.rotation) html_ += "<th>" + html_escape(value) + "</th>";
    html_ += "</tr>\n";
    for (std::size_t row = 0; row < plane.cells.size(); ++row) {
      html_ += "<tr><th>" + html_escape(plane.translation[row]) + "</th>";
      for (const std::size_t cell : plane.cells[row]) {
        const double percent = 100.0 * ours(cell).rate();
        html_ += ours(cell).trials == 0
                     ? "<td></td>"
                     : fmt::format("<td style=\"--rate:{:.0f}%\" title=\"{}/{}\">{:.0f}</td>",
                                   percent, ours(cell).successes, ours(cell).trials, percent);
      }
      html_ += "</tr>\n";
    }
    html_ += "</table></div>\n";
  }

  // The axis that is swept: the first of the others whose values are numbers.
  [[nodiscard]] std::string swept_axis() const {
    for (const auto& [axis, value] : planes_.front().others) {
      char* end = nullptr;
      (void)std::strtod(value.c_str(), &end);
      if (end != value.c_str() && *end == '\0') return axis;
    }
    return "";
  }

  /// The rate over all cells of a plane, over the swept axis; a curve per value of what remains.
  void add_curves() {
    const std::string swept = swept_axis();
    if (swept.empty()) return;
    const auto& axes = experiment_.config().axes;
    const auto axis = std::find_if(axes.begin(), axes.end(),
                                   [&](const AxisConfig& each) { return each.name == swept; });
    XyPlot plot{"Success over all stiffnesses", axis_heading(*axis), "rate", {}, {}, {}, 1.0};
    for (const StiffnessPlane& plane : planes_) {
      StiffnessPlane rest = plane;
      rest.others.erase(swept);
      const std::string label = rest.name();
      auto series = std::find_if(plot.series.begin(), plot.series.end(),
                                 [&](const PlotSeries& each) { return each.label == label; });
      if (series == plot.series.end()) {
        plot.series.push_back({label, {}});
        series = plot.series.end() - 1;
      }
      const PooledRate rate = plane.pooled(summary_);
      if (rate.counts.trials == 0) continue;
      series->points.push_back({std::strtod(plane.others.at(swept).c_str(), nullptr),
                                rate.counts.rate(), rate.interval});
    }
    html_ += "<div class=\"plots\">\n" + xy_plot_svg(plot) + "</div>\n";
  }

  [[nodiscard]] std::optional<Proportion> paper(const std::vector<std::size_t>& cells) const {
    Proportion sum;
    for (const std::size_t cell : cells) {
      if (!summary_.cells[cell].paper) return std::nullopt;
      sum = sum + *summary_.cells[cell].paper;
    }
    return sum;
  }

  /// Rate and homogeneity test over the values of one stiffness, the other pooled.
  void add_effect(const StiffnessPlane& plane, bool translation) {
    const auto& values = translation ? plane.translation : plane.rotation;
    std::vector<Proportion> levels(values.size());
    std::vector<Proportion> papers;
    std::string rates;
    for (std::size_t level = 0; level < values.size(); ++level) {
      std::vector<std::size_t> cells;
      const std::size_t others = translation ? plane.rotation.size() : plane.translation.size();
      for (std::size_t other = 0; other < others; ++other) {
        cells.push_back(translation ? plane.cells[level][other] : plane.cells[other][level]);
      }
      const PooledRate pooled = summary_.pooled_over(cells);
      levels[level] = pooled.counts;
      rates += fmt::format("{}{}: {} {}", level == 0 ? "" : "<br/>", html_escape(values[level]),
                           percent_text(levels[level].rate()), interval_text(pooled.interval));
      if (const auto counts = paper(cells)) {
        rates += fmt::format(", paper {}/{}", counts->successes, counts->trials);
        papers.push_back(*counts);
      }
    }
    const std::string paper_p =
        papers.size() == values.size() ? fmt::format("{:.2g}", test_homogeneity(papers).p) : "";
    html_ += fmt::format(
        "<tr><td class=\"text\">{}</td><td class=\"text\">{}</td><td class=\"text\">{}</td>"
        "<td>{:.2g}</td><td>{}</td></tr>\n",
        html_escape(plane.name()), translation ? "K_t,y in N/m" : "K_r,x in Nm/rad", rates,
        test_homogeneity(levels).p, paper_p);
  }

  void add_main_effects() {
    if (planes_.size() > kMostMaps) return;
    html_ +=
        "<h3>Main effects</h3>\n<div class=\"wide\"><table>\n<tr><th class=\"text\">trials</th>"
        "<th class=\"text\">stiffness</th><th class=\"text\">rate over the other stiffness</th>"
        "<th>p, all alike</th><th>paper's p</th></tr>\n";
    for (const StiffnessPlane& plane : planes_) {
      add_effect(plane, true);
      add_effect(plane, false);
    }
    html_ +=
        "</table></div>\n<p class=\"lead\">Chi-square test of equal rates; cells share their "
        "trials' draws, so that it errs towards calling them alike.</p>\n";
  }

  void add_claims() {
    if (!planes_.front().outcomes) return;
    html_ +=
        "<h3>What the paper's table suggests, in this world</h3>\n<div class=\"wide\"><table>\n"
        "<tr><th class=\"text\">trials</th><th>rate</th>";
    std::string rows;
    std::vector<StiffnessClaim> claims;
    for (const StiffnessPlane& plane : planes_) {
      if (!plane.outcomes) continue;
      claims = claims_about(plane, experiment_);
      rows += fmt::format("<tr><td class=\"text\">{}</td><td>{}</td>", html_escape(plane.name()),
                          percent_text(plane.pooled(summary_).counts.rate()));
      for (const StiffnessClaim& claim : claims) {
        rows += fmt::format("<td class=\"text\">{:+.1f} {}<br/>{}</td>", 100.0 * claim.difference,
                            interval_text(claim.interval), to_text(claim.verdict));
      }
      rows += "</tr>\n";
    }
    std::string flat;
    for (const double share : flat_claim_shares(planes_.front(), experiment_)) {
      flat += fmt::format("<td class=\"text\">confirmed in {:.1f} %</td>", 100.0 * share);
    }
    for (const StiffnessClaim& claim : claims) {
      html_ += "<th class=\"text\">" + html_escape(claim.text) + "</th>";
    }
    html_ += "</tr>\n" + rows + "<tr><td class=\"text\">flat worlds</td><td>" +
             percent_text(kFlatRate) + "</td>" + flat +
             "</tr>\n</table></div>\n<p class=\"lead\">Differences of rates in points with 95 % "
             "bootstrap intervals over trial numbers; verdicts at 5 % with Holm's correction over "
             "the three. The last line is what worlds of as many trials and one rate in all cells "
             "get.</p>\n";
  }

  const Experiment& experiment_;
  const ResultSummary& summary_;
  std::vector<StiffnessPlane> planes_;
  std::string html_;
};

}  // namespace

std::string stiffness_section(const Experiment& experiment, const TrialTable& trials,
                              const ResultSummary& summary) {
  return StiffnessSection(experiment, trials, summary).html();
}

}  // namespace binpick
