#include "control/arm_model.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <string>

#include "models/errors.h"

namespace binpick {
namespace {

constexpr double kGravity = 9.81;  // m/s^2, along -z of the world

Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

/// Inertia of a point mass at c about the origin: m (c.c 1 - c c^T).
Eigen::Matrix3d point_inertia(double mass, const Eigen::Vector3d& c) {
  Eigen::Matrix3d inertia = -mass * c * c.transpose();
  inertia.diagonal().array() += mass * c.squaredNorm();
  return inertia;
}

/// Velocity-like (motion) spatial vector about the base origin.
struct Motion {
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();

  Motion& add(const Motion& other, double factor) noexcept {
    angular += factor * other.angular;
    linear += factor * other.linear;
    return *this;
  }
};

/// Force-like (force or momentum) spatial vector about the base origin.
struct Force {
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();

  Force& operator+=(const Force& other) noexcept {
    moment += other.moment;
    linear += other.linear;
    return *this;
  }
};

double dot(const Motion& m, const Force& f) noexcept {
  return m.angular.dot(f.moment) + m.linear.dot(f.linear);
}

/// v x m, the rate of a motion vector that is carried along with velocity v.
Motion cross(const Motion& v, const Motion& m) noexcept {
  return {v.angular.cross(m.angular), v.angular.cross(m.linear) + v.linear.cross(m.angular)};
}

/// v x* f, the same for a force vector.
Force cross(const Motion& v, const Force& f) noexcept {
  return {v.angular.cross(f.moment) + v.linear.cross(f.linear), v.angular.cross(f.linear)};
}

/// Inertia of a rigid body about the base origin, world axes.
struct SpatialInertia {
  double mass = 0.0;
  Eigen::Vector3d first_moment = Eigen::Vector3d::Zero();   // m c
  Eigen::Matrix3d second_moment = Eigen::Matrix3d::Zero();  // about the origin

