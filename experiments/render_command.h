#pragma once

#include <CLI/CLI.hpp>

namespace binpick {

/// `binpick render SCENE --out DIR`: pictures of a scene as the camera and as a visitor sees it.
void add_render_command(CLI::App& app, int& exit_code);

}  // namespace binpick
