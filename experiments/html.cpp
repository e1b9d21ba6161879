#include "experiments/html.h"

namespace binpick {

std::string html_escape(std::string_view text) {
  std::string escaped;
  escaped.reserve(text.size());
  for (const char c : text) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      case '\'':
        escaped += "&#39;";
        break;
      default: {
        const auto code = static_cast<unsigned char>(c);
        if (code >= 0x20 || c == '\n' || c == '\t') escaped += c;
      }
    }
  }
  return escaped;
}

std::string scrolling_table(const std::string& table, std::size_t rows) {
  constexpr std::size_t kLong = 30;
  const std::string scrolling = "<div class=\"wide\"><table>\n" + table + "</table></div>\n";
  if (rows <= kLong) return scrolling;
  return "<details><summary>" + std::to_string(rows) + " rows</summary>\n" + scrolling +
         "</details>\n";
}

}  // namespace binpick
