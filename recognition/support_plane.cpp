#include "recognition/support_plane.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <optional>

#include "recognition/parallel_for.h"

namespace binpick {
namespace {

constexpr std::size_t kFitPoints = 1000;  // enough for any plane's parameters
constexpr std::size_t kOutlinePoints = 1500;
constexpr int kRejectedPlanes = 2;  // tried and found no support before giving up

using Bow = Eigen::Matrix<double, 6, 1>;

Bow bow_terms(const Eigen::Vector2d& at) {
  Bow terms;
  terms << 1.0, at.x(), at.y(), at.x() * at.x(), at.x() * at.y(), at.y() * at.y();
  return terms;
}

Eigen::Vector2d along_axes(const SupportPlane& plane, const Eigen::Vector3d& p) {
  const Eigen::Vector2d at = plane.axes.transpose() * (p - plane.centre);
  return at.cwiseMax(-plane.reach).cwiseMin(plane.reach);
}

/// Least-squares plane through `points`, towards the sensor at the origin.
SupportPlane fit_plane(const std::vector<Eigen::Vector3d>& points) {
  SupportPlane plane;
  for (const Eigen::Vector3d& p : points) plane.centre += p;
  plane.centre /= static_cast<double>(points.size());
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& p : points) {
    covariance += (p - plane.centre) * (p - plane.centre).transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
  plane.normal = solver.eigenvectors().col(0);
  if (plane.normal.dot(plane.centre) > 0.0) plane.normal = -plane.normal;
  plane.axes.col(0) = solver.eigenvectors().col(1);
  plane.axes.col(1) = solver.eigenvectors().col(2);
  plane.offset = plane.normal.dot(plane.centre);
  return plane;
}

/// Fits the bow to the heights of the plane's own points; returns their rms about it.
double fit_bow(SupportPlane& plane, const std::vector<Eigen::Vector3d>& points) {
  plane.reach.setZero();
  plane.bow.setZero();
  for (const Eigen::Vector3d& p : points) {
    const Eigen::Vector2d at = plane.axes.transpose() * (p - plane.centre);
    plane.reach = plane.reach.cwiseMax(at.cwiseAbs());
  }
  Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Zero();
  Bow right = Bow::Zero();
  for (const Eigen::Vector3d& p : points) {
    const Bow terms = bow_terms(along_axes(plane, p));
    information += terms * terms.transpose();
    right += terms * (plane.normal.dot(p) - plane.offset);
  }
  const Bow bow = information.ldlt().solve(right);
  if (bow.allFinite()) plane.bow = bow;
  double squares = 0.0;
  for (const Eigen::Vector3d& p : points) squares += std::pow(plane.height(p), 2);
  return std::sqrt(squares / static_cast<double>(points.size()));
}

/// Coordinates side by side: what is done to all points is done to several at a time.
struct PointArrays {
  std::vector<float> x, y, z;

