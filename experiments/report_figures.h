#pragma once

#include <optional>
#include <string>

#include "experiments/result_summary.h"

namespace binpick {

/// A rate from 0 to 100 % as an SVG bar with its 95 % interval as a whisker, and the paper's rate,
/// if known, as a diamond.
[[nodiscard]] std::string rate_bar_svg(const CellSummary& cell);

/// The scale and the legend of the bars.
[[nodiscard]] std::string rate_legend_svg(bool with_paper);

}  // namespace binpick
