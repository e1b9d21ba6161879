#include "experiments/stopping_rule.h"

#include <algorithm>
#include <cmath>

namespace binpick {
namespace {

constexpr double kConfidence = 0.95;
constexpr double kLeastCriticalValue = 1.959963984540054;
constexpr double kMostCriticalValue = 5.0;  // covers whatever the rule: 10000 looks, Bonferroni
constexpr int kSteps = 12;                  // of the bisection in between
constexpr double kFarAway = 9.0;            // standard deviations: rarer than 1e-18

double half_width_of(const Interval& interval) { return 0.5 * (interval.high - interval.low); }

/// Shares of all sequences of tosses, by number of successes, after `more` further tosses. Long
/// double holds 2^-16000.
std::vector<long double> toss(const std::vector<long double>& shares, std::int64_t more) {
  std::vector<long double> binomial{1.0L};
  for (std::int64_t i = 0; i < more; ++i) {
    binomial.push_back(0.0L);
    for (std::size_t k = binomial.size(); k-- > 0;) {
      binomial[k] = 0.5L * (binomial[k] + (k > 0 ? binomial[k - 1] : 0.0L));
    }
  }
  std::vector<long double> result(shares.size() + binomial.size() - 1, 0.0L);
  for (std::size_t i = 0; i < shares.size(); ++i) {
    if (shares[i] == 0.0L) continue;
    for (std::size_t j = 0; j < binomial.size(); ++j) result[i + j] += shares[i] * binomial[j];
  }
  return result;
}

}  // namespace

void StoppingRule::visit(ConfigVisitor& visitor) {
  visitor.number("half_width", half_width, {.min = 0.0, .max = 0.5});
  visitor.integer("block", block, 1, kMostSequentialTrials);
}

SequentialPlan::SequentialPlan(const StoppingRule& rule, std::int64_t most)
    : rule_(rule), most_(most), z_(kLeastCriticalValue), ends_(find_ends()) {
  if (covers_enough()) return;
  double small = kLeastCriticalValue;
  double large = kMostCriticalValue;
  for (int step = 0; step < kSteps; ++step) {
    z_ = 0.5 * (small + large);
    ends_ = find_ends();
    (covers_enough() ? large : small) = z_;
  }
  z_ = large;
  ends_ = find_ends();
}

std::int64_t SequentialPlan::next_look(std::int64_t trials) const {
  return std::min(trials + rule_.block, most_);
}

Interval SequentialPlan::interval(const Proportion& proportion) const {
  return agresti_coull_interval(proportion, z_);
}

bool SequentialPlan::enough(const Proportion& proportion) const {
  return proportion.trials >= most_ || half_width_of(interval(proportion)) <= rule_.half_width;
}

std::int64_t SequentialPlan::size(const std::vector<bool>& successes) const {
  Proportion proportion;
  for (;;) {
    const std::int64_t look = next_look(proportion.trials);
    if (look > static_cast<std::int64_t>(successes.size())) return look;
    const auto begin = successes.begin() + proportion.trials;
    proportion.successes += std::count(begin, successes.begin() + look, true);
    proportion.trials = look;
    if (enough(proportion)) return look;
  }
}

std::vector<SequentialPlan::End> SequentialPlan::find_ends() const {
  std::vector<End> ends;
  std::vector<long double> shares{1.0L};  // of all sequences, those still going on
  for (std::int64_t trials = 0; trials < most_;) {
    const std::int64_t look = next_look(trials);
    shares = toss(shares, look - trials);
    trials = look;
    for (std::int64_t k = 0; k <= trials; ++k) {
      long double& share = shares[static_cast<std::size_t>(k)];
      if (share == 0.0L) continue;
      const Proportion result{k, trials};
      if (!enough(result)) continue;
      const double log_ways =
          static_cast<double>(std::log(share)) + static_cast<double>(trials) * std::log(2.0);
      ends.push_back({result, interval(result), log_ways});
      share = 0.0L;
    }
  }
  return ends;
}

double SequentialPlan::coverage(double p) const {
  double covered = 0.0;
  for (const End& end : ends_) {
    if (p < end.interval.low || p > end.interval.high) continue;
    const auto n = static_cast<double>(end.result.trials);
    const auto k = static_cast<double>(end.result.successes);
    if (std::abs(k - n * p) > kFarAway * std::sqrt(n * p * (1.0 - p)) + kFarAway) continue;
    covered += std::exp(end.log_ways + k * std::log(p) + (n - k) * std::log1p(-p));
  }
  return covered;
}

bool SequentialPlan::covers_enough() const {
  // Coverage falls at the ends of intervals, so its least values lie next to them. It is symmetric.
  return std::all_of(ends_.begin(), ends_.end(), [&](const End& end) {
    const auto fine = [&](double p) { return p <= 0.0 || p > 0.5 || coverage(p) >= kConfidence; };
    return fine(std::nextafter(end.interval.low, 0.0)) &&
           fine(std::nextafter(end.interval.high, 1.0));
  });
}

}  // namespace binpick
