#include "experiments/reproduce_line.h"

#include <fmt/format.h>

namespace binpick {

std::string shell_word(const std::string& text) {
  constexpr std::string_view kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./=,:+@%";
  if (!text.empty() && text.find_first_not_of(kPlain) == std::string::npos) return text;
  std::string quoted(1, '\'');
  for (const char c : text) {
    if (c == '\'') quoted += "'\\'";
    quoted += c;
  }
  quoted += '\'';
  return quoted;
}

std::string reproduce_line(const std::string& folder, const TrialKey& key) {
  return fmt::format("binpick reproduce {} --cell {} --trial {}", shell_word(folder),
                     shell_word(key.cell), key.trial);
}

}  // namespace binpick
