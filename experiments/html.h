#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace binpick {

/// `text` as it may stand in HTML content and in quoted attributes. Control characters that HTML
/// does not allow are left out.
[[nodiscard]] std::string html_escape(std::string_view text);

/// A table of `rows` rows, as HTML, that scrolls sideways where it is wider than the page; a long
/// one is folded away.
[[nodiscard]] std::string scrolling_table(const std::string& table, std::size_t rows);

}  // namespace binpick
