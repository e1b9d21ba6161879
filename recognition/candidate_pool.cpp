#include "recognition/candidate_pool.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "recognition/parallel_for.h"
#include "recognition/pose_refinement.h"
#include "recognition/pose_uncertainty.h"
#include "recognition/projective_alignment.h"

namespace binpick {
namespace {

constexpr double kHopelessLogOdds = -5.0;  // no sliding helps
constexpr double kRunnerUp = -3.0;         // least log odds of a candidate that may gain by sliding
constexpr std::size_t kMostRunnersUp = 12;
// Log odds. Refinement trades silhouettes for surfaces, for one to three where a sensor dilates
// silhouettes; where it runs away for want of information it costs five and more.
constexpr double kClearlyLess = 4.0;
constexpr double kMayBeElsewhere = 0.03;  // least displacement of such a pose, diameters
constexpr double kWorthMoving = 0.5;      // log odds
// Probability below which no pose is worth refining. Less than what is reported: a hidden object's
// refined pose can be all but certain where its unrefined one is doubtful.
constexpr double kWorthRefining = 0.2;
constexpr double kCertain = 0.0;  // displacement of poses whose uncertainty is not yet known

}  // namespace

CandidatePool::CandidatePool(const ModelLibrary& library, const ObservedScene& scene,
                             const AcceptanceModel& acceptance, double facing_visibility, int jobs)
    : library_(library),
      scene_(scene),
      acceptance_(acceptance),
      facing_visibility_(facing_visibility),
      jobs_(jobs),
      dilation_(estimate_dilation({}, acceptance)) {}

bool CandidatePool::add(std::vector<Hypothesis> hypotheses, int most_per_model, bool slide) {
  const std::vector<Hypothesis> fresh =
      cluster_and_align(std::move(hypotheses), library_.models(), scene_,
                        {most_per_model, facing_visibility_, jobs_}, tried_);
  tried_.insert(tried_.end(), fresh.begin(), fresh.end());
  verify(fresh, slide);
  return !fresh.empty();
}

const RecognitionModel& CandidatePool::model_of(const Candidate& candidate) const {
  return library_.models()[static_cast<std::size_t>(candidate.model)];
}

double CandidatePool::log_odds(const HypothesisEvidence& evidence) const {
  return acceptance_.log_odds(acceptance_features(evidence, dilation_));
}

bool CandidatePool::is_doubtful(const SelectedCandidate& selected, double displacement) const {
  return detection_probability(selected, displacement) < acceptance_.least_probability;
}

bool CandidatePool::is_hopeless(const SelectedCandidate& selected) const {
  return detection_probability(selected, kCertain) <
         std::min(kWorthRefining, acceptance_.least_probability);
}

void CandidatePool::verify(const std::vector<Hypothesis>& hypotheses, bool slide) {
  const std::size_t first = candidates_.size();
  candidates_.resize(first + hypotheses.size());
  parallel_for(static_cast<int>(hypotheses.size()), jobs_, [&](int i) {
    const Hypothesis& hypothesis = hypotheses[static_cast<std::size_t>(i)];
    Candidate& candidate = candidates_[first + static_cast<std::size_t>(i)];
    candidate.model = hypothesis.model;
    candidate.T_camera_model = hypothesis.T_camera_model;
    candidate.evidence = EvidenceGatherer(scene_, scene_.sensor())
                             .gather(model_of(candidate), candidate.T_camera_model);
    if (slide && log_odds(candidate.evidence) > kHopelessLogOdds) slide_to_silhouette(candidate);
  });
}

void CandidatePool::slide_to_silhouette(Candidate& candidate, const PixelClaims* claims,
                                        std::int32_t claimant) const {
  constexpr std::array<float, 4> kSteps = {0.04f, 0.02f, 0.01f, 0.005f};  // of the diameter
  const RecognitionModel& model = model_of(candidate);
  const OpenDirections open = open_directions(scene_, model, candidate.T_camera_model,
                                              1.5f * tolerances_for(model, scene_.noise()).fine);
  std::array<EvidenceGatherer, 2> gatherers = {EvidenceGatherer(scene_, scene_.sensor()),
                                               EvidenceGatherer(scene_, scene_.sensor())};
  double best = log_odds(candidate.evidence);
  for (const float step : kSteps) {
    for (int i = 0; i < open.count; ++i) {
      // Both ways at once: the last to slide have a second thread for it.
      std::array<Candidate, 2> moved = {candidate, candidate};
      parallel_for(2, jobs_, [&](int way) {
        const auto index = static_cast<std::size_t>(way);
        const float distance = (way == 0 ? -step : step) * model.diameter;
        Eigen::Isometry3f& T = moved[index].T_camera_model;
        T = move_along(model, T, open.motions.col(i), distance);
        moved[index].evidence = gatherers[index].gather(model, T, claims, claimant);
      });
      for (const Candidate& place : moved) {
        if (log_odds(place.evidence) <= best) continue;
        best = log_odds(place.evidence);
        candidate = place;
      }
    }
  }
}

const std::vector<SelectedCandidate>& CandidatePool::select(bool is_last) {
  DetectionSelection selection(library_.models(), scene_, scene_.sensor(), acceptance_, candidates_,
                               std::move(judgements_), jobs_);
  selected_ = is_last ? selection.select_best() : selection.select_clear();
  if (is_last) {
    std::erase_if(selected_, [&](const SelectedCandidate& s) { return is_hopeless(s); });
  }
  decided_ = selection.decided_features();
  dilation_ = selection.dilation();
  judgements_ = selection.release_memory();
  return selected_;
}

std::vector<std::size_t> CandidatePool::runners_up() const {
  std::vector<double> decided;
  std::vector<std::size_t> best_first;
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    decided.push_back(acceptance_.log_odds(decided_[i]));
    if (decided[i] > kRunnerUp) best_first.push_back(i);
  }
  std::stable_sort(best_first.begin(), best_first.end(),
                   [&](std::size_t a, std::size_t b) { return decided[a] > decided[b]; });
  std::vector<std::size_t> represented;
  for (const SelectedCandidate& selected : selected_) represented.push_back(selected.candidate);
  std::vector<std::size_t> result;
  for (const std::size_t i : best_first) {
    if (result.size() == kMostRunnersUp) break;
    if (std::any_of(represented.begin(), represented.end(), [&](std::size_t other) {
          return is_same_object(library_.models(), candidates_[i], candidates_[other]);
        })) {
      continue;
    }
    represented.push_back(i);
    result.push_back(i);
  }
  return result;
}

