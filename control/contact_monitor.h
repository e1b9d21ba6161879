#pragma once

#include <cstddef>

#include "control/arm_model.h"
#include "control/operational_space.h"

namespace binpick {

/// What the arm is about to do: how much force is expected.
enum class ContactPhase {
  kFree,      ///< moving through free space: nothing should be touched, tool or elbow
  kApproach,  ///< the last 0.1 m to the object
  kGrasp,     ///< jaws closing and lifting
  kPlace,     ///< lowering until contact
};
inline constexpr std::size_t kContactPhases = 4;

/// When touch is contact and when it is collision: "a contact is classified as a collision if the
/// magnitude of the contact force exceeds a certain limit" (IJRR 2012, section 5.2).
struct ContactThresholds {
  double contact_force = 5.0;     ///< N, |F| at the tool centre
  double collision_force = 15.0;  ///< N; 10 for slow, 20 for fast motions are sensible
  /// Nm; a residual beyond it is a collision wherever the arm is touched.
  JointVector joint_torque = JointVector::Constant(2.0);
  int samples = 2;          ///< consecutive ticks over a threshold that make a collision
  double hysteresis = 0.5;  ///< a state ends below this share of the threshold that began it

  /// The defaults of a phase. In free space joint thresholds are max(2 Nm, 5 % of the effort
  /// limit). Where the tool may touch, they are three times that, so that the tool's force
  /// decides: 2 Nm at the wrist is reached by 7 N across the tool.
  [[nodiscard]] static ContactThresholds for_phase(ContactPhase phase, const JointLimits& limits);
  /// @throws InputError listing every value that makes no sense.
  void validate() const;
};

enum class ContactClass { kNone, kContact, kCollision };

/// Tells contact from collision by the observer's estimate.
class ContactMonitor {
 public:
  explicit ContactMonitor(const ContactThresholds& thresholds) noexcept : thresholds_(thresholds) {}

  /// Takes effect at the next update; a contact or collision under way is judged by the new values.
  void set_thresholds(const ContactThresholds& thresholds) noexcept { thresholds_ = thresholds; }
  void reset() noexcept;

  /// One control tick.
  /// @param wrench estimated external wrench at the tool centre, N and Nm.
  /// @param residual estimated external joint torques, Nm.
  void update(const Vector6& wrench, const JointVector& residual) noexcept;

  [[nodiscard]] ContactClass contact_class() const noexcept { return class_; }
  /// The binary collision signal of Figs. 5 and 6.
  [[nodiscard]] bool hf1() const noexcept { return class_ == ContactClass::kCollision; }
  [[nodiscard]] const ContactThresholds& thresholds() const noexcept { return thresholds_; }

 private:
  ContactThresholds thresholds_;
  ContactClass class_ = ContactClass::kNone;
  int samples_over_ = 0;
};

}  // namespace binpick
