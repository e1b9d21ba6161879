// PCL's ObjRecRANSAC on exchanged scenes. Parameters of PCL's own example for the paper's objects
// (tools/obj_rec_ransac_result.cpp: pair width 40, voxels 5, coplanarity 15 degrees, in mm), scaled
// to the models; success probability, thresholds and refinement are its defaults (no setters).
//
// usage: pcl_peer FOLDER ROW table|cut|plane LIMIT_S [VOXEL_FACTOR [NORMAL_RADIUS]]
//   plane: the largest plane is removed first, as the example does; the factor makes its voxels,
//   and with them its tolerances, coarser than the example's; the radius of normals is in voxels.
//
// The wrapper was checked on a scene that PCL must solve, one side of its authors' scanned rabbit
// alone, with estimated normals: found in 8 of 9 runs, within 2 mm, with normals of all points
// within 1.4 voxels; not once in 9 with points averaged in half voxels.

#include <pcl/features/normal_3d.h>
#include <pcl/recognition/ransac_based/obj_rec_ransac.h>

#include <csignal>
#include <list>
#include <random>

#include "exchange.h"

namespace {

constexpr float kMillimetres = 1000.0f;
constexpr double kSmallestInExample = 0.171;  // diameter of the example's smallest model, m

using Cloud = pcl::PointCloud<pcl::PointXYZ>;

/// Takes out the points within 10 mm (the example's distance) of the plane that holds most of them.
Cloud::Ptr without_plane(const Cloud& cloud) {
  constexpr float kDistance = 10.0f;
  std::minstd_rand random(1);
  Eigen::Vector3f best_normal = Eigen::Vector3f::UnitZ();
  float best_offset = 0.0f;
  std::size_t most = 0;
  for (int i = 0; i < 300; ++i) {
    const auto any = [&] { return cloud[random() % cloud.size()].getVector3fMap(); };
    const Eigen::Vector3f a = any(), b = any(), c = any();
    const Eigen::Vector3f normal = (b - a).cross(c - a).normalized();
    std::size_t count = 0;
    for (std::size_t k = 0; k < cloud.size(); k += 7) {
      if (std::abs(normal.dot(cloud[k].getVector3fMap() - a)) < kDistance) ++count;
    }
    if (count <= most) continue;
    most = count;
    best_normal = normal;
    best_offset = normal.dot(a);
  }
  Cloud::Ptr rest(new Cloud);
  for (const pcl::PointXYZ& p : cloud) {
    if (std::abs(best_normal.dot(p.getVector3fMap()) - best_offset) > kDistance) rest->push_back(p);
  }
  return rest;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 5) return 2;
  const std::string folder = argv[1];
  const std::string table = argv[3];
  const std::vector<peers::Model> models = peers::read_models(folder);
  double smallest = models.front().diameter;
  for (const peers::Model& model : models) smallest = std::min(smallest, model.diameter);
  const auto scale = static_cast<float>(smallest / kSmallestInExample);
  const float voxel = 5.0f * scale * (argc > 5 ? std::stof(argv[5]) : 1.0f);
  const double normal_radius = static_cast<double>(voxel) * (argc > 6 ? std::stod(argv[6]) : 1.4);
  pcl::recognition::ObjRecRANSAC recognizer(40.0f * scale, voxel);
  recognizer.setMaxCoplanarityAngleDegrees(15.0f);
  for (const peers::Model& model : models) {
    Cloud points;
    pcl::PointCloud<pcl::Normal> normals;
    for (const auto& o : peers::read_oriented_points(folder + "/" + model.name + ".txt")) {
      points.push_back({kMillimetres * o.p[0], kMillimetres * o.p[1], kMillimetres * o.p[2]});
      normals.push_back({o.n[0], o.n[1], o.n[2]});
    }
    recognizer.addModel(points, normals, model.name);
  }

  peers::answer_scenes(
      folder, argv[2], table == "cut", std::stoi(argv[4]), [&](const peers::Scan& scan, int) {
        Cloud::Ptr all(new Cloud);
        for (const auto& p : scan.points) {
          if (std::isfinite(p[2])) {
            all->push_back({kMillimetres * p[0], kMillimetres * p[1], kMillimetres * p[2]});
          }
        }
        if (table == "plane") all = without_plane(*all);
        pcl::PointCloud<pcl::Normal> normals;
        pcl::NormalEstimation<pcl::PointXYZ, pcl::Normal> estimation;
        estimation.setInputCloud(all);
        estimation.setRadiusSearch(normal_radius);
        estimation.setViewPoint(0.0f, 0.0f, 0.0f);
        estimation.compute(normals);
        Cloud points;
        pcl::PointCloud<pcl::Normal> finite;
        for (std::size_t i = 0; i < all->size(); ++i) {
          if (!std::isfinite(normals[i].normal_x)) continue;
          points.push_back((*all)[i]);
          finite.push_back(normals[i]);
        }
        std::list<pcl::recognition::ObjRecRANSAC::Output> found;
        const peers::Clock clock;  // its input has normals: they cost it no time here
        if (!points.empty()) recognizer.recognize(points, finite, found, 0.99);
        peers::Answer answer;
        answer.seconds = clock.seconds();
        for (const auto& output : found) {
          peers::Object object;
          object.model = output.object_name_;
          const float* t = output.rigid_transform_;  // rotation row by row, then translation
          for (std::size_t row = 0; row < 3; ++row) {
            for (std::size_t column = 0; column < 3; ++column) {
              object.T_camera_model[4 * row + column] = static_cast<double>(t[3 * row + column]);
            }
            object.T_camera_model[4 * row + 3] = static_cast<double>(t[9 + row] / kMillimetres);
          }
          answer.objects.push_back(object);
        }
        return answer;
      });
}
