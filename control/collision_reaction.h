#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

#include "control/arm_controller.h"
#include "control/cartesian_trajectory.h"
#include "control/contact_monitor.h"

namespace binpick {

/// What to do when a motion meets a collision (Haddadin et al. 2008; the numbering of strategies
/// differs between papers).
enum class Reaction {
  kNone,     ///< go on
  kStop,     ///< hold where the arm is, the stored spring cancelled
  kFloat,    ///< gravity-compensated torque mode for a while, then hold
  kRetreat,  ///< a reflex: draw back along the contact force, then hold
  kYield,    ///< admittance: move on with the contact force until it has gone, then hold
  kSlow,     ///< slow the time along the path by the contact force, even run it backwards
};
[[nodiscard]] std::string_view to_text(Reaction reaction) noexcept;

enum class ReactionState {
  kNominal,
  kContact,  ///< touching, compliant, going on
  kSlowed,   ///< going on as fast as the contact force lets it
  kFloating,
  kRetreating,
  kYielding,
  kStopped,  ///< the motion has ended
};
[[nodiscard]] std::string_view to_text(ReactionState state) noexcept;

/// What a tick found out.
enum class ReactionEvent {
  kCalm,      ///< nothing is touched
  kTouched,   ///< a contact below the collision threshold
  kCollided,  ///< hf1
  kElapsed,   ///< the state has lasted as long as it may
};
[[nodiscard]] std::string_view to_text(ReactionEvent event) noexcept;

/// What is done on entering a state.
enum class ReactionAction { kNothing, kStop, kFloat, kRetreat, kYield };

/// One row of the reaction table. Of the rows for a state and an event the first whose guard holds
/// for the selected reaction is taken; without one the state stays.
struct ReactionTransition {
  ReactionState from;
  ReactionEvent event;
  bool (*guard)(Reaction) noexcept;
  ReactionState to;
  ReactionAction action;
  std::string_view meaning;
};
[[nodiscard]] const std::vector<ReactionTransition>& reaction_table();

struct ReactionOptions {
  double float_time = 0.5;         ///< s
  double retreat_distance = 0.03;  ///< m
  double retreat_speed = 0.2;      ///< m/s
  /// Speed of yielding per force, m/s per N: 0.15 m/s at 15 N.
  double yield_gain = 0.01;
  double yield_time = 1.0;  ///< s, at most
  /// N: the path stands still at this contact force and runs backwards beyond it.
  double standstill_force = 15.0;
  double fastest_back = 0.5;  ///< share of the planned speed at which a path may run backwards
  double slow_time = 2.0;     ///< s; slowed for longer than this, the motion is stopped

  /// @throws InputError listing every value that makes no sense.
  void validate() const;
};

/// One transition that took place.
struct ReactionRecord {
  double time = 0.0;  ///< s since the construction of the reaction
  ReactionState from = ReactionState::kNominal;
  ReactionEvent event = ReactionEvent::kCalm;
  ReactionState to = ReactionState::kNominal;
  ReactionAction action = ReactionAction::kNothing;
  double force = 0.0;  ///< estimated, N
};

/// Decides by the table what a motion does about contacts and collisions, and does it through the
/// controller. Allocates nothing after its construction.
///
///   reaction.begin(Reaction::kRetreat);
///   for (...) {
///     if (!reaction.drives()) controller.set_cartesian_target(line.sample(t));
///     command.tau = controller.tick(...);
///     reaction.update(kControlPeriod);
///     t += reaction.path_rate() * kControlPeriod;
///     if (reaction.stopped()) break;
///   }
class CollisionReaction {
 public:
  /// `controller` must outlive the reaction.
  explicit CollisionReaction(ArmController& controller, const ReactionOptions& options = {});

  /// A new motion: back to the nominal state, with this reaction selected.
  void begin(Reaction reaction) noexcept;
  /// After each tick of the controller.
  void update(double dt) noexcept;

  [[nodiscard]] ReactionState state() const noexcept { return state_; }
  [[nodiscard]] Reaction selected() const noexcept { return selected_; }
  /// The motion has ended by a collision; the arm holds.
  [[nodiscard]] bool stopped() const noexcept { return state_ == ReactionState::kStopped; }
  /// The reaction moves the arm: no targets from elsewhere meanwhile.
  [[nodiscard]] bool drives() const noexcept;
  /// How fast the time along the path runs: 1 as planned.
  [[nodiscard]] double path_rate() const noexcept { return path_rate_; }

  /// The last transitions, oldest first; up to `kLogSize`.
  [[nodiscard]] std::vector<ReactionRecord> log() const;
  /// All transitions so far, also those that the log has forgotten.
  [[nodiscard]] std::size_t transitions() const noexcept { return transitions_; }
  static constexpr std::size_t kLogSize = 256;

 private:
  [[nodiscard]] ReactionEvent event() const noexcept;
  [[nodiscard]] double allowed_time() const noexcept;
  void take(const ReactionTransition& transition) noexcept;
  void start_retreat() noexcept;
  void drive(double dt) noexcept;

  ArmController& controller_;
  ReactionOptions options_;
  Reaction selected_ = Reaction::kStop;
  ReactionState state_ = ReactionState::kNominal;
  double time_ = 0.0;
  double entered_ = 0.0;  ///< when the state was entered
  double path_rate_ = 1.0;
  std::optional<CartesianTrajectory> retreat_;
  Eigen::Isometry3d T_world_yield_ = Eigen::Isometry3d::Identity();
  std::array<ReactionRecord, kLogSize> records_;
  std::size_t transitions_ = 0;
};

}  // namespace binpick
