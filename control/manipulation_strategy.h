#pragma once

namespace binpick {

/// What the robot does beyond IJRR 2012, piece by piece. With all pieces off it behaves as in the
/// paper; each can be tried alone.
struct ManipulationStrategy {
  /// The whole surfaces of the detected objects stand in the gripper's way, not only what the
  /// camera saw of them.
  bool hidden_sides = false;
  /// Grasps are charged for the probability that a finger comes down on the object, from the
  /// covariance of its pose; objects that are hardly believed in come last.
  bool uncertainty = false;
  /// Jaw width and load tell after lifting and again before placing whether the object is held.
  bool verification = false;
  /// After closing empty, another stored grasp at once, once per look.
  bool regrasp = false;
  /// A view with a doubtful detection is followed by another one, and the two are put together.
  bool second_look = false;
  /// Grasps up to 60 degrees off the vertical where none below the paper's 30 is possible.
  bool steep_grasps = false;
  /// Where no wanted object is found, every grasp of it has something in its way, or grasps of it
  /// have failed, others are put away first.
  bool clear_away = false;
  /// What cannot be grasped, or is seen and not recognized, is pushed to where it may; objects
  /// astray outside the pick region are fetched; the arm stoops over a pile as low as it sees it.
  bool search = false;

  [[nodiscard]] static constexpr ManipulationStrategy best() noexcept {
    return {true, true, true, true, true, true, true, true};
  }
};

}  // namespace binpick