Candidate CandidatePool::beside_claims(EvidenceGatherer& gatherer, std::size_t index,
                                       const PixelClaims& claims) const {
  Candidate candidate = candidates_[index];
  candidate.evidence = gatherer.gather(model_of(candidate), candidate.T_camera_model, &claims,
                                       static_cast<std::int32_t>(index));
  return candidate;
}

void CandidatePool::slide_runners_up() {
  const std::vector<std::size_t> chosen = runners_up();
  const PixelClaims claims = claims_of_selected();
  std::vector<int> costs;
  for (const std::size_t index : chosen) {
    costs.push_back(evidence_cost(model_of(candidates_[index]), candidates_[index].evidence));
  }
  std::vector<std::optional<Candidate>> moved(chosen.size());
  parallel_for_longest_first(costs, jobs_, [&](int i) {
    EvidenceGatherer gatherer(scene_, scene_.sensor());
    const std::size_t index = chosen[static_cast<std::size_t>(i)];
    Candidate candidate = beside_claims(gatherer, index, claims);
    if (is_mostly_claimed(candidate.evidence)) return;
    slide_to_silhouette(candidate, &claims, static_cast<std::int32_t>(index));
    if (candidate.T_camera_model.isApprox(candidates_[index].T_camera_model)) return;
    candidate.evidence = gatherer.gather(model_of(candidate), candidate.T_camera_model);
    moved[static_cast<std::size_t>(i)] = candidate;
  });
  for (const std::optional<Candidate>& candidate : moved) {
    if (candidate) candidates_.push_back(*candidate);
  }
}

