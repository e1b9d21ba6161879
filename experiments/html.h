#pragma once

#include <string>
#include <string_view>

namespace binpick {

/// `text` as it may stand in HTML content and in quoted attributes. Control characters that HTML
/// does not allow are left out.
[[nodiscard]] std::string html_escape(std::string_view text);

}  // namespace binpick
