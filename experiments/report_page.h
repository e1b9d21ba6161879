#pragma once

#include <string>

namespace binpick {

/// A self-contained HTML page with this title as its heading, and the look that all pages of
/// reports have. `body` is HTML.
[[nodiscard]] std::string report_page(const std::string& title, const std::string& body);

}  // namespace binpick
