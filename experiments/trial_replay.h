#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

#include "experiments/replay_track.h"
#include "sim/world.h"

namespace binpick {

/// What a trial looked like over time, for the report's 3-D view: poses of all bodies and contact
/// forces at 25 frames per second, or fewer where a trial is so long that they would be more than
/// 6000. For people alone: no program takes decisions from it. Only looks at the world.
class TrialReplay {
 public:
  explicit TrialReplay(const World& world);

  /// To be called after each step of the world.
  void step(const World& world);
  /// Remarks on what happens now.
  void note(const World& world, std::string text);

  /// Writes what was recorded of `world` as a JSON file with the keys
  ///
  ///   format      1
  ///   scene       see replay_scene.h
  ///   start_s, interval_s, frames, position_step_m, force_step_n
  ///   bodies      per moving body of the scene, a track of its pose: position, quaternion (x y z
  ///   w)
  ///               in 1/32767; all zeros when it is out of the cell
  ///   contacts    per pair of touching things, their names (`first`, `second`) and a track of
  ///               the point where the force acts and the force on the second, world axes
  ///   peak_force  largest contact force on arm and gripper since the last frame, base64, 16 bits
  ///   notes       [time in s, text]
  ///
  /// where a track (replay_track.h) has `frames` and `values` in base64.
  /// @throws IoError
  void write(const World& world, const std::filesystem::path& file) const;

 private:
  /// The forces between two things, summed, and where they act on average.
  struct Contact {
    Eigen::Vector3d force_sum = Eigen::Vector3d::Zero();       // N, on the second
    Eigen::Vector3d weighted_point = Eigen::Vector3d::Zero();  // N m
    double weight = 0.0;                                       // N
  };
  using Pair = std::pair<int, int>;  // of bodies
  struct Frame {
    std::vector<float> poses;  // body by body, in steps
    std::map<Pair, Contact> contacts;
    double peak_force = 0.0;  // N
  };

  void add_frame(const World& world);
  [[nodiscard]] std::vector<float> poses_of(const World& world) const;
  void drop_every_other_frame();
  [[nodiscard]] nlohmann::json pose_tracks() const;
  [[nodiscard]] nlohmann::json contact_tracks(const mjModel& model) const;

  std::vector<int> bodies_;
  double start_ = 0.0;  // s
  long steps_ = 0;
  long steps_per_frame_ = 40;
  double peak_force_ = 0.0;
  std::vector<Frame> frames_;
  std::vector<std::pair<double, std::string>> notes_;
};

}  // namespace binpick
