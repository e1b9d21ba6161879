#include "experiments/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <utility>

namespace binpick {
namespace {

using std::chrono::duration;

constexpr double kTerminalInterval = 0.2;  // s
constexpr double kPlainInterval = 10.0;    // s

}  // namespace

std::string clock_text(double seconds) {
  const auto whole = static_cast<std::int64_t>(seconds + 0.5);
  if (whole >= 3600) {
    return fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
  }
  return fmt::format("{}:{:02}", whole / 60, whole % 60);
}

Progress::Progress(std::string name, std::int64_t done, std::int64_t total)
    : name_(std::move(name)), done_(done), total_(total), terminal_(::isatty(STDERR_FILENO) == 1) {
  if (done_ > 0) log(fmt::format("{}: {} of {} trials are done already", name_, done_, total_));
}

Progress::~Progress() {
  if (finished_ == 0) return;
  show();
  if (terminal_) std::fputs("\n", stderr);
}

std::string Progress::text() const {
  const double elapsed = duration<double>(Clock::now() - start_).count();
  const std::int64_t done = done_ + finished_;
  std::string line =
      fmt::format("{}: {}/{} trials ({} %), {} of {} succeeded, {} elapsed", name_, done, total_,
                  100 * done / total_, succeeded_, finished_, clock_text(elapsed));
  if (finished_ > 0 && done < total_) {
    const double left =
        elapsed / static_cast<double>(finished_) * static_cast<double>(total_ - done);
    line += fmt::format(", {} left", clock_text(left));
  }
  return line;
}

void Progress::trial_finished(bool success) {
  ++finished_;
  if (success) ++succeeded_;
  refresh();
}

void Progress::refresh() {
  const double interval = terminal_ ? kTerminalInterval : kPlainInterval;
  if (duration<double>(Clock::now() - shown_).count() >= interval) show();
}

void Progress::show() {
  shown_ = Clock::now();
  fmt::print(stderr, "{}{}{}", terminal_ ? "\r\x1b[K" : "", text(), terminal_ ? "" : "\n");
  std::fflush(stderr);
}

void Progress::log(std::string_view line) {
  fmt::print(stderr, "{}{}\n", terminal_ ? "\r\x1b[K" : "", line);
}

}  // namespace binpick
