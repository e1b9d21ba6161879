#include "experiments/write_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string>

#include "experiments/line_pipe.h"
#include "models/errors.h"

namespace binpick {
namespace {

[[noreturn]] void throw_error(const std::filesystem::path& file) {
  throw IoError(fmt::format("{}: cannot be written ({}); check rights and free space",
                            file.string(), std::strerror(errno)));
}

void write_all(int descriptor, std::string_view content, const std::filesystem::path& file) {
  while (!content.empty()) {
    const ssize_t count = ::write(descriptor, content.data(), content.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) throw_error(file);
    content.remove_prefix(static_cast<std::size_t>(count));
  }
}

}  // namespace

void write_file(const std::filesystem::path& file, std::string_view content) {
  const std::string temporary = fmt::format("{}.{}.part", file.string(), ::getpid());
  FileDescriptor descriptor(
      ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644));
  if (descriptor.get() < 0) throw_error(file);
  try {
    write_all(descriptor.get(), content, file);
    if (::fsync(descriptor.get()) != 0 || std::rename(temporary.c_str(), file.c_str()) != 0) {
      throw_error(file);
    }
  } catch (const IoError&) {
    ::unlink(temporary.c_str());
    throw;
  }
}

void make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error || !std::filesystem::is_directory(folder)) {
    throw IoError(fmt::format("{}: cannot make this folder ({}); give another --out",
                              folder.string(), error ? error.message() : "a file is in its place"));
  }
}

}  // namespace binpick
