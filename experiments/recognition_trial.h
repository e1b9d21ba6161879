#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "experiments/recognition_conditions.h"
#include "experiments/recognition_judgement.h"
#include "experiments/recognition_scenes.h"
#include "experiments/recognition_sensor.h"
#include "experiments/trial_kind.h"
#include "recognition/recognizer.h"

namespace binpick {

/// What the report draws from the records of recognition trials.
enum class RecognitionFigure { kRecall, kThreshold, kNoise, kOcclusion, kPoints, kCores };

/// One scan of a pile, searched once and compared with the truth: the recognition experiments of
/// IJRR 2012, section 6.1 (Figs. 10, 12, 13), and the demand on piles. Protocol:
/// docs/recognition.md.
///
/// A trial succeeds if it finds its target, or, without one, every object of visible share 0.30 or
/// more and nothing false. Measures: `visible` and `visible_found` (objects of visible share 0.30
/// and more), `hidden` and `hidden_found` (0.15 to 0.30), `false_positives`, `pairs`,
/// `scene_points`; per object found `position_m.<i>`, `rotation_rad.<i>`; with a target
/// `target_occlusion`; with the sensor gaussian `rms_share.<i>` and `position_share.<i>`, over the
/// diagonal of the objects' box. Timed trials add `wall_s` and `cpu_s`: their records measure the
/// machine, so two runs of them are alike but not identical.
class RecognitionTrial final : public TrialKind {
 public:
  void visit(ConfigVisitor& visitor) override;
  void prepare(const std::filesystem::path& config_directory) override;
  [[nodiscard]] std::vector<std::filesystem::path> input_files(
      const std::filesystem::path& config_directory) const override;
  [[nodiscard]] TrialRecord run(const TrialContext& context) override;

  [[nodiscard]] RecognitionFigure figure() const;

 private:
  /// Conditions under a name, for axes that change more than one of them.
  struct Variant {
    std::string name;
    RecognitionConditions conditions;
  };

  /// What is searched: the recognizer's models and the truth about them.
  struct Searched {
    std::shared_ptr<const ModelLibrary> library;
    std::shared_ptr<const RecognitionJudge> judge;
  };
  /// A pile and what the sensor measured of it. Cells that differ in the recognizer alone look at
  /// the same data: the last ones are kept. The result does not depend on that.
  struct Observation {
    RecognitionConditions conditions;
    Seed pile = 0;
    Seed sensor = 0;
    CleanView view;
    SegmentationImage owners;
    std::vector<std::vector<std::size_t>> pixels;  ///< by object
    double diagonal = 0.0;                         ///< of the objects' box, m
    Scan scan;
  };

  [[nodiscard]] const RecognitionConditions& conditions() const;
  [[nodiscard]] const Searched& searched();
  [[nodiscard]] const Observation& observe(Seed pile, Seed sensor);
  [[nodiscard]] RecognitionResult recognize(const Scan& scan, Seed seed) const;

  std::string scene_;
  std::string figure_ = "recall";
  std::string setting_ = "default";
  bool timed_ = false;
  RecognitionConditions base_;
  std::vector<Variant> variants_;
  std::string variant_;

  std::map<std::filesystem::path, std::unique_ptr<RecognitionScenes>> scenes_;
  std::map<std::string, Searched> searched_;
  RecognitionScenes* scenes_in_use_ = nullptr;
  std::shared_ptr<const Recognizer> recognizer_;
  std::shared_ptr<const RecognitionJudge> judge_;
  std::optional<Observation> last_;
};

}  // namespace binpick
