#pragma once

#include <Eigen/Geometry>
#include <span>

#include "recognition/observed_scene.h"
#include "recognition/recognition_model.h"

namespace binpick {

/// Parameters of the visible surface discrepancy, m. The defaults are BOP's for Kinect-like sensors
/// (delta) and the strictest of its tolerances for an object of about 0.17 m.
struct DiscrepancyOptions {
  double visibility_margin = 0.015;  ///< delta: how far behind the scene a surface still shows
  double tolerance = 0.0085;         ///< tau: distances that differ by less agree
};

/// Visible surface discrepancy (Hodan et al., BOP 2018 and 2020): the share of the surface visible
/// in the estimated or the true pose on which the two differ; in [0, 1], 1 when neither is visible.
/// Needs no symmetries: it compares what is seen. `depth` is the test image, z in m, row-major at
/// the size of `projection`, 0 where nothing was measured.
[[nodiscard]] double visible_surface_discrepancy(const Eigen::Isometry3d& T_camera_estimated,
                                                 const Eigen::Isometry3d& T_camera_true,
                                                 const RenderMesh& mesh,
                                                 std::span<const float> depth,
                                                 const Projection& projection,
                                                 const DiscrepancyOptions& options = {});

}  // namespace binpick
