#include "experiments/vision_grasp_trial.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "experiments/trial_setup.h"
#include "models/errors.h"
#include "models/mesh_geometry.h"
#include "sim/pile.h"

namespace binpick {
namespace {

constexpr double kSettleLimit = 5.0;  // of a single object, s

}  // namespace

void VisionGraspTrial::Subject::visit(ConfigVisitor& visitor) {
  visitor.text("model", model, Presence::kRequired);
  visitor.text("single_scene", single_scene, Presence::kRequired);
  visitor.texts("restings", restings);
}

void VisionGraspTrial::visit(ConfigVisitor& visitor) {
  visitor.elements("subjects", subjects_, Presence::kRequired);
  visitor.text("object", object_);
  visitor.choice("scenario", scenario_, {"single", "pile"});
  visitor.text("pile_scene", pile_scene_, Presence::kRequired);
  visitor.integer("attempts", attempts_, 1, 100);
  visitor.number("placing_radius", placing_radius_, {.min = 0.0, .max = 0.3});
  visitor.group("loop", [&](ConfigVisitor& group) { loop_.visit(group); });
  if (!visitor.reading()) return;
  const auto is_object = [&](const Subject& s) { return s.model == object_; };
  if (std::none_of(subjects_.begin(), subjects_.end(), is_object)) {
    visitor.problem("object", fmt::format("'{}' is none of the subjects", object_));
  }
}

const VisionGraspTrial::Subject& VisionGraspTrial::subject() const {
  return *std::find_if(subjects_.begin(), subjects_.end(),
                       [&](const Subject& s) { return s.model == object_; });
}

std::filesystem::path VisionGraspTrial::scene_file() const {
  return config_directory_ / (scenario_ == "pile" ? pile_scene_ : subject().single_scene);
}

std::vector<std::filesystem::path> VisionGraspTrial::input_files(
    const std::filesystem::path& config_directory) const {
  std::vector<std::filesystem::path> files = trial_input_files(config_directory / pile_scene_);
  for (const Subject& s : subjects_) {
    const auto more = trial_input_files(config_directory / s.single_scene);
    files.insert(files.end(), more.begin(), more.end());
  }
  std::sort(files.begin(), files.end());
  files.erase(std::unique(files.begin(), files.end()), files.end());
  return files;
}

void VisionGraspTrial::prepare(const std::filesystem::path& config_directory) {
  config_directory_ = config_directory;
  const std::filesystem::path file = scene_file();
  const std::string key = file.string() + '\n' + loop_.cell_key();
  cell_ = &cells_.try_emplace(key, file, loop_).first->second;
}

void VisionGraspTrial::place_single_object(World& world, Seed seed) const {
  Random draw(seed);
  const Scene& scene = cell_->world->parts.scene;
  const double radius = placing_radius_ * std::sqrt(draw.uniform());
  const double azimuth = draw.uniform(0.0, 2.0 * std::numbers::pi);
  StandingObject standing;
  standing.model = object_;
  standing.resting = subject().restings[draw.index(subject().restings.size())];
  standing.position =
      scene.pick_region_centre + radius * Eigen::Vector2d(std::cos(azimuth), std::sin(azimuth));
  standing.yaw = draw.uniform(0.0, 2.0 * std::numbers::pi);

  Eigen::Isometry3d T_world_object = Eigen::Isometry3d::Identity();
  T_world_object.linear() = standing.R_world_object();
  const double lowest = lowest_point(T_world_object, world.object_model(0).mesh);
  T_world_object.translation() << standing.position, -lowest;
  world.set_object_pose(0, T_world_object);
}

TrialRecord VisionGraspTrial::run(const TrialContext& context) {
  TrialRecord record;
  run_in_simulation(context, record,
                    [&](const TrialContext& observed) { attempt(observed, record); });
  mark_oracle(loop_, record);
  return record;
}

void VisionGraspTrial::attempt(const TrialContext& context, TrialRecord& record) const {
  context.enter(TrialStage::kSetup);
  World world(cell_->world, physics_of_trial(cell_->world->parts.objects, loop_.physics, context),
              loop_.plant.drives());
  if (scenario_ == "pile") {
    if (!drop_pile(world, context.seeds.shared("pile")).settled) {
      return fail(record, TrialOutcome::kTimeout, TrialStage::kSetup,
                  "the pile did not come to rest");
    }
  } else {
    place_single_object(world, context.seeds.shared("placing"));
    settle(world, kSettleLimit);
  }
  AutomatonOptions automaton;
  automaton.wanted_model = object_;
  automaton.max_attempts = static_cast<int>(attempts_);
  automaton.max_placed = 1;
  automaton.max_idle_cycles = automaton.looks_before_empty + automaton.max_attempts - 1;
  VisionLoopResult result;
  run_vision_loop(*cell_, world, loop_, automaton, context, result);
  context.enter(TrialStage::kJudge);
  judge(world, result, record);
}

void VisionGraspTrial::judge(const World& world, const VisionLoopResult& result,
                             TrialRecord& record) const {
  record.measures["attempts"] = static_cast<double>(result.attempts.size());
  record.measures["pushes"] = result.pushes;
  if (result.attempts.empty()) {
    if (result.automaton.reason == HaltReason::kBelievedEmpty) {
      return fail(record, TrialOutcome::kNothingDetected, TrialStage::kRecognize,
                  "no object found");
    }
    return fail(record, TrialOutcome::kUnreachable, TrialStage::kSelect, "no feasible grasp");
  }
  // The last attempt decides: either it put the object away, or the robot was left with it.
  const GraspAttempt& attempt = result.attempts.back();
  const std::string& grasp = attempt.plan.grasp->name;
  record.note = grasp;
  record.measures["tilt_rad"] = attempt.plan.tilt;
  if (attempt.match) record.measures["mssd_m"] = attempt.match->mssd;
  if (!attempt.match || !attempt.match->correct()) {
    fail(record, TrialOutcome::kWrongPose, TrialStage::kRecognize, grasp);
  } else if (!attempt.done()) {
    const AttemptEnd end = end_of(attempt);
    fail(record, end.outcome, end.stage, grasp);
  } else if (!Referee(world).in_designated_place(attempt.match->object)) {
    fail(record, TrialOutcome::kDropped, TrialStage::kPlace, grasp);
  }
}

}  // namespace binpick
