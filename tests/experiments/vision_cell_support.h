#pragma once

#include <memory>
#include <string>
#include <vector>

#include "control/manipulation_automaton.h"
#include "experiments/recognizer_perception.h"
#include "experiments/robot_knowledge.h"
#include "sim/depth_camera.h"
#include "sim/simulated_robot.h"

namespace binpick::testing {

inline StandingObject standing(const std::string& model, double x, double y) {
  StandingObject object;
  object.model = model;
  object.position << x, y;
  return object;
}

/// The cell with these objects on its table.
inline Scene scene_with(std::vector<StandingObject> objects) {
  Scene scene = load_scene(BINPICK_SOURCE_DIR "/scenes/single_bottle.yaml");
  scene.standing = std::move(objects);
  return scene;
}

/// A world with a robot in it whose library may lack objects that the world has.
struct VisionBench {
  std::shared_ptr<const WorldTemplate> shared;
  World world;
  DepthCamera camera;
  RobotKnowledge knowledge;
  std::shared_ptr<const Recognizer> recognizer;

  VisionBench(const Scene& scene, const std::vector<std::string>& library)
      : shared(make_world_template(scene)),
        world(shared, centre_physics(shared->parts.objects)),
        camera(shared),
        knowledge(cell_layout(scene), load(library)),
        recognizer(make_recognizer(knowledge.objects(), {})) {}

  static std::vector<ObjectModel> load(const std::vector<std::string>& names) {
    std::vector<ObjectModel> objects;
    for (const std::string& name : names) objects.push_back(load_known_object(name));
    return objects;
  }
};

/// Hands everything on and lets something happen right after each image was taken.
class MischievousRobot final : public Robot {
 public:
  MischievousRobot(Robot& robot, std::function<void()> after_capture)
      : robot_(robot), after_capture_(std::move(after_capture)) {}

  RobotState state() const override { return robot_.state(); }
  RobotState exchange(const RobotCommand& command) override { return robot_.exchange(command); }
  RangeImage capture() override {
    RangeImage image = robot_.capture();
    if (after_capture_) after_capture_();
    return image;
  }

 private:
  Robot& robot_;
  std::function<void()> after_capture_;
};

}  // namespace binpick::testing
