#include "recognition/mesh_simplification.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cstdint>
#include <map>
#include <queue>
#include <tuple>
#include <utility>
#include <vector>

namespace binpick {
namespace {

constexpr double kBorderWeight = 10.0;
constexpr double kLeastTurnCosine = 0.3;  // no triangle may turn further in one collapse

/// Squared distances to planes: p^T A p - 2 b^T p + c, and the area that they stand for.
struct Quadric {
  Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  double c = 0.0;
  double area = 0.0;

  void add_plane(const Eigen::Vector3d& normal, const Eigen::Vector3d& p, double weight) {
    const double offset = normal.dot(p);
    A += weight * normal * normal.transpose();
    b += weight * offset * normal;
    c += weight * offset * offset;
  }
  void add(const Quadric& other) {
    A += other.A;
    b += other.b;
    c += other.c;
    area += other.area;
  }
  [[nodiscard]] double mean_square(const Eigen::Vector3d& p) const {
    return std::max(p.dot(A * p) - 2.0 * b.dot(p) + c, 0.0) / area;
  }
};

class Simplification {
 public:
  Simplification(const TriangleMesh& mesh, double tolerance)
      : mesh_(mesh),
        most_(tolerance * tolerance),
        quadrics_(mesh.vertices.size()),
        triangles_of_(mesh.vertices.size()),
        versions_(mesh.vertices.size(), 0),
        is_alive_(mesh.triangles.size(), 1) {
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) add_triangle(t);
    for (const auto& [edge, uses] : edge_uses_) {
      if (uses == 1) add_border(edge.first, edge.second);
    }
    for (const auto& [edge, uses] : edge_uses_) push(edge.first, edge.second);
  }

  TriangleMesh run() {
    while (!queue_.empty()) {
      const Collapse collapse = queue_.top();
      queue_.pop();
      if (versions_[at(collapse.kept)] == collapse.kept_version &&
          versions_[at(collapse.gone)] == collapse.gone_version && is_allowed(collapse)) {
        apply(collapse);
      }
    }
    return compacted();
  }

 private:
  struct Collapse {
    double cost = 0.0;
    std::int32_t kept = 0, gone = 0;
    int kept_version = 0, gone_version = 0;
    Eigen::Vector3d p = Eigen::Vector3d::Zero();

    bool operator<(const Collapse& other) const {  // the cheapest is on top
      return std::tie(other.cost, other.kept, other.gone) < std::tie(cost, kept, gone);
    }
  };

  static std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }
  [[nodiscard]] const Eigen::Vector3d& vertex(std::int32_t i) const {
    return mesh_.vertices[at(i)];
  }

  void add_triangle(std::size_t t) {
    const auto& [a, b, c] = mesh_.triangles[t];
    const Eigen::Vector3d cross = (vertex(b) - vertex(a)).cross(vertex(c) - vertex(a));
    const double area = 0.5 * cross.norm();
    if (!(area > 0.0) || a == b || b == c || c == a) {
      is_alive_[t] = 0;
      return;
    }
    for (const std::int32_t corner : {a, b, c}) {
      quadrics_[at(corner)].add_plane(cross / (2.0 * area), vertex(a), area);
      quadrics_[at(corner)].area += area;
      triangles_of_[at(corner)].push_back(static_cast<std::int32_t>(t));
    }
    for (const auto& [from, to] : {std::pair{a, b}, std::pair{b, c}, std::pair{c, a}}) {
      ++edge_uses_[std::minmax(from, to)];
      border_normals_[std::minmax(from, to)] = cross / (2.0 * area);
    }
  }

  /// Keeps a border where it is: a plane through it, across the only triangle.
  void add_border(std::int32_t a, std::int32_t b) {
    const Eigen::Vector3d along = vertex(b) - vertex(a);
    const Eigen::Vector3d across = along.cross(border_normals_.at({a, b}));
    if (!(across.norm() > 0.0)) return;
    for (const std::int32_t corner : {a, b}) {
      quadrics_[at(corner)].add_plane(across.normalized(), vertex(a),
                                      kBorderWeight * along.squaredNorm());
    }
  }

  void push(std::int32_t a, std::int32_t b) {
    Quadric sum = quadrics_[at(a)];
    sum.add(quadrics_[at(b)]);
    if (!(sum.area > 0.0)) return;
    Collapse collapse{0.0, a, b, versions_[at(a)], versions_[at(b)], vertex(a)};
    collapse.cost = sum.mean_square(collapse.p);
    const auto try_at = [&](const Eigen::Vector3d& p) {
      const double cost = sum.mean_square(p);
      if (cost < collapse.cost) {
        collapse.cost = cost;
        collapse.p = p;
      }
    };
    try_at(vertex(b));
    const Eigen::Vector3d middle = 0.5 * (vertex(a) + vertex(b));
    try_at(middle);
    // Where the planes meet, if that is a point near the edge.
    const Eigen::LDLT<Eigen::Matrix3d> solver(sum.A);
    if (solver.vectorD().minCoeff() > 1e-3 * solver.vectorD().maxCoeff()) {
      const Eigen::Vector3d best = solver.solve(sum.b);
      if ((best - middle).norm() < (vertex(a) - vertex(b)).norm()) try_at(best);
    }
    if (collapse.cost < most_) queue_.push(collapse);
  }

