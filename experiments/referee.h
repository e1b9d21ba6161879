#pragma once

#include <optional>
#include <string>
#include <vector>

#include "models/detection.h"
#include "scenes/scene.h"
#include "sim/world.h"

namespace binpick {

/// Whether the object hangs between both pads, clear of everything, `height` above the table, m.
[[nodiscard]] bool held_aloft(const World& world, int object, double height);

/// Scores by physical rules from the world's truth. Reads the world, never changes it, and tells
/// the robot's brain nothing.
class Referee {
 public:
  /// `world` must outlive the referee.
  explicit Referee(const World& world);

  /// Whether the object is released, at rest, with its centre of mass inside the place of its kind.
  [[nodiscard]] bool in_designated_place(int object) const;

  /// Objects that are not in their designated place.
  [[nodiscard]] std::vector<int> misplaced_objects() const;

  /// Objects whose centre of mass lies inside the pick region.
  [[nodiscard]] std::vector<int> objects_in_pick_region() const;

  /// The object of the detection's model nearest to it.
  struct Match {
    int object = -1;
    double mssd = 0.0;      ///< m, symmetries included
    double diameter = 0.0;  ///< of the model, m

    /// MSSD below 10 % of the diameter.
    [[nodiscard]] bool correct() const noexcept { return mssd < 0.1 * diameter; }
  };
  [[nodiscard]] std::optional<Match> match(const Detection& detection) const;

 private:
  struct Shape {
    std::vector<Eigen::Vector3f> points;
    double diameter = 0.0;
  };

  const World& world_;
  const Scene& scene_;
  std::vector<Shape> shapes_;  ///< one per object
};

}  // namespace binpick
