#pragma once

#include <map>
#include <string>
#include <string_view>
#include <utility>

namespace binpick {

/// Where things stand in an XML text. The constructor checks that tags match and that the text is
/// within bounds: the XML reader behind urdfdom recurses without limit and names no lines.
class XmlOutline {
 public:
  static constexpr std::size_t kMaxBytes = 4u << 20;
  static constexpr int kMaxDepth = 64;

  /// @throws InputError `name:line:col: ...` for a text that is too large or not well nested.
  XmlOutline(std::string_view text, std::string name);

  /// `file:line:col` of the first element `tag` with the attribute name="`element`", or just the
  /// file's name when there is none.
  [[nodiscard]] std::string locate(std::string_view tag, std::string_view element) const;

 private:
  class Scanner;

  std::string name_;
  std::map<std::pair<std::string, std::string>, std::string> positions_;
};

}  // namespace binpick
