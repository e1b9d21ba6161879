#pragma once

#include <map>
#include <string>
#include <vector>

#include "experiments/trial_kind.h"
#include "experiments/vision_loop.h"

namespace binpick {

/// Table 2 (IJRR 2012, sections 6.3.1 and 6.3.2): recognize an object, grasp it and carry it to its
/// place, in one attempt unless the parameters grant more; the object stands alone or belongs to a
/// pile. Protocol: docs/table2.md.
class VisionGraspTrial final : public TrialKind {
 public:
  void visit(ConfigVisitor& visitor) override;
  void prepare(const std::filesystem::path& config_directory) override;
  [[nodiscard]] std::vector<std::filesystem::path> input_files(
      const std::filesystem::path& config_directory) const override;
  [[nodiscard]] TrialRecord run(const TrialContext& context) override;

 private:
  /// A kind of object that trials are made with.
  struct Subject {
    std::string model;
    std::string single_scene;                      ///< one object of this model
    std::vector<std::string> restings{"upright"};  ///< how it may stand, see StandingObject

    void visit(ConfigVisitor& visitor);
  };

  [[nodiscard]] const Subject& subject() const;
  [[nodiscard]] std::filesystem::path scene_file() const;
  /// Random position, azimuth and resting side of the single object.
  void place_single_object(World& world, Seed seed) const;
  void attempt(const TrialContext& context, TrialRecord& record) const;
  void judge(const World& world, const VisionLoopResult& result, TrialRecord& record) const;

  std::vector<Subject> subjects_;
  std::string object_ = "bottle";
  std::string scenario_ = "single";
  std::string pile_scene_;
  std::int64_t attempts_ = 1;
  double placing_radius_ = 0.12;  ///< of the single object round the pick region's centre, m
  VisionLoopParameters loop_;

  std::filesystem::path config_directory_;
  std::map<std::string, VisionCell> cells_;  ///< by scene file and recognizer setting
  const VisionCell* cell_ = nullptr;
};

}  // namespace binpick