  [[nodiscard]] std::size_t size() const { return x.size(); }
  [[nodiscard]] Eigen::Vector3d p(std::size_t i) const {
    return Eigen::Vector3f(x[i], y[i], z[i]).cast<double>();
  }
  void reserve(std::size_t size) {
    x.reserve(size);
    y.reserve(size);
    z.reserve(size);
  }
  void resize(std::size_t size) {
    x.resize(size);
    y.resize(size);
    z.resize(size);
  }
  void push_back(float px, float py, float pz) {
    x.push_back(px);
    y.push_back(py);
    z.push_back(pz);
  }
};

/// The points whose height over the plane satisfies `keep`, in their order.
template <class Keep>
PointArrays select(const PointArrays& points, const SupportPlane& plane, int jobs,
                   const Keep& keep) {
  constexpr int kChunk = 4096;
  const PlaneHeight height(plane);
  const int size = static_cast<int>(points.size());
  std::vector<PointArrays> parts(static_cast<std::size_t>((size + kChunk - 1) / kChunk));
  parallel_chunks(size, kChunk, jobs, [&](int chunk, int begin, int end) {
    std::array<float, kChunk> heights;
    const float* x = points.x.data() + begin;
    const float* y = points.y.data() + begin;
    const float* z = points.z.data() + begin;
    const auto count = static_cast<std::size_t>(end - begin);
    for (std::size_t i = 0; i < count; ++i) heights[i] = height(x[i], y[i], z[i]);
    std::array<std::uint16_t, kChunk> kept;
    std::size_t size_kept = 0;
    for (std::size_t i = 0; i < count; ++i) {  // without a branch: the outcomes are mixed
      kept[size_kept] = static_cast<std::uint16_t>(i);
      size_kept += keep(heights[i]) ? 1 : 0;
    }
    PointArrays& part = parts[static_cast<std::size_t>(chunk)];
    part.resize(size_kept);
    for (std::size_t i = 0; i < size_kept; ++i) {
      part.x[i] = x[kept[i]];
      part.y[i] = y[kept[i]];
      part.z[i] = z[kept[i]];
    }
  });
  std::size_t all = 0;
  for (const PointArrays& part : parts) all += part.size();
  PointArrays selected;
  selected.reserve(all);
  for (const PointArrays& part : parts) {
    selected.x.insert(selected.x.end(), part.x.begin(), part.x.end());
    selected.y.insert(selected.y.end(), part.y.begin(), part.y.end());
    selected.z.insert(selected.z.end(), part.z.begin(), part.z.end());
  }
  return selected;
}

PointArrays within(const PointArrays& points, const SupportPlane& plane, double band, int jobs) {
  const auto limit = static_cast<float>(band);
  return select(points, plane, jobs, [limit](float height) { return std::abs(height) < limit; });
}

/// At most about `most` of the points, evenly over their order.
std::vector<Eigen::Vector3d> thinned(const PointArrays& points, std::size_t most) {
  const std::size_t stride = points.size() / most + 1;
  std::vector<Eigen::Vector3d> some;
  some.reserve(most);
  for (std::size_t i = 0; i < points.size(); i += stride) some.push_back(points.p(i));
  return some;
}

int count_within(const PointArrays& points, const SupportPlane& plane, double band) {
  const Eigen::Vector3f n = plane.normal.cast<float>();
  const auto offset = static_cast<float>(plane.offset);
  const auto limit = static_cast<float>(band);
  int count = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const float level = n.x() * points.x[i] + n.y() * points.y[i] + n.z() * points.z[i] - offset;
    count += std::abs(level) < limit ? 1 : 0;
  }
  return count;
}

/// RANSAC over point triples; stops when a better plane has become unlikely (eq. (5)).
std::optional<SupportPlane> draw_best_plane(const PointArrays& points, double band, int samples,
                                            Seed seed) {
  constexpr std::size_t kJudges = 1500;
  constexpr double kSuccess = 0.9999;
  PointArrays judges;
  for (const Eigen::Vector3d& p : thinned(points, kJudges)) {
    judges.push_back(static_cast<float>(p.x()), static_cast<float>(p.y()),
                     static_cast<float>(p.z()));
  }
  std::optional<SupportPlane> best;
  int most = 0;
  double needed = samples;
  for (int i = 0; i < needed; ++i) {
    Random random(derive_seed(seed, static_cast<std::uint64_t>(i)));
    const Eigen::Vector3d a = points.p(random.index(points.size()));
    const Eigen::Vector3d b = points.p(random.index(points.size()));
    const Eigen::Vector3d c = points.p(random.index(points.size()));
    const Eigen::Vector3d normal = (b - a).cross(c - a);
    if (!(normal.norm() > band * band)) continue;
    SupportPlane plane;
    plane.normal = normal.normalized();
    plane.offset = plane.normal.dot(a);
    const int votes = count_within(judges, plane, band);
    if (votes <= most) continue;
    most = votes;
    best = plane;
    const double share = static_cast<double>(votes) / static_cast<double>(judges.size());
    needed = std::min(needed, std::log1p(-kSuccess) / std::log1p(-std::pow(share, 3)));
  }
  return best;
}

/// Where the sensor sees the points, at most about `most` of them. Left out are those that are few
/// in their part of the image: where a rim is blurred into what lies behind it, single points come
/// to lie on any plane, and a convex outline would reach out to them.
std::vector<Eigen::Vector2d> seen_densely(const PointArrays& points, std::size_t most) {
  constexpr std::size_t kCells = 24;  // along each side
  constexpr double kSparse = 0.25;    // of the median
  std::vector<Eigen::Vector2d> seen(points.size());
  Eigen::AlignedBox2d box;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d p = points.p(i);
    seen[i] = {p.x() / p.z(), p.y() / p.z()};
    box.extend(seen[i]);
  }
  const Eigen::Array2d cell_size = box.sizes().array().max(1e-9) / static_cast<double>(kCells);
  const auto cell_of = [&](const Eigen::Vector2d& p) {
    const Eigen::Array2d at = ((p - box.min()).array() / cell_size).min(kCells - 1.0);
    return static_cast<std::size_t>(at.y()) * kCells + static_cast<std::size_t>(at.x());
  };
  std::vector<int> counts(kCells * kCells, 0);
  for (const Eigen::Vector2d& p : seen) ++counts[cell_of(p)];
  std::vector<int> filled;
  std::copy_if(counts.begin(), counts.end(), std::back_inserter(filled),
               [](int count) { return count > 0; });
  const auto middle = filled.begin() + static_cast<std::ptrdiff_t>(filled.size() / 2);
  std::nth_element(filled.begin(), middle, filled.end());
  const double least = kSparse * static_cast<double>(*middle);
  std::vector<Eigen::Vector2d> dense;
  const std::size_t stride = points.size() / most + 1;
  for (std::size_t i = 0; i < seen.size(); i += stride) {
    if (counts[cell_of(seen[i])] >= least) dense.push_back(seen[i]);
  }
  return dense;
}

