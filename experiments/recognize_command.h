#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "models/random.h"

namespace binpick {

/// What `binpick recognize` is told. Files are given as FILE[:unit], unit `m` (default) or `mm`.
struct RecognizeArguments {
  std::vector<std::string> models;
  std::string scene;
  Seed seed = 1;
  int jobs = 1;
  std::string setting = "default";  ///< or "paper"
  std::string viewpoint = "0,0,0";  ///< of the sensor in the scene's frame, m
  std::string picture;              ///< PNG file to draw the detections into; empty for none
  bool json = false;                ///< machine-readable result on stdout
};

/// Recognizes the models in the scene and prints the detections; returns the exit code.
/// @throws InputError for files, units and options that cannot be used; IoError.
int recognize_command(const RecognizeArguments& arguments);

/// `binpick recognize --model FILE[:unit] ... --scene FILE[:unit]`.
void add_recognize_command(CLI::App& app, int& exit_code);

}  // namespace binpick
