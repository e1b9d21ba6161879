#pragma once

#include <csignal>
#include <optional>

#include "experiments/line_pipe.h"

namespace binpick {

/// Turns SIGINT, SIGTERM and SIGHUP into something to poll for as long as it lives, so that a run
/// ends between two steps and never inside one.
class StopSignals {
 public:
  StopSignals();
  ~StopSignals();
  StopSignals(const StopSignals&) = delete;
  StopSignals& operator=(const StopSignals&) = delete;

  /// Readable when a signal has arrived.
  [[nodiscard]] int descriptor() const noexcept { return descriptor_.get(); }
  /// The signal that has arrived, if any.
  [[nodiscard]] std::optional<int> received();

 private:
  sigset_t before_{};
  FileDescriptor descriptor_;
};

}  // namespace binpick
