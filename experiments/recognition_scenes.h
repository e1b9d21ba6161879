#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "experiments/recognition_conditions.h"
#include "models/range_image.h"
#include "sim/depth_camera.h"
#include "sim/world.h"

namespace binpick {

/// An object as it lies before the camera.
struct TrueObject {
  std::string model;
  Eigen::Isometry3d T_camera_model = Eigen::Isometry3d::Identity();
  double occlusion = 0.0;      ///< 1 - measurable share of the whole surface, IJRR 2012, eq. (15)
  double visible_share = 0.0;  ///< measurable share of the surface that faces the camera
};

/// A pile seen by a sensor without errors.
struct CleanView {
  RangeImage image;
  std::vector<TrueObject> objects;
  int target = -1;  ///< the object of the wanted occlusion; -1: none was wanted
};

/// How much of a surface an image shows: of 4000 points, uniform by area, those that face the
/// camera and whose pixel has their own depth.
class SurfaceVisibility {
 public:
  explicit SurfaceVisibility(const TriangleMesh& mesh);

  /// Fills occlusion and visible share of `object`.
  void judge(const RangeImage& image, TrueObject& object) const;

 private:
  PointCloud points_;
};

/// Makes piles and looks at them. Keeps the last pile and the cameras: trials of several cells that
/// look at the same pile in turn drop it once. The result does not depend on what was kept.
/// Holds GL contexts: use it on one thread.
class RecognitionScenes {
 public:
  /// @throws InputError when the scene file cannot be used.
  explicit RecognitionScenes(const std::filesystem::path& scene_file);

  /// Drops the pile of `pile_seed` and looks at it; with a wanted occlusion, from the first side,
  /// starting at a random one, from which an object of the target's model has it. Piles without
  /// such a side are followed by others.
  /// @throws InputError for unknown objects, std::runtime_error when twenty piles do not rest or
  /// do not show what is wanted.
  [[nodiscard]] CleanView view(const RecognitionConditions& conditions, Seed pile_seed);

  /// Which object each pixel of the last view shows.
  [[nodiscard]] SegmentationImage segmentation();

 private:
  /// A cell with a camera, and a world of its own to show poses in.
  struct Studio {
    std::shared_ptr<const WorldTemplate> shared;
    std::unique_ptr<World> world;
    std::unique_ptr<DepthCamera> camera;
  };
  /// A settled pile and what each side shows of each object, by camera and sensor.
  struct Pile {
    std::vector<Eigen::Isometry3d> poses;  ///< T_world_object
    std::map<std::string, std::vector<std::vector<double>>> occlusions;
  };

  [[nodiscard]] Scene scene_of(const RecognitionConditions& conditions) const;
  [[nodiscard]] Studio& studio(const RecognitionConditions& conditions);
  [[nodiscard]] Pile& pile(const RecognitionConditions& conditions, Seed seed);
  [[nodiscard]] CleanView look(const RecognitionConditions& conditions, const Pile& pile, int side);
  [[nodiscard]] const std::vector<std::vector<double>>& occlusions(
      const RecognitionConditions& conditions, Pile& pile);
  [[nodiscard]] const SurfaceVisibility& visibility(const ObjectModel& object);

  Scene scene_;
  std::map<std::string, Studio> studios_;
  std::map<std::string, Pile> piles_;  ///< of the last pile seed family only
  std::map<std::string, SurfaceVisibility> visibilities_;
  Studio* last_ = nullptr;
};

}  // namespace binpick
