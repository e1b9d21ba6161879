#include "control/payload_estimator.h"

#include <Eigen/Cholesky>
#include <algorithm>

namespace binpick {
namespace {

constexpr double kGravity = 9.81;  // m/s^2, along -z of the world
// Weight of "no offset" against the samples: what they say nothing about stays zero.
constexpr double kPrior = 1e-3;

Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

}  // namespace

void PayloadEstimator::add(const Vector6& wrench, const Eigen::Isometry3d& T_world_tcp) noexcept {
  const Eigen::Matrix3d R_tcp_world = T_world_tcp.linear().transpose();
  const Eigen::Vector3d g = -kGravity * R_tcp_world.col(2);
  const Eigen::Vector3d force = R_tcp_world * wrench.head<3>();
  const Eigen::Vector3d torque = R_tcp_world * wrench.tail<3>();
  const Eigen::Matrix3d G = skew(g);
  ++samples_;
  weight_ += g.dot(force);
  moments_ += G.transpose() * G;
  torque_moments_ -= G.transpose() * torque;
}

BodyInertia PayloadEstimator::estimate(double reach) const noexcept {
  BodyInertia payload;
  if (samples_ == 0) return payload;
  const double scale = samples_ * kGravity * kGravity;
  payload.mass = std::max(weight_ / scale, 0.0);
  if (payload.mass <= 0.0) return payload;
  const Eigen::Matrix3d A = moments_ + kPrior * scale * Eigen::Matrix3d::Identity();
  payload.com = A.ldlt().solve(torque_moments_) / payload.mass;
  const double distance = payload.com.norm();
  if (distance > reach) payload.com *= reach / distance;
  return payload;
}

}  // namespace binpick
