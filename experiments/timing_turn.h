#pragma once

#include <filesystem>

namespace binpick {

/// While it lives, no other process that takes a turn at the same file runs: trials that measure
/// time must not measure each other. Waits for its turn; a process that dies gives it back.
class TimingTurn {
 public:
  /// @throws IoError when the file cannot be opened or locked.
  explicit TimingTurn(const std::filesystem::path& file);
  ~TimingTurn();
  TimingTurn(const TimingTurn&) = delete;
  TimingTurn& operator=(const TimingTurn&) = delete;

 private:
  int descriptor_ = -1;
};

}  // namespace binpick
