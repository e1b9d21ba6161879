#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "recognition/acceptance_model.h"
#include "recognition/detection_selection.h"
#include "recognition/hypothesis.h"
#include "recognition/hypothesis_clusters.h"
#include "recognition/joint_refinement.h"
#include "recognition/model_library.h"
#include "recognition/observed_scene.h"
#include "recognition/sensor_estimate.h"

namespace binpick {

/// From many hypotheses to few detections, for the default setting: clusters what was generated,
/// aligns the best of each cluster, compares it with the scene by rendering, and picks a consistent
/// set.
class CandidatePool {
 public:
  /// `facing_visibility` is the least share of a candidate's points facing the sensor that must be
  /// seen.
  CandidatePool(const ModelLibrary& library, const ObservedScene& scene,
                const AcceptanceModel& acceptance, double facing_visibility, int jobs);

  /// Takes the hypotheses of one sampling round; at most `most_per_model` clusters are looked at.
  /// `slide` also searches along the directions that a flat face leaves open: for hypotheses from
  /// coplanar pairs. Says whether there are new candidates.
  bool add(std::vector<Hypothesis> hypotheses, int most_per_model, bool slide);

  /// Picks the consistent set among all candidates so far, best first: what is clearly right
  /// between rounds, in the end what is right for all that can be said about it.
  const std::vector<SelectedCandidate>& select(bool is_last = false);

  /// Adds to the candidates the best of those that nothing selected stands for, moved as
  /// slide_selected() does: a pose that is right but for a shift that its points leave open fails
  /// at the silhouette.
  /// To be called after a selection among all candidates.
  void slide_runners_up();

  /// Moves the selected candidates along directions that their points leave open to where the
  /// silhouette fits best, each beside what the others explain. Whoever does not stand beside the
  /// others any more is dropped.
  void slide_selected();

  /// From now on the selected candidates are judged in their refined poses, beside the others as
  /// these were. A pose that makes its candidate clearly less credible is taken back.
  void judge_refined(std::vector<RefinedPose>& refined);

  /// Looks beside the refined poses of selected candidates along their most uncertain motions,
  /// where a pose may have settled in one of several places that fit, and moves those to where they
  /// are more credible: to be refined again. Says which of selected() have moved.
  std::vector<int> move_elsewhere(const std::vector<RefinedPose>& refined);

  [[nodiscard]] const std::vector<SelectedCandidate>& selected() const noexcept {
    return selected_;
  }
  [[nodiscard]] const std::vector<Candidate>& candidates() const noexcept { return candidates_; }
  /// Of each candidate: the features on which the last selection decided.
  [[nodiscard]] const std::vector<FeatureVector>& decided_features() const noexcept {
    return decided_;
  }
  /// That a selected candidate is right, if its most uncertain displacement is that many diameters.
  [[nodiscard]] double detection_probability(const SelectedCandidate& selected,
                                             double displacement) const {
    return acceptance_.detection_probability(selected.log_odds, selected.margin, displacement);
  }
  /// Whether that is too little to be reported.
  [[nodiscard]] bool is_doubtful(const SelectedCandidate& selected, double displacement) const;
  /// How many candidates would stand alone.
  [[nodiscard]] int accepted() const;
  /// Of silhouettes, pixels of the working resolution, as the last selection estimated it.
  [[nodiscard]] double dilation() const noexcept { return dilation_; }

 private:
  void verify(const std::vector<Hypothesis>& hypotheses, bool slide);
  [[nodiscard]] double log_odds(const HypothesisEvidence& evidence) const;
  /// Whether a selected candidate is not even worth refining.
  [[nodiscard]] bool is_hopeless(const SelectedCandidate& selected) const;
  void slide_to_silhouette(Candidate& candidate, const PixelClaims* claims = nullptr,
                           std::int32_t claimant = -1) const;
  /// Places beside the refined pose of a selected candidate, along its most uncertain motion if
  /// that leaves it any.
  [[nodiscard]] std::vector<Candidate> places_beside(const SelectedCandidate& selected,
                                                     const RefinedPose& refined) const;
  /// The most credible of the candidates that nothing selected stands for, one of each object.
  [[nodiscard]] std::vector<std::size_t> runners_up() const;
  [[nodiscard]] PixelClaims claims_of_selected() const;
  /// How much work it is to gather evidence for each.
  [[nodiscard]] std::vector<int> costs_of_selected() const;
  /// The candidate with the evidence that others' claims leave it.
  [[nodiscard]] Candidate beside_claims(EvidenceGatherer& gatherer, std::size_t index,
                                        const PixelClaims& claims) const;
  [[nodiscard]] const RecognitionModel& model_of(const Candidate& candidate) const;

  const ModelLibrary& library_;
  const ObservedScene& scene_;
  const AcceptanceModel& acceptance_;
  double facing_visibility_;
  int jobs_;
  double dilation_ = 0.0;
  std::vector<Hypothesis> tried_;  // aligned poses that were compared before
  std::vector<Candidate> candidates_;
  JudgementMemory judgements_;
  std::vector<SelectedCandidate> selected_;
  std::vector<FeatureVector> decided_;
};

/// The leaves of S* in which pixels of the working resolution lie, ascending, each once.
[[nodiscard]] std::vector<int> leaves_of(const ObservedScene& scene,
                                         const std::vector<int>& pixels);

}  // namespace binpick
