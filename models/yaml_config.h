#pragma once

#include <filesystem>
#include <string>

#include "models/config_visitor.h"

namespace binpick {

/// Reads `file` strictly through `fields`: an unknown or repeated key, a missing required one, a
/// wrong type, unit or range, NaN, an alias or a second document is a problem.
/// @throws InputError with one line `file:line:col: message` per problem, all at once.
void read_yaml(const std::filesystem::path& file, const ConfigVisitor::Fields& fields);

/// As read_yaml, from text; `name` stands for the file in messages.
void read_yaml_text(const std::string& text, const std::string& name,
                    const ConfigVisitor::Fields& fields);

/// Writes the visited fields as YAML; reading it back gives the same values, bit for bit.
[[nodiscard]] std::string write_yaml(const ConfigVisitor::Fields& fields);

}  // namespace binpick