int CandidatePool::accepted() const {
  return static_cast<int>(
      std::count_if(candidates_.begin(), candidates_.end(), [&](const Candidate& candidate) {
        return probability(log_odds(candidate.evidence)) >= acceptance_.least_probability;
      }));
}

PixelClaims CandidatePool::claims_of_selected() const {
  PixelClaims claims(scene_.pixels().size(), -1);
  for (const SelectedCandidate& selected : selected_) {
    for (const int pixel : selected.pixels) {
      std::int32_t& owner = claims[static_cast<std::size_t>(pixel)];
      if (owner < 0) owner = static_cast<std::int32_t>(selected.candidate);
    }
  }
  return claims;
}

std::vector<int> CandidatePool::costs_of_selected() const {
  std::vector<int> costs;
  for (const SelectedCandidate& selected : selected_) {
    costs.push_back(evidence_cost(model_of(candidates_[selected.candidate]), selected.evidence));
  }
  return costs;
}

void CandidatePool::slide_selected() {
  struct Stand {
    HypothesisEvidence evidence;
    std::vector<int> pixels;
  };
  PixelClaims claims = claims_of_selected();
  const auto stand_at = [&](const SelectedCandidate& selected, const Eigen::Isometry3f& T) {
    EvidenceGatherer gatherer(scene_, scene_.sensor());
    Stand stand;
    stand.evidence = gatherer.gather(model_of(candidates_[selected.candidate]), T, &claims,
                                     static_cast<std::int32_t>(selected.candidate));
    gatherer.explained_pixels(stand.pixels);
    return stand;
  };
  std::vector<Candidate> moved(selected_.size());
  parallel_for_longest_first(costs_of_selected(), jobs_, [&](int i) {
    EvidenceGatherer gatherer(scene_, scene_.sensor());
    const std::size_t index = selected_[static_cast<std::size_t>(i)].candidate;
    Candidate& candidate = moved[static_cast<std::size_t>(i)];
    candidate = beside_claims(gatherer, index, claims);
    slide_to_silhouette(candidate, &claims, static_cast<std::int32_t>(index));
  });
  // One after the other, as two may have moved towards each other.
  std::vector<SelectedCandidate> standing;
  for (std::size_t i = 0; i < selected_.size(); ++i) {
    SelectedCandidate& selected = selected_[i];
    Candidate& candidate = candidates_[selected.candidate];
    const std::array<Eigen::Isometry3f, 2> poses = {candidate.T_camera_model,
                                                    moved[i].T_camera_model};
    std::array<Stand, 2> stands;
    const int count = poses[1].isApprox(poses[0]) ? 1 : 2;
    parallel_for(count, jobs_, [&](int pose) {
      const auto index = static_cast<std::size_t>(pose);
      stands[index] = stand_at(selected, poses[index]);
    });
    const bool moves = count == 2 && log_odds(stands[1].evidence) > log_odds(stands[0].evidence);
    Stand& stand = stands[moves ? 1 : 0];
    candidate.T_camera_model = poses[moves ? 1 : 0];
    selected.evidence = stand.evidence;
    selected.log_odds = log_odds(stand.evidence);
    const auto claimant = static_cast<std::int32_t>(selected.candidate);
    for (const int pixel : selected.pixels) {
      std::int32_t& owner = claims[static_cast<std::size_t>(pixel)];
      if (owner == claimant) owner = -1;
    }
    if (is_hopeless(selected) || is_mostly_claimed(selected.evidence)) continue;
    selected.pixels = std::move(stand.pixels);
    for (const int pixel : selected.pixels) claims[static_cast<std::size_t>(pixel)] = claimant;
    standing.push_back(std::move(selected));
  }
  std::stable_sort(standing.begin(), standing.end(),
                   [](const auto& a, const auto& b) { return a.log_odds > b.log_odds; });
  selected_ = std::move(standing);
}

