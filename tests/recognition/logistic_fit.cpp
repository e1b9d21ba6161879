#include "recognition/logistic_fit.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace binpick::testing {
namespace {

constexpr double kUnbounded = -std::numeric_limits<double>::infinity();

/// argmin of 1/2 d' H d - g' d over d >= `least`, by coordinate descent.
Eigen::VectorXd bounded_step(const Eigen::MatrixXd& H, const Eigen::VectorXd& g,
                             const Eigen::VectorXd& least) {
  constexpr int kMostSweeps = 500;
  Eigen::VectorXd d = Eigen::VectorXd::Zero(g.size());
  Eigen::VectorXd rest = g;  // g - H d
  for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
    double longest = 0.0;
    for (Eigen::Index i = 0; i < d.size(); ++i) {
      const double change = std::max(d[i] + rest[i] / H(i, i), least[i]) - d[i];
      d[i] += change;
      rest -= change * H.col(i);
      longest = std::max(longest, std::abs(change));
    }
    if (longest < 1e-7) break;
  }
  return d;
}

/// argmax of the penalised likelihood over coefficients >= `least`: one column per coefficient, the
/// first one the bias.
Eigen::VectorXd newton(const Eigen::MatrixXd& columns, const std::vector<LabelledFeatures>& rows,
                       double ridge, const Eigen::VectorXd& least) {
  constexpr int kMostSteps = 40;
  const Eigen::Index n = columns.rows();
  Eigen::VectorXd beta = Eigen::VectorXd::Zero(columns.cols());
  Eigen::VectorXd penalty = Eigen::VectorXd::Constant(columns.cols(), ridge);
  penalty[0] = 1e-9;
  for (int step = 0; step < kMostSteps; ++step) {
    const Eigen::VectorXd log_odds = columns * beta;
    Eigen::VectorXd surprise(n);
    Eigen::VectorXd weight(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const LabelledFeatures& row = rows[static_cast<std::size_t>(i)];
      const double p = probability(log_odds[i]);
      surprise[i] = row.weight * ((row.is_right ? 1.0 : 0.0) - p);
      weight[i] = row.weight * std::max(p * (1.0 - p), 1e-6);
    }
    Eigen::MatrixXd information = columns.transpose() * weight.asDiagonal() * columns;
    information.diagonal() += penalty;
    const Eigen::VectorXd gradient = columns.transpose() * surprise - penalty.cwiseProduct(beta);
    Eigen::VectorXd change = bounded_step(information, gradient, least - beta);
    // Far from the maximum a full step can overshoot.
    const double longest = change.cwiseAbs().maxCoeff();
    if (longest > 2.0) change *= 2.0 / longest;
    beta += change;
    if (longest < 1e-5) break;
  }
  return beta;
}

/// The value below which `share` of the weight lies, right and wrong rows having equal weight.
class BalancedQuantiles {
 public:
  BalancedQuantiles(const std::vector<LabelledFeatures>& rows, std::size_t feature) {
    double right = 0.0;
    double wrong = 0.0;
    for (const LabelledFeatures& row : rows) (row.is_right ? right : wrong) += row.weight;
    for (const LabelledFeatures& row : rows) {
      values_.emplace_back(row.features[feature], row.weight / (row.is_right ? right : wrong));
    }
    std::sort(values_.begin(), values_.end());
  }
  [[nodiscard]] double at(double share) const {
    double sum = 0.0;
    for (const auto& [value, weight] : values_) {
      sum += 0.5 * weight;
      if (sum >= share) return value;
    }
    return values_.back().first;
  }

 private:
  std::vector<std::pair<double, double>> values_;
};

void place_terms(AcceptanceModel& model, const std::vector<LabelledFeatures>& rows) {
  for (std::size_t f = 0; f < kFeatures; ++f) {
    const BalancedQuantiles quantiles(rows, f);
    AcceptanceModel::Term& term = model.terms[f];
    term.low = quantiles.at(0.005);
    term.high = std::max(quantiles.at(0.995), term.low + 1e-3);
    term.centre = quantiles.at(0.5);
    term.scale = std::max(0.5 * (quantiles.at(0.84) - quantiles.at(0.16)), 1e-3);
    constexpr std::array<double, AcceptanceModel::kKnots> kShares = {0.25, 0.5, 0.75};
    for (std::size_t k = 0; k < AcceptanceModel::kKnots; ++k) {
      term.knots[k] = model.standardised(static_cast<Feature>(f), quantiles.at(kShares[k]));
    }
  }
}

