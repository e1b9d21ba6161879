#pragma once

#include <sys/types.h>

#include <filesystem>

#include "sim/renderer.h"

namespace binpick {

/// Writes an H.264 film by piping raw frames to the `ffmpeg` program.
class VideoWriter {
 public:
  /// @throws IoError when ffmpeg cannot be started.
  VideoWriter(std::filesystem::path file, int width, int height, int frames_per_second);
  /// Ends the film; errors are lost, call finish() to see them.
  ~VideoWriter();
  VideoWriter(const VideoWriter&) = delete;
  VideoWriter& operator=(const VideoWriter&) = delete;

  /// Appends a frame of the size given at the start. @throws IoError
  void add(const ColourImage& frame);
  /// Ends the film and waits for ffmpeg. @throws IoError when the film could not be written.
  void finish();

 private:
  std::filesystem::path file_;
  int width_;
  int height_;
  int pipe_ = -1;
  pid_t encoder_ = -1;
};

}  // namespace binpick
