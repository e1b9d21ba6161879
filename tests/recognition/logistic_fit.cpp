#include "recognition/logistic_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstddef>

namespace binpick::testing {
namespace {

/// argmax of the penalised likelihood: one column per coefficient, the first one the bias.
Eigen::VectorXd newton(const Eigen::MatrixXd& columns, const std::vector<LabelledFeatures>& rows,
                       double ridge) {
  constexpr int kMostSteps = 40;
  const Eigen::Index n = columns.rows();
  Eigen::VectorXd beta = Eigen::VectorXd::Zero(columns.cols());
  Eigen::VectorXd penalty = Eigen::VectorXd::Constant(columns.cols(), ridge);
  penalty[0] = 1e-9;
  for (int step = 0; step < kMostSteps; ++step) {
    const Eigen::VectorXd log_odds = columns * beta;
    Eigen::VectorXd gradient = -penalty.cwiseProduct(beta);
    Eigen::MatrixXd scaled = columns;
    for (Eigen::Index i = 0; i < n; ++i) {
      const LabelledFeatures& row = rows[static_cast<std::size_t>(i)];
      const double p = probability(log_odds[i]);
      gradient += row.weight * ((row.is_right ? 1.0 : 0.0) - p) * columns.row(i).transpose();
      scaled.row(i) *= std::sqrt(row.weight * std::max(p * (1.0 - p), 1e-6));
    }
    Eigen::MatrixXd information = Eigen::MatrixXd::Zero(columns.cols(), columns.cols());
    information.selfadjointView<Eigen::Lower>().rankUpdate(scaled.transpose());
    information.diagonal() += penalty;
    Eigen::VectorXd change = information.selfadjointView<Eigen::Lower>().ldlt().solve(gradient);
    // Far from the maximum a full step can overshoot.
    const double longest = change.cwiseAbs().maxCoeff();
    if (longest > 2.0) change *= 2.0 / longest;
    beta += change;
    if (longest < 1e-7) break;
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

}  // namespace

AcceptanceModel fit_acceptance(const std::vector<LabelledFeatures>& rows, double ridge) {
  AcceptanceModel model;
  place_terms(model, rows);
  // How much evidence there is, whether it fixes the pose, and whether the silhouette confirms it
  // decide how much the rest means.
  for (const Feature a : {Feature::kEvidence, Feature::kSecondFace, Feature::kEdgesMatched}) {
    for (std::size_t f = 0; f < kFeatures; ++f) {
      const auto b = static_cast<Feature>(f);
      const bool is_known =
          std::any_of(model.products.begin(), model.products.end(),
                      [&](const auto& product) { return product.a == b && product.b == a; });
      if (a != b && !is_known) model.products.push_back({a, b, 0.0});
    }
  }
  constexpr std::size_t kPerFeature = 1 + AcceptanceModel::kKnots;
  const std::size_t width = 1 + kFeatures * kPerFeature + model.products.size();
  Eigen::MatrixXd columns(static_cast<Eigen::Index>(rows.size()), static_cast<Eigen::Index>(width));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    Eigen::Index column = 0;
    const auto put = [&](double value) { columns(static_cast<Eigen::Index>(i), column++) = value; };
    std::array<double, kFeatures> x{};
    put(1.0);
    for (std::size_t f = 0; f < kFeatures; ++f) {
      x[f] = model.standardised(static_cast<Feature>(f), rows[i].features[f]);
      put(x[f]);
      for (const double knot : model.terms[f].knots) put(std::max(x[f] - knot, 0.0));
    }
    for (const auto& product : model.products) {
      put(x[static_cast<std::size_t>(product.a)] * x[static_cast<std::size_t>(product.b)]);
    }
  }
  const Eigen::VectorXd beta = newton(columns, rows, ridge);
  Eigen::Index column = 0;
  model.bias = beta[column++];
  for (AcceptanceModel::Term& term : model.terms) {
    term.slope = beta[column++];
    for (double& bend : term.bends) bend = beta[column++];
  }
  for (AcceptanceModel::Product& product : model.products) product.weight = beta[column++];
  return model;
}

void recalibrate(AcceptanceModel& model, const std::vector<LabelledFeatures>& rows) {
  Eigen::MatrixXd columns(static_cast<Eigen::Index>(rows.size()), 2);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    columns(static_cast<Eigen::Index>(i), 0) = 1.0;
    columns(static_cast<Eigen::Index>(i), 1) = model.log_odds(rows[i].features);
  }
  const Eigen::VectorXd beta = newton(columns, rows, 1e-3);
  model.bias = beta[0] + beta[1] * model.bias;
  for (AcceptanceModel::Term& term : model.terms) {
    term.slope *= beta[1];
    for (double& bend : term.bends) bend *= beta[1];
  }
  for (AcceptanceModel::Product& product : model.products) product.weight *= beta[1];
}

}  // namespace binpick::testing
