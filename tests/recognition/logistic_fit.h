#pragma once

#include <vector>

#include "recognition/acceptance_model.h"

namespace binpick::testing {

/// A hypothesis whose truth is known.
struct LabelledFeatures {
  FeatureVector features{};
  bool is_right = false;
  double weight = 1.0;
};

/// Fits the acceptance model by penalised maximum likelihood (logistic regression, Newton's method
/// with weights; Hastie, Tibshirani & Friedman, The Elements of Statistical Learning, 4.4) among
/// the models that never fall as a feature gets better: ranges and knots at quantiles of the rows,
/// right and wrong ones counting alike; `ridge` on every coefficient but the bias. Leaves
/// least_probability alone. Deterministic.
[[nodiscard]] AcceptanceModel fit_acceptance(const std::vector<LabelledFeatures>& rows,
                                             double ridge);

/// Replaces log odds x by a x + b with the a, b under which `rows` are most likely (Platt 1999).
void recalibrate(AcceptanceModel& model, const std::vector<LabelledFeatures>& rows);

}  // namespace binpick::testing