  [[nodiscard]] std::vector<std::int32_t> neighbours(std::int32_t v) const {
    std::vector<std::int32_t> others;
    for (const std::int32_t t : triangles_of_[at(v)]) {
      for (const std::int32_t corner : mesh_.triangles[at(t)]) {
        if (corner != v) others.push_back(corner);
      }
    }
    std::sort(others.begin(), others.end());
    others.erase(std::unique(others.begin(), others.end()), others.end());
    return others;
  }

  [[nodiscard]] bool has_corner(std::int32_t t, std::int32_t v) const {
    const auto& corners = mesh_.triangles[at(t)];
    return std::find(corners.begin(), corners.end(), v) != corners.end();
  }

  [[nodiscard]] bool is_allowed(const Collapse& collapse) const {
    // The surface stays one where the two share exactly the corners of the edge's triangles.
    const std::vector<std::int32_t> a = neighbours(collapse.kept);
    const std::vector<std::int32_t> b = neighbours(collapse.gone);
    std::vector<std::int32_t> shared;
    std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(shared));
    const auto& triangles = triangles_of_[at(collapse.gone)];
    const auto of_edge = std::count_if(triangles.begin(), triangles.end(), [&](std::int32_t t) {
      return has_corner(t, collapse.kept);
    });
    if (static_cast<std::ptrdiff_t>(shared.size()) != of_edge) return false;
    return keeps_orientation(collapse.kept, collapse) && keeps_orientation(collapse.gone, collapse);
  }

  [[nodiscard]] bool keeps_orientation(std::int32_t moved, const Collapse& collapse) const {
    const std::int32_t other = moved == collapse.kept ? collapse.gone : collapse.kept;
    const auto& triangles = triangles_of_[at(moved)];
    return std::all_of(triangles.begin(), triangles.end(), [&](std::int32_t t) {
      if (has_corner(t, other)) return true;
      std::array<Eigen::Vector3d, 3> before;
      std::array<Eigen::Vector3d, 3> after;
      for (std::size_t i = 0; i < 3; ++i) {
        const std::int32_t corner = mesh_.triangles[at(t)][i];
        before[i] = vertex(corner);
        after[i] = corner == moved ? collapse.p : vertex(corner);
      }
      const Eigen::Vector3d n = (before[1] - before[0]).cross(before[2] - before[0]);
      const Eigen::Vector3d m = (after[1] - after[0]).cross(after[2] - after[0]);
      return n.dot(m) > kLeastTurnCosine * n.norm() * m.norm();
    });
  }

  void apply(const Collapse& collapse) {
    mesh_.vertices[at(collapse.kept)] = collapse.p;
    quadrics_[at(collapse.kept)].add(quadrics_[at(collapse.gone)]);
    ++versions_[at(collapse.kept)];
    ++versions_[at(collapse.gone)];
    std::vector<std::int32_t>& kept = triangles_of_[at(collapse.kept)];
    for (const std::int32_t t : triangles_of_[at(collapse.gone)]) {
      if (has_corner(t, collapse.kept)) {
        is_alive_[at(t)] = 0;
        for (const std::int32_t corner : mesh_.triangles[at(t)]) {
          if (corner != collapse.gone) std::erase(triangles_of_[at(corner)], t);
        }
        continue;
      }
      for (std::int32_t& corner : mesh_.triangles[at(t)]) {
        if (corner == collapse.gone) corner = collapse.kept;
      }
      kept.push_back(t);
    }
    triangles_of_[at(collapse.gone)].clear();
    for (const std::int32_t other : neighbours(collapse.kept)) {
      push(std::min(other, collapse.kept), std::max(other, collapse.kept));
    }
  }

  [[nodiscard]] TriangleMesh compacted() const {
    TriangleMesh result;
    std::vector<std::int32_t> renamed(mesh_.vertices.size(), -1);
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
      if (is_alive_[t] == 0) continue;
      std::array<std::int32_t, 3> corners = mesh_.triangles[t];
      for (std::int32_t& corner : corners) {
        std::int32_t& name = renamed[at(corner)];
        if (name < 0) {
          name = static_cast<std::int32_t>(result.vertices.size());
          result.vertices.push_back(vertex(corner));
        }
        corner = name;
      }
      result.triangles.push_back(corners);
    }
    return result;
  }

  TriangleMesh mesh_;
  double most_;
  std::vector<Quadric> quadrics_;
  std::vector<std::vector<std::int32_t>> triangles_of_;
  std::vector<int> versions_;
  std::vector<char> is_alive_;
  std::map<std::pair<std::int32_t, std::int32_t>, int> edge_uses_;
  std::map<std::pair<std::int32_t, std::int32_t>, Eigen::Vector3d> border_normals_;
  std::priority_queue<Collapse> queue_;
};

}  // namespace

TriangleMesh simplify(const TriangleMesh& mesh, double tolerance) {
  return Simplification(mesh, tolerance).run();
}

}  // namespace binpick