void CandidatePool::judge_refined(std::vector<RefinedPose>& refined) {
  const PixelClaims claims = claims_of_selected();
  parallel_for_longest_first(costs_of_selected(), jobs_, [&](int i) {
    EvidenceGatherer gatherer(scene_, scene_.sensor());
    SelectedCandidate& selected = selected_[static_cast<std::size_t>(i)];
    const Candidate& candidate = candidates_[selected.candidate];
    Eigen::Isometry3d& T_camera_model = refined[static_cast<std::size_t>(i)].T_camera_model;
    const HypothesisEvidence evidence =
        gatherer.gather(model_of(candidate), T_camera_model.cast<float>(), &claims,
                        static_cast<std::int32_t>(selected.candidate));
    const double refined_log_odds = log_odds(evidence);
    if (refined_log_odds < selected.log_odds - kClearlyLess) {
      T_camera_model = candidate.T_camera_model.cast<double>();
    } else {
      selected.evidence = evidence;
      selected.log_odds = refined_log_odds;
    }
  });
}

std::vector<int> CandidatePool::move_elsewhere(const std::vector<RefinedPose>& refined) {
  std::vector<Candidate> places;
  std::vector<std::size_t> whose;
  for (std::size_t i = 0; i < selected_.size(); ++i) {
    for (Candidate& place : places_beside(selected_[i], refined[i])) {
      places.push_back(std::move(place));
      whose.push_back(i);
    }
  }
  const PixelClaims claims = claims_of_selected();
  parallel_for(static_cast<int>(places.size()), jobs_, [&](int i) {
    const auto index = static_cast<std::size_t>(i);
    Candidate& place = places[index];
    const RecognitionModel& model = model_of(place);
    place.T_camera_model =
        align_projectively(scene_, model, place.T_camera_model,
                           fine_alignment(tolerances_for(model, scene_.noise()).fine));
    place.evidence = EvidenceGatherer(scene_, scene_.sensor())
                         .gather(model, place.T_camera_model, &claims,
                                 static_cast<std::int32_t>(selected_[whose[index]].candidate));
  });
  std::vector<int> moved;
  for (std::size_t i = 0; i < places.size(); ++i) {
    SelectedCandidate& selected = selected_[whose[i]];
    const bool has_moved = !moved.empty() && moved.back() == static_cast<int>(whose[i]);
    const double log_odds_there = log_odds(places[i].evidence);
    if (log_odds_there <= selected.log_odds + (has_moved ? 0.0 : kWorthMoving)) continue;
    candidates_[selected.candidate].T_camera_model = places[i].T_camera_model;
    selected.evidence = places[i].evidence;
    selected.log_odds = log_odds_there;
    if (!has_moved) moved.push_back(static_cast<int>(whose[i]));
  }
  return moved;
}

std::vector<Candidate> CandidatePool::places_beside(const SelectedCandidate& selected,
                                                    const RefinedPose& refined) const {
  constexpr std::array<double, 8> kDistances = {-0.2, -0.15, -0.1, -0.05, 0.05, 0.1, 0.15, 0.2};
  Candidate candidate = candidates_[selected.candidate];
  const RecognitionModel& model = model_of(candidate);
  const auto diameter = static_cast<double>(model.diameter);
  const UncertainMotion motion =
      most_uncertain_motion(model, refined.T_camera_model, refined.covariance);
  if (motion.displacement < kMayBeElsewhere * diameter) return {};
  std::vector<Candidate> places;
  for (const double distance : kDistances) {
    candidate.T_camera_model =
        motion.move(refined.T_camera_model, distance * diameter).cast<float>();
    places.push_back(candidate);
  }
  return places;
}

std::vector<int> leaves_of(const ObservedScene& scene, const std::vector<int>& pixels) {
  std::vector<int> leaves;
  for (const int pixel : pixels) {
    const int leaf = scene.leaf_of_pixel(pixel);
    // Neighbouring pixels mostly share a leaf.
    if (leaf >= 0 && (leaves.empty() || leaves.back() != leaf)) leaves.push_back(leaf);
  }
  std::sort(leaves.begin(), leaves.end());
  leaves.erase(std::unique(leaves.begin(), leaves.end()), leaves.end());
  return leaves;
}

}  // namespace binpick
