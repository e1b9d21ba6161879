#pragma once

#include <cstdint>
#include <vector>

#include "experiments/proportions.h"
#include "models/config_visitor.h"

namespace binpick {

/// Sequential plans are computed path by path; more trials are a matter of fixed sizes.
inline constexpr std::int64_t kMostSequentialTrials = 10'000;

/// "Until the half-width is below x, or n = N": when a cell has enough trials. Looked at after
/// every block of trials, in the order of their numbers, so that neither the number of workers nor
/// an interruption has a say. N is the experiment's number of trials.
struct StoppingRule {
  double half_width = 0.0;  ///< of the 95 % interval of a cell's rate; 0: always N trials
  std::int64_t block = 50;

  [[nodiscard]] bool active() const { return half_width > 0.0; }
  void visit(ConfigVisitor& visitor);
};

/// A stopping rule with its intervals. Whoever looks at a plain 95 % interval again and again and
/// stops when it is narrow has one that covers less than it says. Here the interval is that of
/// Agresti and Coull with the smallest critical value for which the interval of the *stopped*
/// sample covers at least 95 % whatever the true rate. Coverage is computed exactly, by counting
/// the ways to every result at which sampling ends (Frey 2010, The American Statistician 64,
/// 242-249).
class SequentialPlan {
 public:
  /// At most `most` trials, 1 to kMostSequentialTrials. Takes some tenths of a second for 1000.
  SequentialPlan(const StoppingRule& rule, std::int64_t most);

  /// Is this, after whole blocks, enough?
  [[nodiscard]] bool enough(const Proportion& proportion) const;
  /// Up to which number a cell's trials count, given whether trials 0, 1, ... succeeded: where the
  /// rule stops or, when these are too few to tell, where it looks next.
  [[nodiscard]] std::int64_t size(const std::vector<bool>& successes) const;
  /// 95 % interval of the rate.
  [[nodiscard]] Interval interval(const Proportion& proportion) const;
  /// The probability that the interval of the stopped sample holds the true rate `p`, 0 < p < 1.
  [[nodiscard]] double coverage(double p) const;
  /// Of the intervals; 1.96 would do for a sample of fixed size.
  [[nodiscard]] double critical_value() const { return z_; }

 private:
  /// A result at which sampling ends, with the logarithm of the number of ways to get there.
  struct End {
    Proportion result;
    Interval interval;
    double log_ways = 0.0;
  };
  /// All results at which sampling ends with the critical value z_.
  [[nodiscard]] std::vector<End> find_ends() const;
  [[nodiscard]] std::int64_t next_look(std::int64_t trials) const;
  [[nodiscard]] bool covers_enough() const;

  StoppingRule rule_;
  std::int64_t most_;
  double z_;
  std::vector<End> ends_;
};

}  // namespace binpick