/// The model's parts as columns that rise as features get better, so that a model of non-negative
/// coefficients is one that never falls.
class RisingColumns {
 public:
  static constexpr std::size_t kPieces = 1 + AcceptanceModel::kKnots;

  explicit RisingColumns(const AcceptanceModel& placed) : model_(placed) {}

  [[nodiscard]] Eigen::Index count() const {
    return static_cast<Eigen::Index>(1 + kFeatures * kPieces);
  }

  [[nodiscard]] Eigen::RowVectorXd row(const FeatureVector& features) const {
    Eigen::RowVectorXd row(count());
    Eigen::Index column = 0;
    row[column++] = 1.0;
    std::array<double, kFeatures> x{};
    for (std::size_t f = 0; f < kFeatures; ++f) {
      const auto feature = static_cast<Feature>(f);
      x[f] = model_.standardised(feature, features[f]);
      const auto& knots = model_.terms[f].knots;
      const double sign = direction_of(feature);
      row[column++] = sign * std::min(x[f], knots.front());
      for (std::size_t k = 0; k < knots.size(); ++k) {
        const double beyond = std::max(x[f] - knots[k], 0.0);
        row[column++] =
            sign * (k + 1 < knots.size() ? std::min(beyond, knots[k + 1] - knots[k]) : beyond);
      }
    }
    return row;
  }

  [[nodiscard]] AcceptanceModel model_of(const Eigen::VectorXd& beta) const {
    AcceptanceModel model = model_;
    Eigen::Index column = 0;
    model.bias = beta[column++];
    for (std::size_t f = 0; f < kFeatures; ++f) {
      AcceptanceModel::Term& term = model.terms[f];
      const double sign = direction_of(static_cast<Feature>(f));
      double before = term.slope = sign * beta[column++];
      for (double& bend : term.bends) {
        const double slope = sign * beta[column++];
        bend = slope - before;
        before = slope;
      }
    }
    return model;
  }

 private:
  AcceptanceModel model_;
};

}  // namespace

AcceptanceModel fit_acceptance(const std::vector<LabelledFeatures>& rows, double ridge) {
  AcceptanceModel model;
  place_terms(model, rows);
  const RisingColumns rising(model);
  Eigen::MatrixXd columns(static_cast<Eigen::Index>(rows.size()), rising.count());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    columns.row(static_cast<Eigen::Index>(i)) = rising.row(rows[i].features);
  }
  Eigen::VectorXd least = Eigen::VectorXd::Zero(rising.count());
  least[0] = kUnbounded;
  return rising.model_of(newton(columns, rows, ridge, least));
}

Recalibration recalibration_of(const std::vector<JudgedRow>& rows) {
  Eigen::MatrixXd columns(static_cast<Eigen::Index>(rows.size()), 2);
  std::vector<LabelledFeatures> labels(rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    columns.row(static_cast<Eigen::Index>(i)) = Eigen::RowVector2d(1.0, rows[i].log_odds);
    labels[i].is_right = rows[i].is_there;
  }
  const Eigen::VectorXd beta = newton(columns, labels, 1e-3, Eigen::Vector2d(kUnbounded, 0.0));
  return {beta[1], beta[0]};
}

AcceptanceModel::InSet fit_in_set(const std::vector<JudgedRow>& rows) {
  Eigen::MatrixXd columns(static_cast<Eigen::Index>(rows.size()), 3);
  std::vector<LabelledFeatures> labels(rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    columns.row(static_cast<Eigen::Index>(i)) =
        Eigen::RowVector3d(1.0, rows[i].log_odds, rows[i].margin);
    labels[i].is_right = rows[i].is_there;
  }
  const Eigen::VectorXd beta = newton(columns, labels, 1e-3, Eigen::Vector3d(kUnbounded, 0.0, 0.0));
  return {beta[0], beta[1], beta[2]};
}

void Recalibration::apply(AcceptanceModel& model) const {
  model.bias = a * model.bias + b;
  for (AcceptanceModel::Term& term : model.terms) {
    term.slope *= a;
    for (double& bend : term.bends) bend *= a;
  }
}

}  // namespace binpick::testing
