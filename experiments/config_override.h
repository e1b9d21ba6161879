#pragma once

#include <string>

#include "models/config_visitor.h"

namespace binpick {

/// One value put in the place of another: `--set path=value`, or a cell's value of an axis.
struct ConfigOverride {
  std::string path;   ///< keys joined by dots
  std::string value;  ///< YAML: a scalar, or a whole list or mapping in flow style

  /// From `path=value`.
  /// @throws InputError without '=' or with an empty key.
  [[nodiscard]] static ConfigOverride parse(const std::string& text);
  /// A scalar taken literally, whatever characters it contains.
  [[nodiscard]] static ConfigOverride literal(const std::string& path, const std::string& text);
};

/// Reads the override's value into the visited field at its path, with the field's own checks;
/// every other field keeps its value.
/// @throws InputError, naming `origin`, when there is no such path or the value does not fit.
void apply_override(const ConfigOverride& change, const std::string& origin,
                    const ConfigVisitor::Fields& fields);

}  // namespace binpick
