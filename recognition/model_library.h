#pragma once

#include <Eigen/Geometry>
#include <string>
#include <variant>
#include <vector>

#include "models/geometry.h"
#include "recognition/pair_table.h"
#include "recognition/recognition_model.h"
#include "recognition/recognizer_options.h"

namespace binpick {

/// What the library is built from: a closed or partial surface in its own frame, metres.
struct ModelSource {
  std::string name;
  /// A cloud without normals gets estimated ones: outward when the frame's origin lies inside the
  /// cloud's bounding box, otherwise towards the origin (a segment cut out of a scan).
  std::variant<TriangleMesh, PointCloud> shape;
  /// Poses that the shape cannot tell apart (T_model_equivalent). Empty: found by registering the
  /// shape with itself (recognition/self_registration.h); the identity alone says there are none.
  std::vector<Eigen::Isometry3d> symmetries = {};
};

/// The offline phase (IJRR 2012, section 4.1): all models, and one hash table of their oriented
/// point pairs. Immutable once built; threads share it freely.
class ModelLibrary {
 public:
  /// Builds the table in time linear in the number of model points, on up to `jobs` threads; the
  /// result is the same for any number.
  /// @throws InputError when there is no model, two share a name, or one has no surface.
  explicit ModelLibrary(const std::vector<ModelSource>& sources,
                        RecognizerSetting setting = RecognizerSetting::kDefault, int jobs = 1);

  [[nodiscard]] const std::vector<RecognitionModel>& models() const noexcept { return models_; }
  [[nodiscard]] const PairTable& pairs() const noexcept { return pairs_; }
  /// The pairs of a model that lie in one plane: no part of the table in the default setting, which
  /// resorts to them for objects that show a single flat face.
  [[nodiscard]] const std::vector<PairFrame>& coplanar_pairs(std::size_t model) const {
    return coplanar_pairs_[model];
  }
  [[nodiscard]] RecognizerSetting setting() const noexcept { return setting_; }

  /// d, the same for all models: 0.6 of the smallest middle extent, so that both points of a pair
  /// fit on the visible part of every model.
  [[nodiscard]] double pair_width() const noexcept { return pair_width_; }
  /// delta_d.
  [[nodiscard]] double pair_tolerance() const noexcept { return pair_tolerance_; }
  /// The finest leaf size that the models ask for: 1/34 of the smallest diameter.
  [[nodiscard]] double leaf_size() const noexcept { return leaf_size_; }

 private:
  RecognizerSetting setting_;
  std::vector<RecognitionModel> models_;
  double pair_width_ = 0.0;
  double pair_tolerance_ = 0.0;
  double leaf_size_ = 0.0;
  PairTable pairs_;
  std::vector<std::vector<PairFrame>> coplanar_pairs_;
};

}  // namespace binpick
