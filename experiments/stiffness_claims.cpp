#include "experiments/stiffness_claims.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "models/random.h"

namespace binpick {
namespace {

constexpr std::size_t kCells = 9;
constexpr std::size_t kClaims = 3;
constexpr int kResamples = 2000;
constexpr int kFlatWorlds = 200;
constexpr int kFlatResamples = 400;
constexpr double kSignificance = 0.05;
// With fewer, resampling finds differences where there are none.
constexpr std::size_t kFewestTrials = 10;
const std::vector<std::string> kTranslation{"200", "750", "2000"};
const std::vector<std::string> kRotation{"20", "75", "200"};

using Rates = std::array<double, kCells>;
using Differences = std::array<double, kClaims>;

double mean(const Rates& rates, std::initializer_list<std::size_t> cells) {
  double sum = 0.0;
  for (const std::size_t cell : cells) sum += rates[cell];
  return sum / static_cast<double>(cells.size());
}

Differences differences(const Rates& rates) {
  return {mean(rates, {0, 1, 2}) - mean(rates, {6, 7, 8}),
          *std::max_element(rates.begin(), rates.begin() + 3) -
              *std::max_element(rates.begin() + 3, rates.end()),
          mean(rates, {1, 2, 4}) - mean(rates, {0, 3, 5, 6, 7, 8})};
}

struct Estimate {
  double difference = 0.0;
  Interval interval;
  double p = 1.0;
};

/// The claims' estimates when `resample` draws tables like the one that was seen.
std::array<Estimate, kClaims> estimate(const Rates& seen, int resamples,
                                       const std::function<Rates()>& resample) {
  std::array<std::vector<double>, kClaims> samples;
  for (int i = 0; i < resamples; ++i) {
    const Differences drawn = differences(resample());
    for (std::size_t claim = 0; claim < kClaims; ++claim) samples[claim].push_back(drawn[claim]);
  }
  const Differences differences_seen = differences(seen);
  std::array<Estimate, kClaims> estimates;
  for (std::size_t claim = 0; claim < kClaims; ++claim) {
    std::vector<double>& values = samples[claim];
    std::sort(values.begin(), values.end());
    const auto at = [&](double share) {
      return values[static_cast<std::size_t>(share * static_cast<double>(values.size()))];
    };
    const auto below = std::upper_bound(values.begin(), values.end(), 0.0) - values.begin();
    const auto above = values.end() - std::lower_bound(values.begin(), values.end(), 0.0);
    const double p = 2.0 * (static_cast<double>(std::min(below, above)) + 1.0) / (resamples + 1.0);
    estimates[claim] = {differences_seen[claim], {at(0.025), at(0.975)}, std::min(1.0, p)};
  }
  return estimates;
}

/// Holm: the smallest p against 5 % / 3, the next against 5 % / 2, ... until one fails.
std::array<StiffnessClaim::Verdict, kClaims> verdicts(
    const std::array<Estimate, kClaims>& estimates) {
  std::array<std::size_t, kClaims> order{};
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return estimates[a].p < estimates[b].p; });
  std::array<StiffnessClaim::Verdict, kClaims> result;
  result.fill(StiffnessClaim::Verdict::kUndecided);
  for (std::size_t rank = 0; rank < kClaims; ++rank) {
    const Estimate& each = estimates[order[rank]];
    if (each.p > kSignificance / static_cast<double>(kClaims - rank)) break;
    result[order[rank]] = each.difference > 0.0 ? StiffnessClaim::Verdict::kConfirmed
                                                : StiffnessClaim::Verdict::kContradicted;
  }
  return result;
}

Seed stiffness_seed(const Experiment& experiment) {
  return derive_seed(static_cast<Seed>(experiment.config().seed), "stiffness");
}

std::optional<std::size_t> axis_named(const ExperimentConfig& config, const std::string& name) {
  for (std::size_t i = 0; i < config.axes.size(); ++i) {
    if (config.axes[i].name == name) return i;
  }
  return std::nullopt;
}

std::optional<StiffnessOutcomes> outcomes_of(const StiffnessPlane& plane,
                                             const Experiment& experiment,
                                             const TrialTable& trials) {
  if (plane.translation != kTranslation || plane.rotation != kRotation) return std::nullopt;
  StiffnessOutcomes outcomes;
  for (std::int64_t trial = 0; trial < experiment.config().trials; ++trial) {
    std::array<bool, kCells> row{};
    bool complete = true;
    for (std::size_t i = 0; i < kCells && complete; ++i) {
      const auto found = trials.find({experiment.cells()[plane.cells[i / 3][i % 3]].key, trial});
      complete = found != trials.end();
      row[i] = complete && found->second.record.outcome == TrialOutcome::kSuccess;
    }
    if (!complete) continue;
    for (std::size_t i = 0; i < kCells; ++i) outcomes[i].push_back(row[i]);
  }
  if (outcomes.front().size() < kFewestTrials) return std::nullopt;
  return outcomes;
}

}  // namespace

std::string_view to_text(StiffnessClaim::Verdict verdict) {
  switch (verdict) {
    case StiffnessClaim::Verdict::kConfirmed:
      return "confirmed";
    case StiffnessClaim::Verdict::kContradicted:
      return "contradicted";
    case StiffnessClaim::Verdict::kUndecided:
      break;
  }
  return "undecided";
}

