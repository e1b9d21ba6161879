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

std::string TextTable::markdown() const {
  std::string text;
  const auto add_line = [&](const auto& field_of) {
    for (std::size_t i = 0; i < rows_.front().size(); ++i) text += "| " + field_of(i) + ' ';
    text += "|\n";
  };
  for (const auto& row : rows_) {
    add_line([&](std::size_t i) { return i < row.size() ? row[i] : ""; });
    if (&row != &rows_.front()) continue;
    add_line([](std::size_t i) { return std::string(i == 0 ? ":--" : "--:"); });
  }
  return text;
}

}  // namespace binpick
