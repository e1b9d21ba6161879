#include "experiments/contact_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "experiments/contact_trial.h"
#include "experiments/html.h"

namespace binpick {
namespace {

constexpr double kWidth = 330.0;   // px, one plot
constexpr double kHeight = 120.0;  // px
constexpr double kLeft = 44.0;
constexpr double kRight = 6.0;
constexpr double kTop = 16.0;
constexpr double kBottom = 18.0;
constexpr std::size_t kPointsPerCurve = 600;
// Around the first touch, for the force that is over within hundredths of a second.
constexpr Interval kTouchWindow{-0.02, 0.15};  // s
constexpr double kTouch = 1e-6;                // N

/// One run of a panel: the paper draws slow ones red and fast ones blue.
struct Run {
  std::string colour;
  std::string label;
  ContactSeries series;
};
struct Panel {
  std::string title;
  std::vector<Run> runs;
};

/// What one row of plots shows.
struct Quantity {
  std::string title;
  std::function<double(const ContactSample&)> measured;
  std::function<double(const ContactSample&)> desired;   ///< dashed; may be empty
  std::function<double(const ContactSample&)> estimate;  ///< dotted; may be empty
  bool around_touch = false;
};

std::vector<Quantity> quantities() {
  const auto force = [](const ContactSample& s) { return s.true_force; };
  const auto estimate = [](const ContactSample& s) { return s.estimated_force; };
  const auto spring = [](const ContactSample& s) { return s.spring_force; };
  return {
      {"F_z in N; dotted: estimate, dashed: virtual spring", force, spring, estimate},
      {"the same around the first touch", force, spring, estimate, true},
      {"height z in mm, dashed: desired", [](const ContactSample& s) { return 1e3 * s.height; },
       [](const ContactSample& s) { return 1e3 * s.desired_height; }, nullptr},
      {"velocity in m/s, dashed: desired", [](const ContactSample& s) { return s.velocity; },
       [](const ContactSample& s) { return s.desired_velocity; }, nullptr},
      {"collision signal hf1", [](const ContactSample& s) { return s.collision ? 1.0 : 0.0; },
       nullptr, nullptr},
  };
}

double touch_time(const ContactSeries& series) {
  const auto touch = std::find_if(series.begin(), series.end(), [](const ContactSample& sample) {
    return sample.true_force > kTouch;
  });
  return touch == series.end() ? 0.0 : touch->time;
}

void widen(Interval& range, double value) {
  range = {std::min(range.low, value), std::max(range.high, value)};
}

/// Small multiples share their axes.
struct Axes {
  Interval x{0.0, 0.0};
  Interval y{0.0, 0.0};
};

Axes common_axes(const std::vector<Panel>& panels, const Quantity& quantity) {
  Axes axes;
  if (quantity.around_touch) axes.x = kTouchWindow;
  for (const Panel& panel : panels) {
    for (const Run& run : panel.runs) {
      for (const ContactSample& sample : run.series) {
        for (const auto* value : {&quantity.measured, &quantity.desired, &quantity.estimate}) {
          if (*value) widen(axes.y, (*value)(sample));
        }
        if (!quantity.around_touch) widen(axes.x, sample.time);
      }
    }
  }
  const double margin = 0.05 * std::max(axes.y.high - axes.y.low, 1e-9);
  axes.y = {axes.y.low - margin, axes.y.high + margin};
  return axes;
}

/// A step of 1, 2 or 5 times a power of ten that makes three to six intervals.
double tick_step(const Interval& range) {
  const double raw = (range.high - range.low) / 6.0;
  const double power = std::pow(10.0, std::floor(std::log10(raw)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= raw) return factor * power;
  }
  return 10.0 * power;
}

class Plot {
 public:
  Plot(const Axes& axes, const std::string& title) : axes_(axes) {
    svg_ = fmt::format(
        "<svg class=\"plot\" viewBox=\"0 0 {0:.0f} {1:.0f}\" width=\"{0:.0f}\" height=\"{1:.0f}\" "
        "role=\"img\" aria-label=\"{2}\">\n<text x=\"{3}\" y=\"11\">{2}</text>\n",
        kWidth, kHeight, html_escape(title), kLeft);
    draw_grid();
  }

  void draw(const Run& run, const std::function<double(const ContactSample&)>& value,
            double time_zero, const std::string& look) {
    if (!value) return;
    const std::size_t stride =
        axes_.x.high > 0.5 ? std::max<std::size_t>(run.series.size() / kPointsPerCurve, 1) : 1;
    std::string path;
    for (std::size_t first = 0; first < run.series.size(); first += stride) {
      // Of the samples that fall together, the extreme one: peaks stay peaks.
      const ContactSample* shown = &run.series[first];
      for (std::size_t i = first; i < std::min(first + stride, run.series.size()); ++i) {
        if (std::abs(value(run.series[i])) > std::abs(value(*shown))) shown = &run.series[i];
      }
      const double t = shown->time - time_zero;
      if (t < axes_.x.low || t > axes_.x.high) continue;
      path +=
          fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", x_of(t), y_of(value(*shown)));
    }
    svg_ += fmt::format("<path d=\"{}\" fill=\"none\" style=\"stroke:{}\" {}/>\n", path, run.colour,
                        look);
  }