  SpatialInertia& operator+=(const SpatialInertia& other) noexcept {
    mass += other.mass;
    first_moment += other.first_moment;
    second_moment += other.second_moment;
    return *this;
  }
};

SpatialInertia placed(const BodyInertia& body, const Eigen::Matrix3d& R,
                      const Eigen::Vector3d& p) noexcept {
  const Eigen::Vector3d com = p + R * body.com;
  SpatialInertia inertia;
  inertia.mass = body.mass;
  inertia.first_moment = body.mass * com;
  inertia.second_moment.noalias() = R * body.inertia * R.transpose();
  inertia.second_moment += point_inertia(body.mass, com);
  return inertia;
}

Force operator*(const SpatialInertia& inertia, const Motion& m) noexcept {
  return {inertia.second_moment * m.angular + inertia.first_moment.cross(m.linear),
          inertia.mass * m.linear - inertia.first_moment.cross(m.angular)};
}

/// The wrench that holds a body still against gravity.
Force weight(double mass, const Eigen::Vector3d& first_moment) noexcept {
  return {Eigen::Vector3d(kGravity * first_moment.y(), -kGravity * first_moment.x(), 0.0),
          Eigen::Vector3d(0.0, 0.0, kGravity * mass)};
}

/// A hinge through p along z.
Motion hinge(const Eigen::Vector3d& p, const Eigen::Vector3d& z) noexcept {
  return {z, p.cross(z)};
}

void check_body(const std::string& where, const BodyInertia& body) {
  if (!(body.mass >= 0.0) || !body.com.allFinite() || !body.inertia.allFinite()) {
    throw InputError(where + ": mass and inertia must be finite, the mass not negative");
  }
  if (!body.inertia.isApprox(body.inertia.transpose(), 1e-9) && body.inertia.norm() > 1e-15) {
    throw InputError(where + ": the inertia matrix must be symmetric");
  }
  const Eigen::Vector3d moments =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(body.inertia).eigenvalues();
  const double largest = moments.maxCoeff();
  if (moments.minCoeff() < -1e-9 || largest > moments.sum() - largest + 1e-9) {
    throw InputError(where +
                     ": no body has this inertia; its principal moments must be positive and each "
                     "at most the sum of the other two");
  }
}

void check_joint(const std::string& where, const JointDescription& joint) {
  if (std::abs(joint.axis.norm() - 1.0) > 1e-6) {
    throw InputError(where + ": the joint axis must have length one");
  }
  if (!(joint.lower < joint.upper)) {
    throw InputError(where + ": the lower position limit must be below the upper one");
  }
  if (!(joint.velocity > 0.0) || !(joint.effort > 0.0)) {
    throw InputError(where + ": velocity and effort limits must be positive");
  }
}

}  // namespace

BodyInertia combine(const BodyInertia& a, const BodyInertia& b) {
  BodyInertia sum;
  sum.mass = a.mass + b.mass;
  if (sum.mass > 0.0) {
    sum.com = (a.mass * a.com + b.mass * b.com) / sum.mass;
  }
  sum.inertia = a.inertia + point_inertia(a.mass, a.com - sum.com) + b.inertia +
                point_inertia(b.mass, b.com - sum.com);
  return sum;
}

BodyInertia transformed(const Eigen::Isometry3d& T_a_b, const BodyInertia& body) {
  BodyInertia moved;
  moved.mass = body.mass;
  moved.com = T_a_b * body.com;
  moved.inertia = T_a_b.linear() * body.inertia * T_a_b.linear().transpose();
  return moved;
}

ArmModel::ArmModel(const RobotDescription& robot, const GripperDescription& gripper,
                   const Eigen::Isometry3d& T_world_base)
    : T_world_base_(T_world_base),
      T_link7_flange_(robot.T_link7_flange),
      T_link7_tcp_(robot.T_link7_flange * gripper.T_flange_tcp) {
  for (int i = 0; i < kArmJoints; ++i) {
    const JointDescription& joint = robot.joints[static_cast<std::size_t>(i)];
    const LinkDescription& description = robot.links[static_cast<std::size_t>(i)];
    check_joint(fmt::format("{}: joint {}", robot.name, joint.name), joint);
    check_body(fmt::format("{}: link {}", robot.name, description.name), description.inertia);

    Link& link = links_[static_cast<std::size_t>(i)];
    const Eigen::Matrix3d k = skew(joint.axis.normalized());
    link.R_zero = joint.T_parent_joint.linear();
    link.R_sin = link.R_zero * k;
    link.R_cos = link.R_zero * k * k;
    link.p_parent = joint.T_parent_joint.translation();
    link.axis = joint.axis.normalized();
    link.body = description.inertia;
    limits_.lower[i] = joint.lower;
    limits_.upper[i] = joint.upper;
    limits_.velocity[i] = joint.velocity;
    limits_.effort[i] = joint.effort;
  }
  const BodyInertia tool = gripper.tool_inertia(gripper.stroke.centre());
  check_body("gripper", tool);
  links_.back().body = combine(links_.back().body, transformed(T_link7_flange_, tool));
}

ArmModel ArmModel::with_payload(const BodyInertia& payload) const {
  check_body("payload", payload);
  ArmModel loaded = *this;
  loaded.links_.back().body = combine(links_.back().body, transformed(T_link7_tcp_, payload));
  return loaded;
}

ArmModel::Chain ArmModel::chain(const JointVector& q) const noexcept {
  Chain result;
  Eigen::Matrix3d R = T_world_base_.linear();
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < links_.size(); ++i) {
    const Link& link = links_[i];
    const double angle = q[static_cast<Eigen::Index>(i)];
    p += R * link.p_parent;
    const Eigen::Matrix3d R_parent_link =
        link.R_zero + std::sin(angle) * link.R_sin + (1.0 - std::cos(angle)) * link.R_cos;
    R = (R * R_parent_link).eval();
    result.R[i] = R;
    result.p[i] = p;
    result.z[i] = R * link.axis;
  }
  return result;
}

