#include "experiments/trial_replay.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <utility>

#include "experiments/base64.h"
#include "experiments/replay_scene.h"
#include "experiments/write_file.h"

namespace binpick {
namespace {

using nlohmann::json;

constexpr std::size_t kMostFrames = 6000;
constexpr double kPositionStep = 1e-4;  // m
constexpr double kForceStep = 0.05;     // N
constexpr double kRotationStep = 1.0 / 32767.0;
constexpr double kEndOfCell = 3.2;    // m from the origin: beyond it things are parked
constexpr int kPoseTolerance = 4;     // steps: 0.4 mm, 0.01 degrees
constexpr int kContactTolerance = 8;  // steps: 0.8 mm, 0.4 N
constexpr double kTouch = 0.05;       // contact forces below are taken for numerical noise, N
constexpr int kSurface = -1;          // in place of a body: World's compliant surface
constexpr std::size_t kPoseWidth = 7;
constexpr std::size_t kContactWidth = 6;

/// A contact's point and the force on the second body, world axes.
struct ContactForce {
  Eigen::Vector3d point;
  Eigen::Vector3d force;
};

ContactForce force_of(const World& world, int contact) {
  const mjContact& touch = world.data().contact[contact];
  std::array<mjtNum, 6> wrench{};
  mj_contactForce(&world.model(), &world.data(), contact, wrench.data());
  // The rows of the contact frame are its axes; the force is what geom1 does to geom2.
  const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> axes(touch.frame);
  return {Eigen::Map<const Eigen::Vector3d>(touch.pos),
          axes.transpose() * Eigen::Map<const Eigen::Vector3d>(wrench.data())};
}

std::string thing_name(const mjModel& model, int body) {
  if (body == kSurface) return "surface";
  return body == 0 ? "cell" : mj_id2name(&model, mjOBJ_BODY, body);
}

json to_json(const ReplayTrack& track) {
  return {{"frames", base64_of(track.frames)}, {"values", base64_of(track.values)}};
}

}  // namespace

TrialReplay::TrialReplay(const World& world)
    : bodies_(moving_bodies(world.model())), start_(world.time()) {}

void TrialReplay::step(const World& world) {
  peak_force_ = std::max(peak_force_, world.contact_force_on_robot().norm());
  if (steps_++ % steps_per_frame_ != 0) return;
  add_frame(world);
  if (frames_.size() > kMostFrames) drop_every_other_frame();
}

void TrialReplay::add_frame(const World& world) {
  Frame frame{poses_of(world), {}, std::exchange(peak_force_, 0.0)};
  const mjModel& model = world.model();
  for (int i = 0; i < world.data().ncon; ++i) {
    const mjContact& touch = world.data().contact[i];
    if (touch.efc_address < 0) continue;
    const ContactForce contact = force_of(world, i);
    const double size = contact.force.norm();
    if (size < kTouch) continue;
    Contact& sum = frame.contacts[{model.geom_bodyid[touch.geom1], model.geom_bodyid[touch.geom2]}];
    sum.force_sum += contact.force;
    sum.weighted_point += size * contact.point;
    sum.weight += size;
  }
  if (world.surface_force() > kTouch) {
    const int tcp = world.shared().index.tcp_site;
    const Eigen::Map<const Eigen::Vector3d> p_world(world.data().site_xpos + 3 * tcp);
    frame.contacts[{kSurface, model.site_bodyid[tcp]}] = {
        {0.0, 0.0, world.surface_force()}, world.surface_force() * p_world, world.surface_force()};
  }
  frames_.push_back(std::move(frame));
}

// Poses are those of the last step's beginning, a millisecond old: the world brings them up to date
// on request only, and looking must not touch it.
std::vector<float> TrialReplay::poses_of(const World& world) const {
  std::vector<float> poses;
  poses.reserve(kPoseWidth * bodies_.size());
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const mjtNum* p = world.data().xpos + 3 * bodies_[i];
    const mjtNum* q = world.data().xquat + 4 * bodies_[i];
    const bool here = std::max({std::abs(p[0]), std::abs(p[1]), std::abs(p[2])}) < kEndOfCell;
    for (int axis = 0; axis < 3; ++axis) {
      poses.push_back(here ? static_cast<float>(p[axis] / kPositionStep) : 0.0f);
    }
    // Of a rotation's two quaternions the one nearer to the last frame's, lest it seems to turn.
    double alike = 1.0;
    if (here && !frames_.empty()) {
      const float* last = frames_.back().poses.data() + kPoseWidth * i + 3;
      alike = last[0] * q[1] + last[1] * q[2] + last[2] * q[3] + last[3] * q[0];
    }
    for (const int part : {1, 2, 3, 0}) {
      const double value = std::copysign(1.0, alike) * q[part] / kRotationStep;
      poses.push_back(here ? static_cast<float>(value) : 0.0f);
    }
  }
  return poses;
}

