// OpenCV's PPF3DDetector with ICP on exchanged scenes, one detector per model. Parameters of its
// reference's typical use (ppf_match_3d.hpp: detector 0.05, 0.05; match 1/5, 0.05) and of its
// sample's ICP (100, 0.005, 2.5, 8); the sample's finer detector takes minutes to train on a box.
// Units are mm: its averaged rotations degenerate in metres. It has no threshold on its poses, so
// it is told how many objects of each model are at least 15 % visible, and gives that many: its
// best poses by votes that are not within a third of a diameter of each other.
//
// usage: opencv_peer LIMIT_S FOLDER ROW table|cut [FOLDER ROW table|cut ...], folders of one model
// set

#include <csignal>
#include <cstdlib>
#include <opencv2/core.hpp>
#include <opencv2/surface_matching.hpp>
#include <opencv2/surface_matching/ppf_helpers.hpp>
#include <unordered_set>

#include "exchange.h"

namespace {

constexpr float kMillimetres = 1000.0f;

using cv::ppf_match_3d::Pose3DPtr;

cv::Mat to_matrix(const std::vector<peers::OrientedPoint>& points) {
  cv::Mat matrix(static_cast<int>(points.size()), 6, CV_32F);
  for (int i = 0; i < matrix.rows; ++i) {
    const peers::OrientedPoint& o = points[static_cast<std::size_t>(i)];
    for (int k = 0; k < 3; ++k) {
      matrix.at<float>(i, k) = kMillimetres * o.p[static_cast<std::size_t>(k)];
      matrix.at<float>(i, 3 + k) = o.n[static_cast<std::size_t>(k)];
    }
  }
  return matrix;
}

/// The scan, one point per cube of `leaf` mm, with normals towards the camera.
cv::Mat with_normals(const peers::Scan& scan, float leaf) {
  std::unordered_set<std::uint64_t> occupied;
  std::vector<std::array<float, 3>> kept;
  for (const auto& p : scan.points) {
    if (!std::isfinite(p[2])) continue;
    std::uint64_t key = 0;
    for (const float x : p) {
      key = (key << 21) |
            (static_cast<std::uint64_t>(
                 static_cast<std::int64_t>(std::floor(kMillimetres * x / leaf)) + (1 << 20)) &
             0x1fffff);
    }
    if (occupied.insert(key).second) kept.push_back(p);
  }
  cv::Mat points(static_cast<int>(kept.size()), 3, CV_32F);
  for (int i = 0; i < points.rows; ++i) {
    for (int k = 0; k < 3; ++k) {
      points.at<float>(i, k) =
          kMillimetres * kept[static_cast<std::size_t>(i)][static_cast<std::size_t>(k)];
    }
  }
  cv::Mat with;
  cv::ppf_match_3d::computeNormalsPC3d(points, with, 12, true, cv::Vec3f(0.0f, 0.0f, 0.0f));
  return with;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 5 || (argc - 2) % 3 != 0) return 2;
  cv::setNumThreads(1);
  std::string folder = argv[2];
  const std::vector<peers::Model> models = peers::read_models(folder);
  std::vector<cv::Mat> clouds;
  std::vector<cv::ppf_match_3d::PPF3DDetector> detectors;
  detectors.reserve(models.size());
  double smallest = models.front().diameter;
  for (const peers::Model& model : models) {
    smallest = std::min(smallest, model.diameter);
    clouds.push_back(to_matrix(peers::read_oriented_points(folder + "/" + model.name + ".txt")));
    detectors.emplace_back(0.05, 0.05);
    const peers::Clock clock;
    detectors.back().trainModel(clouds.back());
    std::cerr << "opencv trained " << model.name << " in " << clock.seconds() << " s\n";
  }

  const auto recognize = [&](const peers::Scan& scan, int scene) {
    const std::vector<peers::Object> truth = peers::read_truth(folder, scene);
    const peers::Clock clock;
    peers::Answer answer;
    const cv::Mat points = with_normals(scan, 0.015f * kMillimetres * float(smallest));
    for (std::size_t m = 0; m < models.size(); ++m) {
      const auto wanted = static_cast<std::size_t>(
          std::count_if(truth.begin(), truth.end(), [&](const peers::Object& o) {
            return o.model == models[m].name && o.visible_share >= 0.15;
          }));
      if (wanted == 0) continue;
      std::vector<Pose3DPtr> poses;
      detectors[m].match(points, poses, 1.0 / 5.0, 0.05);
      std::vector<Pose3DPtr> best;
      for (const Pose3DPtr& pose : poses) {
        if (best.size() == wanted) break;
        const bool is_new = std::all_of(best.begin(), best.end(), [&](const Pose3DPtr& other) {
          return cv::norm(pose->t - other->t) > kMillimetres * models[m].diameter / 3.0;
        });
        if (is_new) best.push_back(pose);
      }
      if (best.empty()) continue;
      cv::ppf_match_3d::ICP icp(100, 0.005f, 2.5f, 8);
      icp.registerModelToScene(clouds[m], points, best);
      for (const Pose3DPtr& pose : best) {
        peers::Object object;
        object.model = models[m].name;
        for (int row = 0; row < 3; ++row) {
          for (int column = 0; column < 4; ++column) {
            const double value = pose->pose(row, column);
            object.T_camera_model[static_cast<std::size_t>(4 * row + column)] =
                column == 3 ? value / static_cast<double>(kMillimetres) : value;
          }
        }
        answer.objects.push_back(object);
      }
    }
    answer.seconds = clock.seconds();
    return answer;
  };
  for (int i = 2; i < argc; i += 3) {
    folder = argv[i];
    peers::answer_scenes(folder, argv[i + 1], std::string(argv[i + 2]) == "cut", std::stoi(argv[1]),
                         recognize);
  }
}
