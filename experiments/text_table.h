#pragma once

#include <string>
#include <vector>

namespace binpick {

/// Columns of right-aligned text under a header.
class TextTable {
 public:
  explicit TextTable(std::vector<std::string> header) : rows_{std::move(header)} {}
  /// A row that is shorter than the header ends with empty cells.
  void add_row(std::vector<std::string> row) { rows_.push_back(std::move(row)); }
  [[nodiscard]] std::string text() const;
  /// The same for a Markdown page; the first column is left-aligned.
  [[nodiscard]] std::string markdown() const;

 private:
  std::vector<std::vector<std::string>> rows_;
};

}  // namespace binpick
