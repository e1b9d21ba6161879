#pragma once

#include <string>

#include "experiments/trial_kind.h"

namespace binpick {

/// A trial kind for tests of the machinery: a coin that succeeds with a given rate, and that
/// misbehaves on demand.
class CoinTrial final : public TrialKind {
 public:
  void visit(ConfigVisitor& visitor) override;
  void prepare(const std::filesystem::path& config_directory) override;
  [[nodiscard]] std::vector<std::filesystem::path> input_files(
      const std::filesystem::path& config_directory) const override;
  [[nodiscard]] TrialRecord run(const TrialContext& context) override;

 private:
  [[nodiscard]] bool faulty(const TrialContext& context) const;
  void misbehave() const;

  double rate_ = 0.5;
  double work_ = 0.0;  ///< s of sleep per trial
  std::string fault_ = "none";
  std::int64_t period_ = 1;  ///< every period-th trial has the fault
  std::string side_ = "heads";
  std::string note_;
  std::string input_;  ///< a file beside the configuration; its size becomes a measure
  std::uintmax_t input_size_ = 0;
};

}  // namespace binpick
