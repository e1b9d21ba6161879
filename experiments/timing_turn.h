#pragma once

namespace binpick {

/// While it lives, no other process of this user on this machine has a turn: trials that measure
/// time must not measure each other. Waits for its turn; a process that dies gives it back.
class TimingTurn {
 public:
  /// @throws IoError when the lock, a file among the temporary ones, cannot be had.
  TimingTurn();
  ~TimingTurn();
  TimingTurn(const TimingTurn&) = delete;
  TimingTurn& operator=(const TimingTurn&) = delete;

 private:
  int descriptor_ = -1;
};

}  // namespace binpick
