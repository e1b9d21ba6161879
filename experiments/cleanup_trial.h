#pragma once

#include <memory>
#include <string>

#include "experiments/trial_kind.h"
#include "experiments/vision_loop.h"

namespace binpick {

/// Cleaning up the table (IJRR 2012, section 6.3.3): a pile of seven objects, vision in the loop,
/// until the robot believes the table empty. Protocol: docs/cleanup.md.
class CleanupTrial final : public TrialKind {
 public:
  void visit(ConfigVisitor& visitor) override;
  void prepare(const std::filesystem::path& config_directory) override;
  [[nodiscard]] std::vector<std::filesystem::path> input_files(
      const std::filesystem::path& config_directory) const override;
  [[nodiscard]] TrialRecord run(const TrialContext& context) override;

 private:
  void clean_up(const TrialContext& context, TrialRecord& record, VisionLoopResult& result) const;

  std::string scene_;
  VisionLoopParameters loop_;
  std::int64_t looks_before_empty_ = 3;
  std::int64_t max_idle_cycles_ = 30;

  std::string loaded_;  ///< what `cell_` was made from
  std::unique_ptr<VisionCell> cell_;
};

}  // namespace binpick
