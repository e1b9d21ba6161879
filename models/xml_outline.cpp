#include "models/xml_outline.h"

#include <fmt/format.h>

#include <cctype>
#include <utility>
#include <vector>

#include "models/errors.h"

namespace binpick {
namespace {

bool is_space(char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; }

bool is_name_character(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-' || c == '.' ||
         c == ':';
}

}  // namespace

class XmlOutline::Scanner {
 public:
  Scanner(std::string_view text, XmlOutline& outline) : text_(text), outline_(outline) {}

  void run() {
    bool seen_root = false;
    while (skip_to_tag()) {
      const Position begin = position_;
      if (skip_section("<!--", "-->") || skip_section("<?", "?>") ||
          skip_section("<![CDATA[", "]]>")) {
        continue;
      }
      if (text_.substr(at_).starts_with("<!")) {
        fail(begin, "document types and entities are not read; remove the declaration");
      }
      if (text_.substr(at_).starts_with("</")) {
        close_tag(begin);
      } else {
        if (seen_root && open_.empty()) fail(begin, "a second root element; keep one");
        seen_root = true;
        open_tag(begin);
      }
    }
    if (!open_.empty()) {
      fail(open_.back().second, fmt::format("<{}> is never closed", open_.back().first));
    }
    if (!seen_root) fail(position_, "no XML element; give a URDF");
  }

 private:
  struct Position {
    int line = 1;
    int column = 1;
  };

  [[noreturn]] void fail(const Position& where, std::string_view what) const {
    throw InputError(fmt::format("{}: {}", describe(where), what));
  }

  [[nodiscard]] std::string describe(const Position& where) const {
    return fmt::format("{}:{}:{}", outline_.name_, where.line, where.column);
  }

  void advance(std::size_t count = 1) {
    for (; count > 0 && at_ < text_.size(); --count, ++at_) {
      if (text_[at_] == '\n') {
        ++position_.line;
        position_.column = 1;
      } else {
        ++position_.column;
      }
    }
  }

  bool skip_to_tag() {
    while (at_ < text_.size() && text_[at_] != '<') {
      if (text_[at_] == '\0') fail(position_, "a zero byte; this is not an XML text");
      advance();
    }
    return at_ < text_.size();
  }

  bool skip_section(std::string_view begin, std::string_view end) {
    if (!text_.substr(at_).starts_with(begin)) return false;
    const std::size_t close = text_.find(end, at_ + begin.size());
    if (close == std::string_view::npos) {
      fail(position_, fmt::format("'{}' is never closed by '{}'", begin, end));
    }
    advance(close + end.size() - at_);
    return true;
  }

  std::string read_name(const Position& begin) {
    const std::size_t first = at_;
    while (at_ < text_.size() && is_name_character(text_[at_])) advance();
    if (at_ == first) fail(begin, "'<' without the name of an element");
    return std::string(text_.substr(first, at_ - first));
  }

  void skip_space() {
    while (at_ < text_.size() && is_space(text_[at_])) advance();
  }

  char next(const Position& begin) {
    if (at_ >= text_.size()) fail(begin, "the text ends inside a tag");
    return text_[at_];
  }

  void close_tag(const Position& begin) {
    advance(2);
    const std::string tag = read_name(begin);
    skip_space();
    if (next(begin) != '>') fail(begin, fmt::format("</{}> must end with '>'", tag));
    advance();
    if (open_.empty()) fail(begin, fmt::format("</{}> closes nothing", tag));
    if (open_.back().first != tag) {
      fail(begin, fmt::format("</{}> closes <{}> of line {}", tag, open_.back().first,
                              open_.back().second.line));
    }
    open_.pop_back();
  }

  void open_tag(const Position& begin) {
    advance();
    const std::string tag = read_name(begin);
    while (true) {
      skip_space();
      const char c = next(begin);
      if (c == '>') {
        advance();
        open_.emplace_back(tag, begin);
        if (open_.size() > static_cast<std::size_t>(kMaxDepth)) {
          fail(begin, fmt::format("elements nest deeper than {}", kMaxDepth));
        }
        return;
      }
      if (c == '/') {
        advance();
        if (next(begin) != '>') fail(begin, fmt::format("<{}/> must end with '/>'", tag));
        advance();
        return;
      }
      read_attribute(tag, begin);
    }
  }

  void read_attribute(const std::string& tag, const Position& begin) {
    const Position where = position_;
    const std::string attribute = read_name(where);
    skip_space();
    if (next(begin) != '=') fail(where, fmt::format("attribute '{}' without a value", attribute));
    advance();
    skip_space();
    const char quote = next(begin);
    if (quote != '"' && quote != '\'') {
      fail(where, fmt::format("the value of '{}' must stand in quotes", attribute));
    }
    const std::size_t close = text_.find(quote, at_ + 1);
    if (close == std::string_view::npos) {
      fail(where, fmt::format("the value of '{}' is never closed", attribute));
    }
    const std::string_view value = text_.substr(at_ + 1, close - at_ - 1);
    if (value.find('<') != std::string_view::npos) {
      fail(where, fmt::format("the value of '{}' contains '<'; close its quotes", attribute));
    }
    advance(close + 1 - at_);
    if (attribute == "name") {
      outline_.positions_.try_emplace({tag, std::string(value)}, describe(begin));
    }
  }

  std::string_view text_;
  XmlOutline& outline_;
  std::size_t at_ = 0;
  Position position_;
  std::vector<std::pair<std::string, Position>> open_;
};

XmlOutline::XmlOutline(std::string_view text, std::string name) : name_(std::move(name)) {
  if (text.size() > kMaxBytes) {
    throw InputError(fmt::format("{}: larger than {} MB; this is no URDF", name_, kMaxBytes >> 20));
  }
  Scanner(text, *this).run();
}

std::string XmlOutline::locate(std::string_view tag, std::string_view element) const {
  const auto found = positions_.find({std::string(tag), std::string(element)});
  return found == positions_.end() ? name_ : found->second;
}

}  // namespace binpick