ArmDynamics ArmModel::evaluate(const JointVector& q, const JointVector& qd) const noexcept {
  const Chain arm = chain(q);
  std::array<Motion, kArmJoints> S;
  std::array<Motion, kArmJoints> S_dot;
  std::array<SpatialInertia, kArmJoints> inertia;
  std::array<Force, kArmJoints> momentum;
  std::array<Force, kArmJoints> force;

  Motion velocity;
  Motion acceleration;  // with qdd = 0
  for (std::size_t i = 0; i < links_.size(); ++i) {
    const double rate = qd[static_cast<Eigen::Index>(i)];
    S[i] = hinge(arm.p[i], arm.z[i]);
    S_dot[i] = cross(velocity, S[i]);
    velocity.add(S[i], rate);
    acceleration.add(S_dot[i], rate);
    inertia[i] = placed(links_[i].body, arm.R[i], arm.p[i]);
    momentum[i] = inertia[i] * velocity;
    force[i] = inertia[i] * acceleration;
    force[i] += cross(velocity, momentum[i]);
  }

  ArmDynamics result;
  for (std::size_t i = links_.size(); i-- > 0;) {
    const Eigen::Index row = static_cast<Eigen::Index>(i);
    result.coriolis[row] = dot(S[i], force[i]);
    // Half the gradient of qd^T M qd: turning joint i moves the velocity that link i sees from
    // below by -S_i x v_(i-1), against the momentum of all that hangs on it.
    result.coriolis_transposed[row] = dot(S_dot[i], momentum[i]);
    result.gravity[row] = dot(S[i], weight(inertia[i].mass, inertia[i].first_moment));
    const Force column = inertia[i] * S[i];
    for (std::size_t j = 0; j <= i; ++j) {
      const Eigen::Index other = static_cast<Eigen::Index>(j);
      result.M(row, other) = result.M(other, row) = dot(S[j], column);
    }
    if (i > 0) {
      inertia[i - 1] += inertia[i];
      momentum[i - 1] += momentum[i];
      force[i - 1] += force[i];
    }
  }

  result.T_world_tcp.linear().noalias() = arm.R.back() * T_link7_tcp_.linear();
  const Eigen::Vector3d p_tcp = arm.p.back() + arm.R.back() * T_link7_tcp_.translation();
  const Eigen::Vector3d v_tcp = velocity.linear + velocity.angular.cross(p_tcp);
  result.T_world_tcp.translation() = T_world_base_.translation() + p_tcp;
  result.T_world_tcp.makeAffine();
  for (int i = 0; i < kArmJoints; ++i) {
    const Motion& axis = S[static_cast<std::size_t>(i)];
    const Motion& axis_dot = S_dot[static_cast<std::size_t>(i)];
    result.J.col(i) << axis.linear + axis.angular.cross(p_tcp), axis.angular;
    result.J_dot.col(i) << axis_dot.linear + axis_dot.angular.cross(p_tcp) +
                               axis.angular.cross(v_tcp),
        axis_dot.angular;
  }
  return result;
}

Eigen::Isometry3d ArmModel::forward_kinematics(const JointVector& q) const noexcept {
  return link_poses(q).back() * T_link7_tcp_;
}

std::array<Eigen::Isometry3d, kArmJoints + 1> ArmModel::link_poses(
    const JointVector& q) const noexcept {
  const Chain arm = chain(q);
  std::array<Eigen::Isometry3d, kArmJoints + 1> poses;
  poses[0] = T_world_base_;
  for (std::size_t i = 0; i < links_.size(); ++i) {
    poses[i + 1].linear() = arm.R[i];
    poses[i + 1].translation() = T_world_base_.translation() + arm.p[i];
    poses[i + 1].makeAffine();
  }
  return poses;
}

Jacobian ArmModel::jacobian(const JointVector& q) const noexcept {
  const Chain arm = chain(q);
  const Eigen::Vector3d p_tcp = arm.p.back() + arm.R.back() * T_link7_tcp_.translation();
  Jacobian J;
  for (int i = 0; i < kArmJoints; ++i) {
    const std::size_t joint = static_cast<std::size_t>(i);
    J.col(i) << arm.z[joint].cross(p_tcp - arm.p[joint]), arm.z[joint];
  }
  return J;
}

JointVector ArmModel::gravity(const JointVector& q) const noexcept {
  const Chain arm = chain(q);
  JointVector torque;
  double mass = 0.0;
  Eigen::Vector3d first_moment = Eigen::Vector3d::Zero();
  for (std::size_t i = links_.size(); i-- > 0;) {
    const BodyInertia& body = links_[i].body;
    mass += body.mass;
    first_moment += body.mass * (arm.p[i] + arm.R[i] * body.com);
    torque[static_cast<Eigen::Index>(i)] =
        dot(hinge(arm.p[i], arm.z[i]), weight(mass, first_moment));
  }
  return torque;
}

double ArmModel::potential_energy(const JointVector& q) const noexcept {
  const Chain arm = chain(q);
  double energy = 0.0;
  for (std::size_t i = 0; i < links_.size(); ++i) {
    const BodyInertia& body = links_[i].body;
    energy += kGravity * body.mass * (arm.p[i] + arm.R[i] * body.com).z();
  }
  return energy;
}

PointKinematics ArmModel::elbow(const JointVector& q) const noexcept {
  const Chain arm = chain(q);
  constexpr int kElbowJoint = 3;
  PointKinematics elbow;
  elbow.p_world = T_world_base_.translation() + arm.p[kElbowJoint];
  elbow.J.setZero();
  for (int i = 0; i < kElbowJoint; ++i) {
    const std::size_t joint = static_cast<std::size_t>(i);
    elbow.J.col(i) = arm.z[joint].cross(arm.p[kElbowJoint] - arm.p[joint]);
  }
  return elbow;
}

}  // namespace binpick
