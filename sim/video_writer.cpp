#include "sim/video_writer.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "models/errors.h"

extern char** environ;

namespace binpick {
namespace {

std::vector<std::string> encoder_arguments(const std::filesystem::path& file, int width, int height,
                                           int frames_per_second) {
  const std::string size = fmt::format("{}x{}", width, height);
  const std::string rate = fmt::format("{}", frames_per_second);
  // Encoding on one thread keeps the file the same on every machine with the same ffmpeg.
  return {"ffmpeg",  "-nostdin",    "-loglevel",  "error",
          "-y",      "-f",          "rawvideo",   "-pixel_format",
          "rgb24",   "-video_size", size,         "-framerate",
          rate,      "-i",          "pipe:0",     "-c:v",
          "libx264", "-threads",    "1",          "-pix_fmt",
          "yuv420p", "-movflags",   "+faststart", file.string()};
}

}  // namespace

VideoWriter::VideoWriter(std::filesystem::path file, int width, int height, int frames_per_second)
    : file_(std::move(file)), width_(width), height_(height) {
  if (width % 2 != 0 || height % 2 != 0) {
    throw std::invalid_argument("a film's width and height must be even");
  }
  // A socket instead of a pipe: writing to an encoder that has died is an error, not a signal.
  int ends[2];
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) {
    throw IoError(file_.string() + ": no pipe to ffmpeg");
  }
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ends[0], STDIN_FILENO);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  std::vector<std::string> arguments = encoder_arguments(file_, width, height, frames_per_second);
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  const int error = ::posix_spawnp(&encoder_, "ffmpeg", &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  ::close(ends[0]);
  pipe_ = ends[1];
  if (error != 0) {
    ::close(std::exchange(pipe_, -1));
    encoder_ = -1;
    throw IoError(file_.string() + ": cannot start ffmpeg; install it to record films");
  }
}

VideoWriter::~VideoWriter() {
  try {
    finish();
  } catch (const IoError&) {
    // Nobody is left to tell.
  }
}

void VideoWriter::add(const ColourImage& frame) {
  if (frame.width != width_ || frame.height != height_) {
    throw std::invalid_argument("a frame's size must be the film's");
  }
  std::size_t sent = 0;
  while (sent < frame.rgb.size()) {
    const ssize_t count =
        ::send(pipe_, frame.rgb.data() + sent, frame.rgb.size() - sent, MSG_NOSIGNAL);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) throw IoError(file_.string() + ": ffmpeg stopped; see its message above");
    sent += static_cast<std::size_t>(count);
  }
}

void VideoWriter::finish() {
  if (pipe_ >= 0) ::close(std::exchange(pipe_, -1));
  if (encoder_ < 0) return;
  int status = 0;
  const pid_t encoder = std::exchange(encoder_, -1);
  while (::waitpid(encoder, &status, 0) < 0 && errno == EINTR) {
  }
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    throw IoError(file_.string() + ": ffmpeg could not write the film");
  }
}

}  // namespace binpick