/// The convex outline of what the sensor sees (monotone chain).
std::vector<Eigen::Vector2d> outline(std::vector<Eigen::Vector2d> seen) {
  std::sort(seen.begin(), seen.end(), [](const auto& a, const auto& b) {
    return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y();
  });
  const auto turn = [](const Eigen::Vector2d& o, const Eigen::Vector2d& a,
                       const Eigen::Vector2d& b) {
    return (a - o).x() * (b - o).y() - (a - o).y() * (b - o).x();
  };
  std::vector<Eigen::Vector2d> hull;
  for (int side = 0; side < 2; ++side) {
    const std::size_t start = hull.size();
    for (const Eigen::Vector2d& p : seen) {
      while (hull.size() >= start + 2 && turn(hull[hull.size() - 2], hull.back(), p) <= 0.0) {
        hull.pop_back();
      }
      hull.push_back(p);
    }
    hull.pop_back();
    std::reverse(seen.begin(), seen.end());
  }
  return hull;
}

bool inside(const std::vector<Eigen::Vector2d>& hull, const Eigen::Vector2d& p) {
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Eigen::Vector2d edge = hull[(i + 1) % hull.size()] - hull[i];
    const Eigen::Vector2d to = p - hull[i];
    if (edge.x() * to.y() - edge.y() * to.x() < 0.0) return false;
  }
  return hull.size() > 2;
}

/// Share of points, relative to those of the plane, that the sensor sees through the plane.
double share_behind(const SupportPlane& plane, const PointArrays& on_plane,
                    const PointArrays& points, int jobs) {
  // Along the ragged rim of a table one sees past it: the outline is shrunk a little.
  constexpr double kShrunk = 0.94;
  const std::vector<Eigen::Vector2d> hull = outline(seen_densely(on_plane, kOutlinePoints));
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& corner : hull) middle += corner / static_cast<double>(hull.size());
  const auto limit = static_cast<float>(-3.0 * plane.tolerance);
  const PointArrays below =
      select(points, plane, jobs, [limit](float height) { return height <= limit; });
  std::size_t behind = 0;
  for (std::size_t i = 0; i < below.size(); ++i) {
    const Eigen::Vector3d p = below.p(i);
    const Eigen::Vector2d seen(p.x() / p.z(), p.y() / p.z());
    if (inside(hull, middle + (seen - middle) / kShrunk)) ++behind;
  }
  return static_cast<double>(behind) / static_cast<double>(on_plane.size());
}

