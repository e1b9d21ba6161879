#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "experiments/experiment.h"
#include "experiments/proportions.h"
#include "experiments/result_store.h"
#include "experiments/result_summary.h"

namespace binpick {

/// What the paper's Table 1 suggests about one difference of rates, and what our trials say of it.
struct StiffnessClaim {
  enum class Verdict { kConfirmed, kContradicted, kUndecided };
  std::string text;
  double difference = 0.0;
  Interval interval;  ///< 95 %, bootstrap over trial numbers, which all cells share
  double p = 1.0;     ///< two-sided, bootstrap
  /// At 5 % with Holm's correction over the claims (Holm 1979).
  Verdict verdict = Verdict::kUndecided;
};

/// "confirmed", "contradicted" or "undecided".
[[nodiscard]] std::string_view to_text(StiffnessClaim::Verdict verdict);

/// Successes of the nine cells of Table 1, K_t,y = 200, 750, 2000 N/m by K_r,x = 20, 75, 200 Nm/rad
/// row by row; entry i of all cells is the same trial number.
using StiffnessOutcomes = std::array<std::vector<bool>, 9>;

/// a: soft translation is better; b: the best cell is soft in translation; c: the paper's three
/// best cells are better than the others.
[[nodiscard]] std::vector<StiffnessClaim> judge_stiffness_claims(const StiffnessOutcomes& outcomes,
                                                                 Seed seed);

/// How often each of these claims is confirmed in worlds of `trials` per cell and one rate in all
/// cells, where nothing is to be found.
[[nodiscard]] std::array<double, 3> flat_claim_shares(std::size_t trials, double rate, Seed seed);

/// The cells of a sweep that differ in the two stiffnesses alone.
struct StiffnessPlane {
  std::map<std::string, std::string> others;    ///< values of the other axes, as tables print them
  std::vector<std::string> translation;         ///< values of K_t_y, N/m
  std::vector<std::string> rotation;            ///< values of K_r_x, Nm/rad
  std::vector<std::vector<std::size_t>> cells;  ///< index of the cell, by translation and rotation
  std::optional<StiffnessOutcomes> outcomes;    ///< of Table 1's cells, ten trials each at least

  /// The values of the other axes, e.g. "reaction on"; "all trials" when there are none.
  [[nodiscard]] std::string name() const;
  /// The rate over all its cells. `summary` is that of the plane's experiment.
  [[nodiscard]] PooledRate pooled(const ResultSummary& summary) const;
};

/// With more planes a sweep is shown by the planes' pooled rates, not by a map of each.
inline constexpr std::size_t kMostMaps = 4;

/// Every plane of an experiment with the axes K_t_y and K_r_x, in the order of its cells; empty for
/// other experiments. Trials that a cell lacks are left out of all cells' outcomes.
[[nodiscard]] std::vector<StiffnessPlane> stiffness_planes(const Experiment& experiment,
                                                           const TrialTable& trials);

/// The claims about a plane that has outcomes, with the experiment's own random numbers.
[[nodiscard]] std::vector<StiffnessClaim> claims_about(const StiffnessPlane& plane,
                                                       const Experiment& experiment);

/// What a flat world has when the paper says nothing of its cells: the paper's pooled 60 of 90.
inline constexpr double kFlatRate = 2.0 / 3.0;

/// How often the claims are confirmed in worlds of `kFlatRate` and of the plane's size.
[[nodiscard]] std::array<double, 3> flat_claim_shares(const StiffnessPlane& plane,
                                                      const Experiment& experiment);

}  // namespace binpick
