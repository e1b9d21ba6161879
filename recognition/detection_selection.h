#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "recognition/acceptance_model.h"
#include "recognition/hypothesis_evidence.h"
#include "recognition/observed_scene.h"
#include "recognition/recognition_model.h"
#include "recognition/sensor_estimate.h"

namespace binpick {

/// A hypothesis that was compared with the scene.
struct Candidate {
  int model = 0;
  Eigen::Isometry3f T_camera_model = Eigen::Isometry3f::Identity();
  HypothesisEvidence evidence;  ///< as if it were alone
};

/// A candidate of the consistent set, judged beside the others of the set.
struct SelectedCandidate {
  std::size_t candidate = 0;  ///< its index
  HypothesisEvidence evidence;
  FeatureVector features{};
  double log_odds = 0.0;
  double margin = 0.0;      ///< once the set is final: what the best set without it lacks, log odds
  std::vector<int> pixels;  ///< which it explains, working resolution, ascending
};

/// A candidate that may come to be chosen: rendered once, and what judging it has shown, to be
/// looked up when it is judged again beside the same others.
struct JudgedCandidate {
  struct Judgement {
    std::vector<std::size_t> beside;  ///< chosen candidates within reach, ascending
    HypothesisEvidence evidence;
    std::vector<int> pixels;  ///< which it explains
  };
  std::unique_ptr<const RenderedModel> rendered;
  PixelBox reached;                 // once it is rendered
  std::list<Judgement> judgements;  // a list, as others look at them while more are added
};
/// By candidate. It holds as long as they stay where they are; new ones may follow.
using JudgementMemory = std::vector<JudgedCandidate>;

/// By how many pixels the sensor lets nearer surfaces grow: where the steps of depth lie beside the
/// silhouettes of credible candidates, in the (weighted) median. `fallback` without such.
[[nodiscard]] double estimate_dilation(std::span<const Candidate> candidates,
                                       const AcceptanceModel& acceptance, int jobs = 1,
                                       double fallback = 0.5);

/// Whether so much of what agrees with a hypothesis is another's that the rest says little.
[[nodiscard]] bool is_mostly_claimed(const HypothesisEvidence& evidence);

/// Whether two candidates are poses of one object, a tenth of its diameter apart at most (MSSD).
[[nodiscard]] bool is_same_object(std::span<const RecognitionModel> models, const Candidate& a,
                                  const Candidate& b);

/// Picks the candidates that stand beside each other: a pixel is explained by one of them, and the
/// sum of their log odds is as large as greedy choice and single exchanges make it. What a chosen
/// candidate explains is no evidence for another, nor against it: a neighbour that goes on where
/// the model ends, or lies just in front of it, contradicts only as long as it is unexplained.
///
/// The many choices of select_best() are made on up to `jobs` threads. They share what they find
/// out about a candidate beside given others, which is the same whoever finds it out.
class DetectionSelection {
 public:
  DetectionSelection(std::span<const RecognitionModel> models, const ObservedScene& scene,
                     const SensorEstimate& sensor, const AcceptanceModel& acceptance,
                     std::span<const Candidate> candidates, JudgementMemory memory = {},
                     int jobs = 1);

  /// Best first, of what is clearly right, by greedy choice: for the search for more.
  [[nodiscard]] std::vector<SelectedCandidate> select_clear();
  /// Best first, of what is more likely right than wrong, by greedy choice and single exchanges
  /// after it; each with its margin.
  [[nodiscard]] std::vector<SelectedCandidate> select_best();

  /// After a selection: the features on which the decision about each candidate fell, beside those
  /// chosen before it.
  [[nodiscard]] const std::vector<FeatureVector>& decided_features() const {
    return choice_.decided;
  }
  [[nodiscard]] double dilation() const noexcept { return dilation_; }
  /// For the next selection among these candidates and more.
  [[nodiscard]] JudgementMemory release_memory() { return std::move(memory_); }

 private:
  struct Footprint {
    Eigen::Vector2f centre;  // pixels
    float radius = 0.0f;
  };
  /// A consistent set, and on what the decision about each candidate fell.
  struct Choice {
    std::vector<SelectedCandidate> selected;
    std::vector<FeatureVector> decided;
  };
  /// What a choice is made with.
  struct Desk {
    EvidenceGatherer gatherer;
    PixelClaims claims;  // none but while a set is chosen
  };
  /// A choice while it is made.
  class Draft;
  /// Whether the candidate may come to be chosen, beside whatever others.
  [[nodiscard]] bool is_eligible(std::size_t candidate) const;
  void render_eligible();
  [[nodiscard]] std::unique_ptr<Desk> free_desk();
  void leave(std::unique_ptr<Desk> desk);

  /// Takes candidates best first, each judged beside the ones taken before.
  [[nodiscard]] Choice choose();
  /// The same, those of `first` before all others, and none that is the same object as `without`.
  /// For calls side by side; with `looks_ahead` for few of them, as threads are idle then.
  [[nodiscard]] Choice choose_after(const std::vector<std::size_t>& first,
                                    std::optional<std::size_t> without = std::nullopt,
                                    bool looks_ahead = false);
  /// What is remembered of a candidate beside others, or nothing.
  [[nodiscard]] const JudgedCandidate::Judgement* recall(std::size_t candidate,
                                                         const std::vector<std::size_t>& beside);
  /// What the candidate explains beside the chosen ones, who hold `claims`. In whatever order they
  /// were chosen, together they claim the same pixels.
  const JudgedCandidate::Judgement& look_at(std::size_t candidate, EvidenceGatherer& gatherer,
                                            const PixelClaims& claims,
                                            const std::vector<SelectedCandidate>& chosen);
  [[nodiscard]] std::vector<std::size_t> within(const PixelBox& box,
                                                const std::vector<SelectedCandidate>& chosen) const;
  [[nodiscard]] bool overlap(std::size_t a, std::size_t b) const;
  [[nodiscard]] bool is_same_object(std::size_t a, std::size_t b) const {
    return binpick::is_same_object(models_, candidates_[a], candidates_[b]);
  }
  void exchange(Choice& choice);
  void find_margins(std::vector<SelectedCandidate>& selected);

  std::span<const RecognitionModel> models_;
  const ObservedScene& scene_;
  const SensorEstimate& sensor_;
  const AcceptanceModel& acceptance_;
  std::span<const Candidate> candidates_;
  double dilation_;
  double least_log_odds_;  // of whoever is chosen
  int jobs_;
  std::mutex mutex_;        // of the memory and the desks
  JudgementMemory memory_;  // grows while choices are made
  std::vector<std::unique_ptr<Desk>> free_desks_;
  std::vector<Footprint> footprints_;
  std::vector<FeatureVector> alone_features_;  // of each candidate as if there were no other
  std::vector<double> alone_;                  // their log odds
  Choice choice_;
};

}  // namespace binpick
