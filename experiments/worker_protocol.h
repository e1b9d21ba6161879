#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "experiments/trial_record.h"

namespace binpick {

// Parent and worker talk in lines of JSON over two pipes; the worker finds them at these
// descriptors, so that nothing that a library prints on stdout can disturb them.
inline constexpr int kWorkerOrders = 3;
inline constexpr int kWorkerReplies = 4;

/// What the parent tells a worker.
struct WorkerOrder {
  enum class Type {
    kSetup,  ///< first line: the experiment, and the cell to prepare
    kTrial,  ///< run one trial
  };
  Type type = Type::kTrial;
  std::string yaml;       ///< kSetup: effective configuration
  std::string directory;  ///< kSetup: where its relative paths start
  /// kTrial: working folder, so that a library that drops a file drops it among the results.
  std::string folder;
  std::size_t cell = 0;
  std::int64_t trial = 0;
};

/// What a worker tells its parent.
struct WorkerReply {
  enum class Type {
    kReady,       ///< prepared, waiting for trials
    kStage,       ///< the running trial entered a stage
    kRecord,      ///< the trial's record; the worker waits for the next
    kInputError,  ///< configuration or files cannot be used; the worker ends
    kFailed,      ///< preparation failed otherwise; the worker ends
  };
  Type type = Type::kReady;
  TrialStage stage = TrialStage::kSetup;
  TrialRecord record{};
  bool ends = false;  ///< kRecord: the worker ends, it cannot be trusted with another trial
  std::string message{};
};

/// One line without its end.
[[nodiscard]] std::string encode(const WorkerOrder& order);
[[nodiscard]] std::string encode(const WorkerReply& reply);
/// Nothing when the line is not one that `encode` writes.
[[nodiscard]] std::optional<WorkerOrder> decode_order(std::string_view line);
[[nodiscard]] std::optional<WorkerReply> decode_reply(std::string_view line);

}  // namespace binpick
