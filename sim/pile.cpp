#include "sim/pile.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace binpick {
namespace {

// No surface point lies further from the origin.
double bounding_radius(const ObjectModel& model) {
  double squared = 0.0;
  for (const Eigen::Vector3d& vertex : model.mesh.vertices) {
    squared = std::max(squared, vertex.squaredNorm());
  }
  return std::sqrt(squared);
}

// No surface point is faster.
double surface_speed(const World& world, int object, double radius) {
  return world.object_velocity(object).norm() +
         radius * world.object_angular_velocity(object).norm();
}

std::vector<int> random_order(int count, Random& random) {
  std::vector<int> order(static_cast<std::size_t>(count));
  std::iota(order.begin(), order.end(), 0);
  for (std::size_t i = order.size(); i > 1; --i) {
    std::swap(order[i - 1], order[static_cast<std::size_t>(random.index(i))]);
  }
  return order;
}

// Where object `object` may start: clear of the walls and above everything that lies already.
Eigen::Isometry3d random_start(const World& world, int object, Random random) {
  const PileRecipe& pile = world.shared().parts.scene.pile;
  const double radius = bounding_radius(world.object_model(object));
  const double room = std::max(0.0, 0.5 * pile.frame_size - radius);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = random.rotation().toRotationMatrix();
  T.translation().x() = pile.centre.x() + random.uniform(-room, room);
  T.translation().y() = pile.centre.y() + random.uniform(-room, room);
  double height = pile.drop_height;
  for (int other = 0; other < world.object_count(); ++other) {
    if (other == object || world.object_parked(other)) continue;
    const double top =
        world.object_pose(other).translation().z() + bounding_radius(world.object_model(other));
    height = std::max(height, top + radius);
  }
  T.translation().z() = height;
  return T;
}

int steps_in(double seconds) { return static_cast<int>(std::lround(seconds / World::kStep)); }

void step_for(World& world, double seconds) {
  for (int i = steps_in(seconds); i > 0; --i) world.step();
}

std::vector<int> outside_pick_region(const World& world) {
  const Eigen::AlignedBox2d region = cell_layout(world.shared().parts.scene).pick_region;
  std::vector<int> outside;
  for (int i = 0; i < world.object_count(); ++i) {
    if (!region.contains(world.object_pose(i).translation().head<2>())) outside.push_back(i);
  }
  return outside;
}

constexpr int kMostAttempts = 20;

PileReport drop_once(World& world, Seed seed, int attempt) {
  const PileRecipe& recipe = world.shared().parts.scene.pile;
  world.hold_arm(true);
  world.set_frame_present(true);
  for (int i = 0; i < world.object_count(); ++i) world.park_object(i);
  Random order_draws(derive_seed(seed, "order"));
  for (const int object : random_order(world.object_count(), order_draws)) {
    const Seed start = derive_seed(derive_seed(seed, "start"), static_cast<std::uint64_t>(object));
    world.set_object_pose(object, random_start(world, object, Random(start)));
    step_for(world, recipe.drop_interval);
  }
  const double last_drop = world.time() - recipe.drop_interval;
  PileReport report;
  report.attempts = attempt;
  report.settled = settle(world, recipe.settle_limit);
  world.set_frame_present(false);
  report.settled = settle(world, recipe.settle_limit) && report.settled;
  report.settle_time = world.time() - last_drop;
  report.outside = outside_pick_region(world);
  return report;
}

}  // namespace

bool settle(World& world, double limit) {
  const PileRecipe& recipe = world.shared().parts.scene.pile;
  std::vector<double> radii;
  for (int i = 0; i < world.object_count(); ++i) {
    radii.push_back(bounding_radius(world.object_model(i)));
  }
  const auto moves = [&](int object) {
    return !world.object_parked(object) &&
           surface_speed(world, object, radii[std::size_t(object)]) > recipe.settle_speed;
  };
  // Steps are counted, for a sum of times depends on where it starts.
  int resting = 0;
  for (int left = steps_in(limit); left > 0; --left) {
    world.step();
    ++resting;
    for (int i = 0; i < world.object_count(); ++i) {
      if (moves(i)) resting = 0;
    }
    if (resting >= steps_in(recipe.settle_time)) return true;
  }
  return false;
}

PileReport drop_pile(World& world, Seed seed) {
  PileReport report;
  while (report.attempts < kMostAttempts) {
    const Seed attempt = derive_seed(seed, static_cast<std::uint64_t>(report.attempts));
    report = drop_once(world, attempt, report.attempts + 1);
    if (report.settled && report.outside.empty()) break;
  }
  return report;
}

}  // namespace binpick
