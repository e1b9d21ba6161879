#include "experiments/text_table.h"

#include <fmt/format.h>

#include <algorithm>

namespace binpick {

std::string TextTable::text() const {
  std::vector<std::size_t> widths(rows_.front().size(), 0);
  for (const auto& row : rows_) {
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  std::string text;
  for (std::size_t line = 0; line < rows_.size(); ++line) {
    for (std::size_t i = 0; i < rows_[line].size(); ++i) {
      text += fmt::format("{}{:>{}}", i == 0 ? "  " : "   ", rows_[line][i], widths[i]);
    }
    text += '\n';
    if (line > 0) continue;
    for (std::size_t i = 0; i < widths.size(); ++i) {
      text += fmt::format("{}{:->{}}", i == 0 ? "  " : "   ", "", widths[i]);
    }
    text += '\n';
  }
  return text;
}

}  // namespace binpick
