#include "experiments/report_figures.h"

#include <fmt/format.h>

namespace binpick {
namespace {

constexpr double kWidth = 120.0;  // px, of the span from 0 to 100 %
constexpr double kMargin = 12.0;  // px, on either side
constexpr double kHeight = 26.0;  // px
constexpr double kMiddle = kHeight / 2.0;

double x_of(double rate) { return kMargin + kWidth * rate; }

std::string open_svg(double height) {
  return fmt::format(
      "<svg class=\"bar\" viewBox=\"0 0 {0:.0f} {1:.0f}\" width=\"{0:.0f}\" "
      "height=\"{1:.0f}\" role=\"img\">",
      kWidth + 2.0 * kMargin, height);
}

std::string grid() {
  std::string lines;
  for (const double rate : {0.0, 0.25, 0.5, 0.75, 1.0}) {
    lines += fmt::format("<line class=\"grid\" x1=\"{0:.1f}\" x2=\"{0:.1f}\" y1=\"0\" y2=\"{1}\"/>",
                         x_of(rate), kHeight);
  }
  return lines;
}

std::string whisker(const Interval& interval) {
  const double low = x_of(interval.low);
  const double high = x_of(interval.high);
  std::string lines =
      fmt::format("<line class=\"whisker\" x1=\"{:.1f}\" x2=\"{:.1f}\" y1=\"{}\" y2=\"{}\"/>", low,
                  high, kMiddle, kMiddle);
  for (const double end : {low, high}) {
    lines +=
        fmt::format("<line class=\"whisker\" x1=\"{0:.1f}\" x2=\"{0:.1f}\" y1=\"{1}\" y2=\"{2}\"/>",
                    end, kMiddle - 5.0, kMiddle + 5.0);
  }
  return lines;
}

std::string diamond(double x, double y) {
  return fmt::format(
      "<path class=\"paper\" d=\"M{:.1f} {:.1f}l5 -5l5 5l-5 5z\"><title>paper</title></path>",
      x - 5.0, y);
}

}  // namespace

std::string rate_bar_svg(const CellSummary& cell) {
  std::string svg = open_svg(kHeight) + grid();
  if (cell.ours.trials > 0) {
    svg += fmt::format(
        "<rect class=\"ours\" x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"12\"/>",
        x_of(0.0), kMiddle - 6.0, kWidth * cell.ours.rate());
    svg += whisker(cell.interval);
  }
  if (cell.paper) svg += diamond(x_of(cell.paper->rate()), kMiddle);
  return svg + "</svg>";
}

std::string rate_legend_svg(bool with_paper) {
  std::string svg = open_svg(kHeight);
  for (const double rate : {0.0, 0.5, 1.0}) {
    svg += fmt::format("<text x=\"{:.1f}\" y=\"10\" text-anchor=\"middle\">{:.0f}</text>",
                       x_of(rate), 100.0 * rate);
  }
  svg +=
      "<rect class=\"ours\" x=\"4\" y=\"17\" width=\"10\" height=\"7\"/>"
      "<text x=\"17\" y=\"24\">ours</text>"
      "<line class=\"whisker\" x1=\"46\" x2=\"56\" y1=\"20\" y2=\"20\"/>"
      "<text x=\"59\" y=\"24\">95 %</text>";
  if (with_paper) svg += diamond(96.0, 20.0) + "<text x=\"104\" y=\"24\">paper</text>";
  return svg + "</svg>";
}

}  // namespace binpick
