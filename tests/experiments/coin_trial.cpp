#include "coin_trial.h"

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <thread>

#include "models/errors.h"

namespace binpick {

void CoinTrial::visit(ConfigVisitor& visitor) {
  visitor.number("rate", rate_, {.min = 0.0, .max = 1.0});
  visitor.number("work_ms", work_, {.min = 0.0, .max = 1e6, .unit = 1e-3});
  visitor.choice("fault", fault_, {"none", "abort", "hang", "spin", "throw", "print", "drop_file"});
  visitor.integer("fault_period", period_, 1, 1'000'000);
  visitor.group("coin", [&](ConfigVisitor& inner) { inner.text("side", side_); });
  visitor.text("note", note_);
  visitor.text("input", input_);
}

void CoinTrial::prepare(const std::filesystem::path& config_directory) {
  input_size_ = 0;
  if (input_.empty()) return;
  const std::filesystem::path file = config_directory / input_;
  if (!std::filesystem::exists(file)) {
    throw InputError(file.string() + ":1:1: no such file, check `input`");
  }
  input_size_ = std::filesystem::file_size(file);
}

std::vector<std::filesystem::path> CoinTrial::input_files(
    const std::filesystem::path& config_directory) const {
  if (input_.empty() || input_ == "loaded_late") return {};
  return {config_directory / input_};
}

bool CoinTrial::faulty(const TrialContext& context) const {
  return fault_ != "none" && context.trial % period_ == period_ - 1;
}

void CoinTrial::misbehave() const {
  if (fault_ == "abort") std::abort();
  if (fault_ == "hang") std::this_thread::sleep_for(std::chrono::hours(1));
  if (fault_ == "spin") {
    const auto end = std::chrono::steady_clock::now() + std::chrono::hours(1);
    while (std::chrono::steady_clock::now() < end) continue;
  }
  if (fault_ == "throw") throw std::runtime_error("the coin\nrolled away");
  if (fault_ == "print") std::puts("{\"record\":\"a line on stdout that is no reply\"}");
  if (fault_ == "drop_file") std::ofstream("DROPPED.TXT") << "as some libraries do";
}

TrialRecord CoinTrial::run(const TrialContext& context) {
  context.enter(TrialStage::kGrasp);
  std::this_thread::sleep_for(std::chrono::duration<double>(work_));
  if (faulty(context)) misbehave();
  const double shared = Random(context.seeds.shared("toss")).uniform();
  const double own = Random(context.seeds.own("toss")).uniform();
  TrialRecord record;
  record.measures = {{"shared_toss", shared}, {"own_toss", own}};
  if (input_size_ > 0) record.measures["input_size"] = double(input_size_);
  record.note = note_;
  if (own < rate_) return record;
  record.outcome = side_ == "heads" ? TrialOutcome::kFailedGrasp : TrialOutcome::kSlipped;
  record.stage = TrialStage::kCarry;
  return record;
}

}  // namespace binpick
