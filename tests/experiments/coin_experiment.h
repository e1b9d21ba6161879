#pragma once

#include <memory>
#include <string>

#include "coin_trial.h"
#include "experiments/experiment.h"

namespace binpick {

inline TrialKindRegistry coin_registry() {
  TrialKindRegistry registry;
  registry.add("coin", [] { return std::make_unique<CoinTrial>(); });
  return registry;
}

/// Three rates times two sides, with paper counts; 20 trials per cell.
inline const std::string kCoinYaml = R"(experiment: coin
title: "Coins <heads> & tails"
kind: coin
seed: 3
trials: 20
time_limit_s: 20
parameters: {rate: 0.6, work_ms: 0}
axes:
  - {name: rate, key: rate, values: [0.3, 0.6, 0.9]}
  - {name: side, key: coin.side, values: [heads, tails], labels: ["up", "down"], columns: true}
paper:
  - {cell: {rate: 0.3}, successes: 3, trials: 10}
  - {cell: {rate: 0.6}, successes: 5, trials: 10}
  - {cell: {rate: 0.9}, successes: 9, trials: 10}
)";

inline Experiment coin_experiment(const std::string& yaml = kCoinYaml) {
  return Experiment::from_text(yaml, "coin.yaml", "/", coin_registry());
}

}  // namespace binpick
