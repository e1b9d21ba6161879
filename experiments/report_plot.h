#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "models/geometry.h"

namespace binpick {

struct PlotPoint {
  double x = 0.0;
  double y = 0.0;
  std::optional<Interval> interval;  ///< of y, drawn as a whisker
};

struct PlotSeries {
  std::string label;
  std::vector<PlotPoint> points;
  bool joined = true;  ///< by lines
};

/// Curves or clouds of points over common axes, as in the paper's figures.
struct XyPlot {
  std::string title;
  std::string x_label;
  std::string y_label;
  std::vector<PlotSeries> series;
  /// Vertical reference lines: where, and what they mean.
  std::vector<std::pair<double, std::string>> marks;
  /// Straight lines from the first to the second point, dashed, in the colour of the series.
  struct Line {
    std::size_t series = 0;
    PlotPoint from, to;
  };
  std::vector<Line> lines;
  std::optional<double> y_max;  ///< top of the axis; else from the data. The bottom is 0.
};

/// The plot as SVG, 340 px wide; it takes its colours from the page's variables --c0 to --c3.
[[nodiscard]] std::string xy_plot_svg(const XyPlot& plot);

}  // namespace binpick
