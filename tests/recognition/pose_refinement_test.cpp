#include "recognition/pose_refinement.h"

#include <gtest/gtest.h>

#include "recognition/depth_rasterizer.h"
#include "recognition/pose_metrics.h"
#include "recognition/projective_alignment.h"
#include "recognition/shapes.h"
#include "recognition/synthetic_scene.h"

namespace binpick {
namespace {

class PoseRefinement : public ::testing::Test {
 protected:
  PoseRefinement() : sources_(testing::known_objects()), generator_(sources_) {
    for (const ModelSource& source : sources_) {
      models_.push_back(make_recognition_model(source.name, std::get<TriangleMesh>(source.shape),
                                               source.symmetries));
    }
  }

  /// `pose` moved by up to `distance` and turned by up to `angle`.
  static Eigen::Isometry3d disturbed(const Eigen::Isometry3d& pose, double distance, double angle,
                                     Random& random) {
    Eigen::Isometry3d T = pose;
    T.linear() =
        Eigen::AngleAxisd(random.uniform(-angle, angle), random.unit_vector()).toRotationMatrix() *
        pose.linear();
    T.translation() += random.uniform(0.0, distance) * random.unit_vector();
    return T;
  }

  std::vector<ModelSource> sources_;
  testing::SceneGenerator generator_;
  std::vector<RecognitionModel> models_;
};

/// A noise-free image of one object, alone.
RangeImage picture_of(const RecognitionModel& model, const Eigen::Isometry3d& T_camera_model) {
  RangeImage image;
  image.intrinsics = {640, 480, 580.0, 580.0, 319.5, 239.5};
  image.depth.assign(640u * 480u, 0.0f);
  DepthRasterizer rasterizer;
  const RenderedModel& rendered = rasterizer.render(model.render_mesh, T_camera_model.cast<float>(),
                                                    {640, 480, 580.0f, 580.0f, 319.5f, 239.5f});
  for (int v = 0; v < rendered.height; ++v) {
    for (int u = 0; u < rendered.width; ++u) {
      image.depth[static_cast<std::size_t>((rendered.v0 + v) * 640 + rendered.u0 + u)] =
          rendered.depth[rendered.index(u, v)];
    }
  }
  return image;
}

TEST_F(PoseRefinement, ConvergesBelowHalfAMillimetreOnCleanData) {
  Random random(8);
  for (const RecognitionModel& model : models_) {
    // Both boxes show three faces, which fix all six degrees of freedom; the bottle's curvature
    // does the same.
    Eigen::Isometry3d truth = Eigen::Isometry3d::Identity();
    truth.translation() << 0.02, -0.03, 0.85;
    truth.linear() = (Eigen::AngleAxisd(2.4, Eigen::Vector3d::UnitX()) *
                      Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ()))
                         .toRotationMatrix();
    const ObservedScene observed(picture_of(model, truth), {0.005, 1.0}, 1, 1);
    for (int i = 0; i < 5; ++i) {
      const Eigen::Isometry3d start = disturbed(truth, 0.004, 0.03, random);
      const Eigen::Isometry3d refined = refine_pose(observed, model, start, 0.002);
      EXPECT_LT(add(refined, truth, model.hull, {}), 0.0005) << model.name;
    }
  }
}

TEST_F(PoseRefinement, AlignmentPullsCoarsePosesIn) {
  Random random(9);
  const auto scene = generator_.make(testing::SceneKind::kSeparate, 3);
  const RangeImage image = testing::add_kinect_noise(scene.clean, {}, 3);
  const ObservedScene observed(image, {0.005, 0.054}, 1, 3);
  for (const testing::TrueInstance& instance : scene.instances) {
    const RecognitionModel& model = models_[instance.model];
    int close = 0;
    for (int i = 0; i < 20; ++i) {
      const Eigen::Isometry3d start = disturbed(instance.T_camera_model, 0.01, 0.1, random);
      Eigen::Isometry3f T = start.cast<float>();
      T = align_projectively(observed, model, T, {0.05f * model.diameter, 128, 4});
      T = align_projectively(observed, model, T, {0.02f * model.diameter, 512, 6});
      if (add(T.cast<double>(), instance.T_camera_model, model.hull, {}) < 0.006) ++close;
    }
    EXPECT_GE(close, 16) << model.name;
  }
}

TEST_F(PoseRefinement, LeavesAPoseWithoutDataAlone) {
  const auto scene = generator_.make(testing::SceneKind::kEmptyTable, 1);
  const ObservedScene observed(scene.clean.image, {0.005, 0.054}, 1, 1);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() << 0.0, 0.0, 0.3;
  EXPECT_TRUE(refine_pose(observed, models_[0], T, 0.002).isApprox(T));
}

}  // namespace
}  // namespace binpick
