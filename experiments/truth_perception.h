#pragma once

#include "control/perception.h"
#include "sim/world.h"

namespace binpick {

/// ORACLE, for comparison only: instead of recognizing anything it reads the true poses from the
/// world, which no robot could. With it, what still fails is manipulation's fault. It tells of the
/// objects that the camera sees at all, so that looking again after each pick stays necessary.
/// Configurations choose it by `perception: truth`; their trials carry the measure
/// `oracle_perception`.
class TruthPerception final : public Perception {
 public:
  /// `world` must outlive the perception.
  explicit TruthPerception(const World& world);

  /// Objects of whose surface, as far as it faces the camera, the image shows at least 10 %; with
  /// that share as visibility, certain, without pose error.
  [[nodiscard]] std::vector<Detection> recognize(const RangeImage& image) override;

 private:
  const World& world_;
  std::vector<PointCloud> surfaces_;  ///< one per object, model frame
};

}  // namespace binpick
