#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>

namespace binpick {

/// Hours, minutes and seconds: "1:02:03" or "2:03".
[[nodiscard]] std::string clock_text(double seconds);

/// Progress on stderr: one line that is rewritten on a terminal, plain lines at intervals
/// elsewhere.
class Progress {
 public:
  /// `done` of `total` trials are there already.
  Progress(std::string name, std::int64_t done, std::int64_t total);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void trial_finished(bool success);
  /// From now on `total` trials are expected.
  void expect(std::int64_t total) { total_ = total; }
  /// Shows the state if it is time to.
  void refresh();
  /// Prints a line of its own.
  void log(std::string_view line);

 private:
  using Clock = std::chrono::steady_clock;
  [[nodiscard]] std::string text() const;
  void show();

  std::string name_;
  std::int64_t done_;
  std::int64_t total_;
  std::int64_t finished_ = 0;
  std::int64_t succeeded_ = 0;
  bool terminal_;
  Clock::time_point start_ = Clock::now();
  Clock::time_point shown_ = start_;
};

}  // namespace binpick