/// A drawn plane fitted to its points, with bow and tolerance; nothing when it has fewer than
/// `least_points`. `near` receives its points.
std::optional<SupportPlane> fit_support(const SupportPlane& drawn, const PointArrays& points,
                                        double leaf, double least_points, int jobs,
                                        PointArrays& near) {
  SupportPlane plane = drawn;
  for (int i = 0; i < 2; ++i) {
    near = within(points, plane, leaf, jobs);
    if (static_cast<double>(near.size()) < 0.5 * least_points) return std::nullopt;
    plane = fit_plane(thinned(near, kFitPoints));
  }
  double rms = fit_bow(plane, thinned(near, kFitPoints));
  near = within(points, plane, std::clamp(3.0 * rms, 0.8 * leaf, 2.0 * leaf), jobs);
  if (static_cast<double>(near.size()) < least_points) return std::nullopt;
  rms = fit_bow(plane, thinned(near, kFitPoints));
  plane.tolerance = std::clamp(3.0 * rms, 0.8 * leaf, 3.0 * leaf);
  return plane;
}

}  // namespace

double SupportPlane::height(const Eigen::Vector3d& p) const {
  return normal.dot(p) - offset - bow.dot(bow_terms(along_axes(*this, p)));
}

PlaneHeight::PlaneHeight(const SupportPlane& plane)
    : normal_(plane.normal.cast<float>()),
      axis_a_(plane.axes.col(0).cast<float>()),
      axis_b_(plane.axes.col(1).cast<float>()),
      middle_((plane.axes.transpose() * plane.centre).cast<float>()),
      reach_(plane.reach.cast<float>()),
      bow_(plane.bow.cast<float>()),
      offset_(static_cast<float>(plane.offset)) {}

std::vector<SupportPlane> find_support_planes(const SceneOctree& octree,
                                              const SupportPlaneOptions& options, Seed seed,
                                              int jobs) {
  const double leaf = octree.leaf_size();
  PointArrays all;
  all.reserve(static_cast<std::size_t>(octree.size()));
  for (const Eigen::Vector3f& p : octree.points()) all.push_back(p.x(), p.y(), p.z());
  PointArrays rest = all;
  std::vector<SupportPlane> planes;
  // A noisy plane fills about 1.5 leaves per leaf area.
  const double least_points = 1.5 * options.least_area / (leaf * leaf);
  PointArrays near;
  for (int attempt = 0; attempt < options.most_planes + kRejectedPlanes; ++attempt) {
    if (static_cast<int>(planes.size()) == options.most_planes ||
        static_cast<double>(rest.size()) < least_points) {
      break;
    }
    const auto drawn = draw_best_plane(rest, 0.8 * leaf, options.samples,
                                       derive_seed(seed, static_cast<std::uint64_t>(attempt)));
    if (!drawn) break;
    const auto plane = fit_support(*drawn, rest, leaf, least_points, jobs, near);
    if (!plane) break;
    const auto tolerance = static_cast<float>(plane->tolerance);
    if (share_behind(*plane, near, all, jobs) > options.most_behind) {
      // No support, but a smaller plane may be one.
      rest = select(rest, *plane, jobs,
                    [tolerance](float height) { return std::abs(height) >= tolerance; });
      continue;
    }
    planes.push_back(*plane);
    rest = select(rest, *plane, jobs, [tolerance](float height) { return height >= tolerance; });
  }
  return planes;
}

}  // namespace binpick
