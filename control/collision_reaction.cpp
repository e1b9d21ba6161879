#include "control/collision_reaction.h"

#include <algorithm>
#include <string>

#include "models/errors.h"

namespace binpick {
namespace {

using State = ReactionState;
using Event = ReactionEvent;
using Action = ReactionAction;

bool always(Reaction) noexcept { return true; }
template <Reaction reaction>
bool chosen(Reaction selected) noexcept {
  return selected == reaction;
}

// Below this force at the tool the contact is elsewhere on the arm, N.
constexpr double kForceWithDirection = 2.0;

}  // namespace

const std::vector<ReactionTransition>& reaction_table() {
  constexpr auto kNone = chosen<Reaction::kNone>;
  constexpr auto kStop = chosen<Reaction::kStop>;
  constexpr auto kFloat = chosen<Reaction::kFloat>;
  constexpr auto kRetreat = chosen<Reaction::kRetreat>;
  constexpr auto kYield = chosen<Reaction::kYield>;
  constexpr auto kSlow = chosen<Reaction::kSlow>;
  static const std::vector<ReactionTransition> kTable = {
      {State::kNominal, Event::kTouched, kSlow, State::kSlowed, Action::kNothing, "give way"},
      {State::kNominal, Event::kTouched, always, State::kContact, Action::kNothing, "compliant"},
      {State::kNominal, Event::kCollided, kNone, State::kContact, Action::kNothing, "go on"},
      {State::kNominal, Event::kCollided, kStop, State::kStopped, Action::kStop, "hold"},
      {State::kNominal, Event::kCollided, kFloat, State::kFloating, Action::kFloat, "go limp"},
      {State::kNominal, Event::kCollided, kRetreat, State::kRetreating, Action::kRetreat, "reflex"},
      {State::kNominal, Event::kCollided, kYield, State::kYielding, Action::kYield, "follow"},
      {State::kNominal, Event::kCollided, kSlow, State::kSlowed, Action::kNothing, "give way"},

      {State::kContact, Event::kCalm, always, State::kNominal, Action::kNothing, "free again"},
      {State::kContact, Event::kCollided, kStop, State::kStopped, Action::kStop, "hold"},
      {State::kContact, Event::kCollided, kFloat, State::kFloating, Action::kFloat, "go limp"},
      {State::kContact, Event::kCollided, kRetreat, State::kRetreating, Action::kRetreat, "reflex"},
      {State::kContact, Event::kCollided, kYield, State::kYielding, Action::kYield, "follow"},

      {State::kSlowed, Event::kCalm, always, State::kNominal, Action::kNothing, "free again"},
      {State::kSlowed, Event::kElapsed, always, State::kStopped, Action::kStop, "no way through"},
      {State::kFloating, Event::kElapsed, always, State::kStopped, Action::kStop, "hold there"},
      {State::kRetreating, Event::kElapsed, always, State::kStopped, Action::kStop, "hold there"},
      {State::kYielding, Event::kCalm, always, State::kStopped, Action::kStop, "hold there"},
      {State::kYielding, Event::kElapsed, always, State::kStopped, Action::kStop, "hold there"},
  };
  return kTable;
}

std::string_view to_text(Reaction reaction) noexcept {
  switch (reaction) {
    case Reaction::kNone:
      return "none";
    case Reaction::kStop:
      return "stop";
    case Reaction::kFloat:
      return "float";
    case Reaction::kRetreat:
      return "retreat";
    case Reaction::kYield:
      return "yield";
    case Reaction::kSlow:
      return "slow";
  }
  return "";
}

std::string_view to_text(ReactionState state) noexcept {
  switch (state) {
    case State::kNominal:
      return "nominal";
    case State::kContact:
      return "contact";
    case State::kSlowed:
      return "slowed";
    case State::kFloating:
      return "floating";
    case State::kRetreating:
      return "retreating";
    case State::kYielding:
      return "yielding";
    case State::kStopped:
      return "stopped";
  }
  return "";
}

std::string_view to_text(ReactionEvent event) noexcept {
  switch (event) {
    case Event::kCalm:
      return "calm";
    case Event::kTouched:
      return "touched";
    case Event::kCollided:
      return "collided";
    case Event::kElapsed:
      return "elapsed";
  }
  return "";
}

void ReactionOptions::validate() const {
  std::string problems;
  if (!(float_time > 0.0 && yield_time > 0.0 && slow_time > 0.0)) {
    problems += "times must be positive\n";
  }
  if (!(retreat_distance > 0.0 && retreat_speed > 0.0)) {
    problems += "a retreat must lead somewhere\n";
  }
  if (!(yield_gain > 0.0)) problems += "the gain of yielding must be positive\n";
  if (!(standstill_force > 0.0)) problems += "the standstill force must be positive\n";
  if (!(fastest_back >= 0.0)) problems += "the speed backwards must not be negative\n";
  if (!problems.empty()) throw InputError("collision reaction: " + problems);
}

CollisionReaction::CollisionReaction(ArmController& controller, const ReactionOptions& options)
    : controller_(controller), options_(options) {
  options_.validate();
}

void CollisionReaction::begin(Reaction reaction) noexcept {
  selected_ = reaction;
  state_ = State::kNominal;
  entered_ = time_;
  path_rate_ = 1.0;
}

bool CollisionReaction::drives() const noexcept {
  return state_ != State::kNominal && state_ != State::kContact && state_ != State::kSlowed;
}

ReactionEvent CollisionReaction::event() const noexcept {
  if (time_ - entered_ >= allowed_time()) return Event::kElapsed;
  const ArmStatus& status = controller_.status();
  if (status.collision) return Event::kCollided;
  return status.contact ? Event::kTouched : Event::kCalm;
}

double CollisionReaction::allowed_time() const noexcept {
  switch (state_) {
    case State::kSlowed:
      return options_.slow_time;
    case State::kFloating:
      return options_.float_time;
    case State::kRetreating:
      return retreat_->duration();
    case State::kYielding:
      return options_.yield_time;
    case State::kNominal:
    case State::kContact:
    case State::kStopped:
      break;
  }
  return std::numeric_limits<double>::infinity();
}

void CollisionReaction::update(double dt) noexcept {
  time_ += dt;
  const Event happened = event();
  for (const ReactionTransition& transition : reaction_table()) {
    if (transition.from == state_ && transition.event == happened && transition.guard(selected_)) {
      take(transition);
      break;
    }
  }
  drive(dt);
}

void CollisionReaction::take(const ReactionTransition& transition) noexcept {
  const double force = controller_.status().external_wrench.head<3>().norm();
  records_[transitions_ % kLogSize] = {time_,         transition.from,   transition.event,
                                       transition.to, transition.action, force};
  ++transitions_;
  state_ = transition.to;
  entered_ = time_;
  switch (transition.action) {
    case Action::kStop:
      controller_.stop();
      break;
    case Action::kFloat:
      controller_.float_freely();
      break;
    case Action::kRetreat:
      start_retreat();
      break;
    case Action::kYield:
      controller_.cancel_spring();
      T_world_yield_ = controller_.status().T_world_tcp;
      break;
    case Action::kNothing:
      break;
  }
}

void CollisionReaction::start_retreat() noexcept {
  controller_.cancel_spring();
  const ArmStatus& status = controller_.status();
  // Away from what pushes; from where the tool came if it is not the tool that is touched.
  const Eigen::Vector3d force = status.external_wrench.head<3>();
  const Eigen::Vector3d direction = force.norm() > kForceWithDirection
                                        ? force.normalized()
                                        : -status.twist.head<3>().normalized();
  Eigen::Isometry3d goal = status.T_world_tcp;
  goal.translation() += options_.retreat_distance * direction;
  retreat_.emplace(status.T_world_tcp, goal,
                   CartesianMotionLimits::at_speed(options_.retreat_speed));
}

void CollisionReaction::drive(double dt) noexcept {
  const ArmStatus& status = controller_.status();
  const Eigen::Vector3d force = status.external_wrench.head<3>();
  path_rate_ = state_ == State::kSlowed ? std::clamp(1.0 - force.norm() / options_.standstill_force,
                                                     -options_.fastest_back, 1.0)
                                        : 1.0;
  if (state_ == State::kRetreating) {
    controller_.set_cartesian_target(retreat_->sample(time_ - entered_));
  } else if (state_ == State::kYielding) {
    CartesianTarget target;
    target.twist.head<3>() = options_.yield_gain * force;
    T_world_yield_.translation() += dt * target.twist.head<3>();
    target.T_world_tcp = T_world_yield_;
    controller_.set_cartesian_target(target);
  }
}

std::vector<ReactionRecord> CollisionReaction::log() const {
  std::vector<ReactionRecord> records;
  const std::size_t first = transitions_ > kLogSize ? transitions_ - kLogSize : 0;
  for (std::size_t i = first; i < transitions_; ++i) records.push_back(records_[i % kLogSize]);
  return records;
}

}  // namespace binpick