std::string StiffnessPlane::name() const {
  std::string name;
  for (const auto& [axis, value] : others) {
    name += fmt::format("{}{} {}", name.empty() ? "" : ", ", axis, value);
  }
  return name.empty() ? "all trials" : name;
}

PooledRate StiffnessPlane::pooled(const ResultSummary& summary) const {
  std::vector<std::size_t> all;
  for (const auto& row : cells) all.insert(all.end(), row.begin(), row.end());
  return summary.pooled_over(all);
}

std::vector<StiffnessClaim> judge_stiffness_claims(const StiffnessOutcomes& outcomes, Seed seed) {
  const std::size_t trials = outcomes.front().size();
  const auto rates_of = [&](const auto& trial_number) {
    std::array<std::size_t, kCells> counts{};
    for (std::size_t i = 0; i < trials; ++i) {
      const std::size_t trial = trial_number(i);
      for (std::size_t cell = 0; cell < kCells; ++cell) counts[cell] += outcomes[cell][trial];
    }
    Rates rates{};
    for (std::size_t cell = 0; cell < kCells; ++cell) {
      rates[cell] = static_cast<double>(counts[cell]) / static_cast<double>(trials);
    }
    return rates;
  };
  Random random(derive_seed(seed, "claims"));
  const auto estimates = estimate(rates_of([](std::size_t i) { return i; }), kResamples, [&] {
    return rates_of([&](std::size_t) { return std::size_t(random.index(trials)); });
  });
  const auto judged = verdicts(estimates);
  constexpr std::array kTexts{"a: soft translation is better, K_t,y = 200 against 2000 N/m",
                              "b: the best cell is soft in translation",
                              "c: the paper's three best cells are better than the other six"};
  std::vector<StiffnessClaim> claims;
  for (std::size_t i = 0; i < kClaims; ++i) {
    const Estimate& each = estimates[i];
    claims.push_back({kTexts[i], each.difference, each.interval, each.p, judged[i]});
  }
  return claims;
}

// Counts are drawn from the normal distribution that those of many trials come near to.
std::array<double, 3> flat_claim_shares(std::size_t trials, double rate, Seed seed) {
  const double n = static_cast<double>(trials);
  const auto draw_rate = [n](double truth, Random& random) {
    const double count = n * truth + std::sqrt(n * truth * (1.0 - truth)) * random.normal();
    return std::clamp(std::round(count), 0.0, n) / n;
  };
  std::array<double, kClaims> shares{};
  for (int world = 0; world < kFlatWorlds; ++world) {
    Random random(derive_seed(seed, static_cast<std::uint64_t>(world)));
    Rates seen{};
    for (double& each : seen) each = draw_rate(rate, random);
    const auto found = verdicts(estimate(seen, kFlatResamples, [&] {
      Rates drawn{};
      for (std::size_t cell = 0; cell < kCells; ++cell) drawn[cell] = draw_rate(seen[cell], random);
      return drawn;
    }));
    for (std::size_t claim = 0; claim < kClaims; ++claim) {
      const bool confirmed = found[claim] == StiffnessClaim::Verdict::kConfirmed;
      shares[claim] += confirmed ? 1.0 / kFlatWorlds : 0.0;
    }
  }
  return shares;
}

std::vector<StiffnessPlane> stiffness_planes(const Experiment& experiment,
                                             const TrialTable& trials) {
  const ExperimentConfig& config = experiment.config();
  const auto translation = axis_named(config, "K_t_y");
  const auto rotation = axis_named(config, "K_r_x");
  if (!translation || !rotation) return {};
  std::vector<StiffnessPlane> planes;
  for (const Cell& cell : experiment.cells()) {
    std::map<std::string, std::string> others;
    for (std::size_t axis = 0; axis < config.axes.size(); ++axis) {
      if (axis == translation || axis == rotation) continue;
      others[config.axes[axis].name] = config.axes[axis].label(cell.values[axis]);
    }
    auto plane = std::find_if(planes.begin(), planes.end(),
                              [&](const StiffnessPlane& each) { return each.others == others; });
    if (plane == planes.end()) {
      const auto& rows = config.axes[*translation].values;
      const auto& columns = config.axes[*rotation].values;
      planes.push_back({others, rows, columns, {}, std::nullopt});
      plane = planes.end() - 1;
      plane->cells.assign(rows.size(), std::vector<std::size_t>(columns.size()));
    }
    plane->cells[cell.values[*translation]][cell.values[*rotation]] = cell.index;
  }
  for (StiffnessPlane& plane : planes) plane.outcomes = outcomes_of(plane, experiment, trials);
  return planes;
}

std::vector<StiffnessClaim> claims_about(const StiffnessPlane& plane,
                                         const Experiment& experiment) {
  return judge_stiffness_claims(*plane.outcomes,
                                derive_seed(stiffness_seed(experiment), plane.name()));
}

std::array<double, 3> flat_claim_shares(const StiffnessPlane& plane, const Experiment& experiment) {
  return flat_claim_shares(plane.outcomes->front().size(), kFlatRate, stiffness_seed(experiment));
}

}  // namespace binpick