void TrialReplay::drop_every_other_frame() {
  std::vector<Frame> kept;
  for (std::size_t i = 0; i < frames_.size(); i += 2) {
    kept.push_back(std::move(frames_[i]));
    const double before = i == 0 ? 0.0 : frames_[i - 1].peak_force;
    kept.back().peak_force = std::max(kept.back().peak_force, before);
  }
  // The step that asked for this was the newest frame's; it stays when their number is odd.
  frames_ = std::move(kept);
  steps_per_frame_ *= 2;
}

void TrialReplay::note(const World& world, std::string text) {
  notes_.emplace_back(world.time(), std::move(text));
}

json TrialReplay::pose_tracks() const {
  json tracks = json::array();
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    RecordedSignal signal{kPoseWidth, {}};
    for (const Frame& frame : frames_) {
      const auto first = frame.poses.begin() + std::ptrdiff_t(kPoseWidth * i);
      signal.values.insert(signal.values.end(), first, first + kPoseWidth);
    }
    tracks.push_back(to_json(keys_of(signal, kPoseTolerance)));
  }
  return tracks;
}

json TrialReplay::contact_tracks(const mjModel& model) const {
  std::map<Pair, RecordedSignal> signals;
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    for (const auto& [pair, contact] : frames_[i].contacts) {
      RecordedSignal& signal = signals[pair];
      signal.values.resize(kContactWidth * frames_.size());
      const Eigen::Vector3d point = contact.weighted_point / contact.weight / kPositionStep;
      const Eigen::Vector3d force = contact.force_sum / kForceStep;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        signal.values[kContactWidth * i + axis] = static_cast<float>(point[Eigen::Index(axis)]);
        signal.values[kContactWidth * i + 3 + axis] = static_cast<float>(force[Eigen::Index(axis)]);
      }
    }
  }
  json tracks = json::array();
  for (auto& [pair, signal] : signals) {
    signal.width = kContactWidth;
    json track = to_json(keys_of(signal, kContactTolerance));
    track["first"] = thing_name(model, pair.first);
    track["second"] = thing_name(model, pair.second);
    tracks.push_back(std::move(track));
  }
  return tracks;
}

void TrialReplay::write(const World& world, const std::filesystem::path& file) const {
  std::vector<std::uint16_t> peaks;
  for (const Frame& frame : frames_) {
    const double steps = std::min(frame.peak_force / kForceStep, 65535.0);
    peaks.push_back(static_cast<std::uint16_t>(std::lround(steps)));
  }
  const json replay{{"format", 1},
                    {"scene", replay_scene(world)},
                    {"start_s", start_},
                    {"interval_s", World::kStep * static_cast<double>(steps_per_frame_)},
                    {"frames", frames_.size()},
                    {"position_step_m", kPositionStep},
                    {"force_step_n", kForceStep},
                    {"bodies", pose_tracks()},
                    {"contacts", contact_tracks(world.model())},
                    {"peak_force", base64_of(peaks)},
                    {"notes", notes_}};
  write_file(file, replay.dump());
}

}  // namespace binpick
