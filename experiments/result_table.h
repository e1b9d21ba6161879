#pragma once

#include <string>
#include <vector>

#include "experiments/result_summary.h"
#include "experiments/text_table.h"

namespace binpick {

/// The final table as text: one row per cell (the values of the column axis side by side), ours
/// with 95 % intervals beside the paper's counts; then what the table as a whole supports, how
/// trials ended, and the gates.
[[nodiscard]] std::string result_table(const Experiment& experiment, const ResultSummary& summary);

/// Its first part alone.
[[nodiscard]] TextTable cell_table(const Experiment& experiment, const ResultSummary& summary);

/// How trials ended, and at which stage.
[[nodiscard]] TextTable outcome_table(const ResultSummary& summary);

/// Sentences about the table as a whole, one per line: homogeneity, compatibility with the paper,
/// paired columns.
[[nodiscard]] std::vector<std::string> table_statements(const Experiment& experiment,
                                                        const ResultSummary& summary);

/// "7/10".
[[nodiscard]] std::string counts_text(const Proportion& proportion);
/// "p = 0.06"; a p value too small for a double is not zero.
[[nodiscard]] std::string p_text(double p);
/// "66.7 %" with one decimal.
[[nodiscard]] std::string percent_text(double rate);
/// The axis' name with the unit that its parameter's name tells, e.g. "K_t_y, N/m".
[[nodiscard]] std::string axis_heading(const AxisConfig& axis);
/// With so many significant digits; large numbers in full, without an exponent.
[[nodiscard]] std::string digits_text(double value, int digits);
/// "[55.9, 76.3] %".
[[nodiscard]] std::string interval_text(const Interval& interval);

}  // namespace binpick