  [[nodiscard]] std::string svg() const { return svg_ + "</svg>\n"; }

 private:
  [[nodiscard]] double x_of(double x) const {
    return kLeft + (kWidth - kLeft - kRight) * (x - axes_.x.low) / (axes_.x.high - axes_.x.low);
  }
  [[nodiscard]] double y_of(double y) const {
    return kHeight - kBottom -
           (kHeight - kTop - kBottom) * (y - axes_.y.low) / (axes_.y.high - axes_.y.low);
  }

  void draw_grid() {
    const auto text = [&](double x, double y, const char* anchor, double value, double step) {
      const double shown = std::abs(value) < 1e-9 * step ? 0.0 : value;
      svg_ += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{:.4g}</text>\n", x,
                          y, anchor, shown);
    };
    const auto line = [&](double x1, double y1, double x2, double y2) {
      svg_ += fmt::format(
          "<line class=\"grid\" x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\"/>\n", x1,
          y1, x2, y2);
    };
    const double y_step = tick_step(axes_.y);
    for (double y = std::ceil(axes_.y.low / y_step) * y_step; y <= axes_.y.high; y += y_step) {
      line(kLeft, y_of(y), kWidth - kRight, y_of(y));
      text(kLeft - 4.0, y_of(y) + 3.5, "end", y, y_step);
    }
    const double x_step = tick_step(axes_.x);
    for (double x = std::ceil(axes_.x.low / x_step) * x_step; x <= axes_.x.high; x += x_step) {
      line(x_of(x), kHeight - kBottom, x_of(x), kHeight - kBottom + 3.0);
      text(x_of(x), kHeight - kBottom + 13.0, "middle", x, x_step);
    }
  }

  Axes axes_;
  std::string svg_;
};

std::string plot_panel(const Panel& panel, const Quantity& quantity, const Axes& axes) {
  Plot plot(axes, quantity.title);
  for (const Run& run : panel.runs) {
    const double zero = quantity.around_touch ? touch_time(run.series) : 0.0;
    plot.draw(run, quantity.desired, zero, "stroke-dasharray=\"5 4\" opacity=\"0.7\"");
    plot.draw(run, quantity.estimate, zero, "stroke-dasharray=\"1.5 2.5\"");
    plot.draw(run, quantity.measured, zero, "stroke-width=\"1.4\"");
  }
  return plot.svg();
}

/// Panels by all axes but `speed`, whose values are the runs of a panel.
std::vector<Panel> simulate(const Experiment& experiment, TrialKind& kind, ContactTrial& contact) {
  static const std::vector<std::string> kColours{"#c0392b", "#2f7ebc", "#1f7a3d", "#8e5aa8"};
  std::vector<Panel> panels;
  for (const Cell& cell : experiment.cells()) {
    std::string title;
    Run run;
    for (std::size_t i = 0; i < cell.values.size(); ++i) {
      const AxisConfig& axis = experiment.config().axes[i];
      const std::string value = axis.name + " " + axis.label(cell.values[i]);
      if (axis.name != "speed") {
        const std::string unit = axis.name == "stiffness" ? " N/m" : "";
        title += (title.empty() ? "" : ", ") + value + unit;
        continue;
      }
      run.colour = kColours[cell.values[i] % kColours.size()];
      run.label = value + " m/s";
    }
    experiment.assign(cell, kind);
    kind.prepare(experiment.directory());
    run.series = contact.time_series({experiment.seeds(cell, 0), 0, {}, {}, {}});
    const auto panel = std::find_if(panels.begin(), panels.end(),
                                    [&](const Panel& each) { return each.title == title; });
    if (panel == panels.end()) {
      panels.push_back({title, {std::move(run)}});
    } else {
      panel->runs.push_back(std::move(run));
    }
  }
  return panels;
}

}  // namespace

std::string contact_section(const Experiment& experiment) {
  const std::unique_ptr<TrialKind> kind = experiment.make_kind();
  auto* contact = dynamic_cast<ContactTrial*>(kind.get());
  if (contact == nullptr) return "";
  const std::vector<Panel> panels = simulate(experiment, *kind, *contact);

  std::string html = "<h2>Force, height and velocity over time (s)</h2>\n<p>";
  for (const Run& run : panels.front().runs) {
    html += fmt::format("<span style=\"color:{}\">&#9632;</span> {} ", run.colour,
                        html_escape(run.label));
  }
  html += "</p>\n<div class=\"plots\">\n";
  std::vector<Axes> axes;
  for (const Quantity& quantity : quantities()) axes.push_back(common_axes(panels, quantity));
  for (const Panel& panel : panels) {
    html += "<div><b>" + html_escape(panel.title) + "</b>\n";
    for (std::size_t i = 0; i < axes.size(); ++i) {
      html += plot_panel(panel, quantities()[i], axes[i]);
    }
    html += "</div>\n";
  }
  return html + "</div>\n";
}

}  // namespace binpick
