#pragma once

#include <vector>

#include "recognition/acceptance_model.h"

namespace binpick::testing {

/// A hypothesis whose truth is known.
struct LabelledFeatures {
  FeatureVector features{};
  double margin = 0.0;        ///< of a selected one
  double displacement = 0.0;  ///< of a selected one, diameters
  bool is_right = false;
  bool is_beside = false;  ///< not right, but the object is there, a little beside its place
  double weight = 1.0;
  int scan = 0;  ///< rows of one scan are alike and stay together
};

/// Fits the terms of the acceptance model by penalised maximum likelihood (logistic regression,
/// Newton's method with weights; Hastie, Tibshirani & Friedman, The Elements of Statistical
/// Learning, 4.4) among the models that never fall as a feature gets better: ranges and knots at
/// quantiles of the rows, right and wrong ones counting alike; `ridge` on every coefficient but the
/// bias. Leaves least_probability alone. Deterministic.
[[nodiscard]] AcceptanceModel fit_acceptance(const std::vector<LabelledFeatures>& rows,
                                             double ridge);

/// Log odds that a model gave to a row that it had not seen.
struct JudgedRow {
  double log_odds = 0.0;
  double margin = 0.0;    ///< in the chosen set
  bool is_there = false;  ///< right or beside its place
};

/// Replaces log odds x by a x + b.
struct Recalibration {
  double a = 1.0;
  double b = 0.0;

  void apply(AcceptanceModel& model) const;
};

/// The a, b under which the rows are most likely (Platt 1999).
[[nodiscard]] Recalibration recalibration_of(const std::vector<JudgedRow>& rows);

/// The same with the margin in the chosen set; neither may speak for doubt.
[[nodiscard]] AcceptanceModel::InSet fit_in_set(const std::vector<JudgedRow>& rows);

}  // namespace binpick::testing
