#include "experiments/report_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "experiments/html.h"

namespace binpick {
namespace {

constexpr double kWidth = 340.0;
constexpr double kHeight = 250.0;
constexpr double kLeft = 46.0;
constexpr double kRight = 10.0;
constexpr double kTop = 26.0;
constexpr double kBottom = 40.0;
constexpr double kLegendRow = 13.0;
constexpr int kColours = 4;

/// The step of 1, 2 or 5 times a power of ten that makes about five intervals.
double tick_step(double span) {
  const double raw = span / 5.0;
  const double power = std::pow(10.0, std::floor(std::log10(raw)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= raw * 0.999) return factor * power;
  }
  return 10.0 * power;
}

class Canvas {
 public:
  explicit Canvas(const XyPlot& plot) : plot_(plot) {
    find_ranges();
    svg_ = fmt::format(
        "<svg class=\"plot\" viewBox=\"0 0 {0:.0f} {1:.0f}\" width=\"{0:.0f}\" "
        "height=\"{1:.0f}\" role=\"img\" aria-label=\"{2}\">\n",
        kWidth, kHeight + kLegendRow * static_cast<double>(plot.series.size()),
        html_escape(plot.title));
  }

  std::string draw() {
    text(kLeft, 14.0, "start", plot_.title, " class=\"title\"");
    draw_axes();
    for (const auto& [x, label] : plot_.marks) draw_mark(x, label);
    for (const XyPlot::Line& line : plot_.lines) draw_line(line);
    for (std::size_t i = 0; i < plot_.series.size(); ++i) draw_series(i);
    return svg_ + "</svg>\n";
  }

 private:
  void find_ranges() {
    bool any = false;
    double highest = 0.0;
    for (const PlotSeries& series : plot_.series) {
      for (const PlotPoint& point : series.points) {
        x_ = any ? Interval{std::min(x_.low, point.x), std::max(x_.high, point.x)}
                 : Interval{point.x, point.x};
        any = true;
        highest = std::max({highest, point.y, point.interval ? point.interval->high : 0.0});
      }
    }
    if (x_.high <= x_.low) x_ = {x_.low - 0.5, x_.high + 0.5};
    const double margin = 0.05 * (x_.high - x_.low);
    x_ = {x_.low - margin, x_.high + margin};
    y_top_ = plot_.y_max ? *plot_.y_max : 1.08 * highest;
    if (!(y_top_ > 0.0)) y_top_ = 1.0;
  }

  [[nodiscard]] double x_of(double x) const {
    return kLeft + (kWidth - kLeft - kRight) * (x - x_.low) / (x_.high - x_.low);
  }
  [[nodiscard]] double y_of(double y) const {
    const double clipped = std::clamp(y, 0.0, y_top_);
    return kHeight - kBottom - (kHeight - kTop - kBottom) * clipped / y_top_;
  }
  static std::string colour(std::size_t series) {
    return fmt::format("var(--c{})", series % kColours);
  }
  void text(double x, double y, const char* anchor, const std::string& words,
            const std::string& more = {}) {
    svg_ += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\"{}>{}</text>\n", x, y,
                        anchor, more, html_escape(words));
  }
  void line(double x1, double y1, double x2, double y2, const std::string& look) {
    svg_ += fmt::format("<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" {}/>\n", x1,
                        y1, x2, y2, look);
  }

  void draw_axes() {
    const double y_step = tick_step(y_top_);
    for (double y = 0.0; y <= y_top_ * 1.0001; y += y_step) {
      line(kLeft, y_of(y), kWidth - kRight, y_of(y), "class=\"grid\"");
      text(kLeft - 5.0, y_of(y) + 3.5, "end", fmt::format("{:.4g}", y));
    }
    const double x_step = tick_step(x_.high - x_.low);
    for (double x = std::ceil(x_.low / x_step) * x_step; x <= x_.high; x += x_step) {
      const double shown = std::abs(x) < 1e-9 * x_step ? 0.0 : x;
      line(x_of(x), kHeight - kBottom, x_of(x), kHeight - kBottom + 4.0, "class=\"grid\"");
      text(x_of(x), kHeight - kBottom + 15.0, "middle", fmt::format("{:.4g}", shown));
    }
    text(0.5 * (kLeft + kWidth - kRight), kHeight - 8.0, "middle", plot_.x_label);
    const double middle = 0.5 * (kTop + kHeight - kBottom);
    text(11.0, middle, "middle", plot_.y_label,
         fmt::format(" transform=\"rotate(-90 11 {:.1f})\"", middle));
  }

  void draw_mark(double x, const std::string& label) {
    line(x_of(x), kTop, x_of(x), kHeight - kBottom, "class=\"mark\"");
    // Rates fall from left to right: right of a mark there is room above them, left of it below.
    const bool left = x_of(x) < 0.7 * kWidth;
    text(x_of(x) + (left ? 3.0 : -3.0), left ? kTop + 8.0 : kHeight - kBottom - 5.0,
         left ? "start" : "end", label);
  }

  void draw_line(const XyPlot::Line& each) {
    line(x_of(each.from.x), y_of(each.from.y), x_of(each.to.x), y_of(each.to.y),
         fmt::format("style=\"stroke:{}\" stroke-dasharray=\"5 4\"", colour(each.series)));
  }

  void draw_series(std::size_t i) {
    const PlotSeries& series = plot_.series[i];
    const std::string paint = colour(i);
    std::string path;
    for (const PlotPoint& point : series.points) {
      path +=
          fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", x_of(point.x), y_of(point.y));
    }
    if (series.joined && !path.empty()) {
      svg_ += fmt::format("<path d=\"{}\" fill=\"none\" style=\"stroke:{}\"/>\n", path, paint);
    }
    for (const PlotPoint& point : series.points) {
      if (point.interval) {
        line(x_of(point.x), y_of(point.interval->low), x_of(point.x), y_of(point.interval->high),
             fmt::format("style=\"stroke:{}\" opacity=\"0.55\"", paint));
      }
      svg_ += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"2.8\" style=\"fill:{}\"/>\n",
                          x_of(point.x), y_of(point.y), paint);
    }
    const double y = kHeight + kLegendRow * static_cast<double>(i) + 3.0;
    svg_ += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3.5\" style=\"fill:{}\"/>\n",
                        kLeft + 4.0, y - 3.5, paint);
    text(kLeft + 13.0, y, "start", series.label);
  }

  const XyPlot& plot_;
  Interval x_;
  double y_top_ = 1.0;
  std::string svg_;
};

}  // namespace

std::string xy_plot_svg(const XyPlot& plot) { return Canvas(plot).draw(); }

}  // namespace binpick
