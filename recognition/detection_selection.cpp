#include "recognition/detection_selection.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "recognition/parallel_for.h"
#include "recognition/pose_metrics.h"

namespace binpick {
namespace {

constexpr double kMostClaimed = 0.35;     // of the agreeing pixels may be another object's
constexpr double kWithinReach = 4.0;      // log odds that neighbours' claims may add
constexpr double kWorthExchanging = 1.0;  // log odds that an exchange must gain
constexpr std::size_t kMostExchanges = 8;
constexpr double kSameObject = 0.1;  // of the diameter
constexpr double kEvenOdds = 0.0;

double sum_of_log_odds(const std::vector<SelectedCandidate>& selected) {
  return std::accumulate(selected.begin(), selected.end(), 0.0,
                         [](double sum, const auto& s) { return sum + s.log_odds; });
}

double sum_of_gains(const std::vector<SelectedCandidate>& selected) {
  return std::accumulate(selected.begin(), selected.end(), 0.0, [](double sum, const auto& s) {
    return sum + std::max(s.log_odds, kEvenOdds);
  });
}

std::vector<SelectedCandidate> best_first(std::vector<SelectedCandidate> selected) {
  std::stable_sort(selected.begin(), selected.end(),
                   [](const auto& a, const auto& b) { return a.log_odds > b.log_odds; });
  return selected;
}

}  // namespace

bool is_mostly_claimed(const HypothesisEvidence& evidence) {
  return evidence.claimed > kMostClaimed * (evidence.matched + evidence.claimed);
}

bool is_same_object(std::span<const RecognitionModel> models, const Candidate& a,
                    const Candidate& b) {
  if (a.model != b.model) return false;
  const RecognitionModel& model = models[static_cast<std::size_t>(a.model)];
  return mssd(a.T_camera_model.cast<double>(), b.T_camera_model.cast<double>(), model.hull,
              model.symmetries) < kSameObject * static_cast<double>(model.diameter);
}

double estimate_dilation(std::span<const Candidate> candidates, const AcceptanceModel& acceptance,
                         double fallback) {
  struct Vote {
    double offset;
    int weight;
  };
  std::vector<Vote> votes;
  int total = 0;
  for (const Candidate& candidate : candidates) {
    if (candidate.evidence.edges_matched == 0) continue;
    const auto own = static_cast<double>(candidate.evidence.edge_offset);
    if (acceptance.log_odds(acceptance_features(candidate.evidence, own)) < 0.0) continue;
    votes.push_back({own, candidate.evidence.edges_matched});
    total += candidate.evidence.edges_matched;
  }
  std::stable_sort(votes.begin(), votes.end(),
                   [](const Vote& a, const Vote& b) { return a.offset < b.offset; });
  int before = 0;
  for (const Vote& vote : votes) {
    before += vote.weight;
    if (2 * before >= total) return vote.offset;
  }
  return fallback;
}

DetectionSelection::DetectionSelection(std::span<const RecognitionModel> models,
                                       const ObservedScene& scene, const SensorEstimate& sensor,
                                       const AcceptanceModel& acceptance,
                                       std::span<const Candidate> candidates,
                                       JudgementMemory memory, int jobs)
    : models_(models),
      scene_(scene),
      sensor_(sensor),
      acceptance_(acceptance),
      candidates_(candidates),
      dilation_(estimate_dilation(candidates, acceptance)),
      least_log_odds_(
          std::log(acceptance.least_probability / (1.0 - acceptance.least_probability))),
      jobs_(jobs),
      memory_(std::move(memory)) {
  memory_.resize(candidates.size());
  for (const Candidate& candidate : candidates) {
    const RecognitionModel& model = models_[static_cast<std::size_t>(candidate.model)];
    const Eigen::Vector3f centre = candidate.T_camera_model * model.centre;
    const Projection& projection = scene.projection();
    const float z = std::max(centre.z(), 1e-3f);
    footprints_.push_back({{projection.fx * centre.x() / z, projection.fy * centre.y() / z},
                           0.5f * model.diameter * projection.fx / z});
    alone_features_.push_back(acceptance_features(candidate.evidence, dilation_));
    alone_.push_back(acceptance.log_odds(alone_features_.back()));
  }
}

bool DetectionSelection::overlap(std::size_t a, std::size_t b) const {
  const float reach = footprints_[a].radius + footprints_[b].radius;
  return (footprints_[a].centre - footprints_[b].centre).squaredNorm() < reach * reach;
}

std::vector<std::size_t> DetectionSelection::within(
    const PixelBox& box, const std::vector<SelectedCandidate>& chosen) const {
  std::vector<std::size_t> near;
  for (const SelectedCandidate& other : chosen) {
    if (memory_[other.candidate].reached.overlaps(box)) near.push_back(other.candidate);
  }
  std::sort(near.begin(), near.end());
  return near;
}

std::unique_ptr<DetectionSelection::Desk> DetectionSelection::free_desk() {
  {
    const std::lock_guard lock(mutex_);
    if (!free_desks_.empty()) {
      std::unique_ptr<Desk> desk = std::move(free_desks_.back());
      free_desks_.pop_back();
      return desk;
    }
  }
  return std::make_unique<Desk>(
      Desk{EvidenceGatherer(scene_, sensor_), PixelClaims(scene_.pixels().size(), -1)});
}

void DetectionSelection::leave(std::unique_ptr<Desk> desk) {
  const std::lock_guard lock(mutex_);
  free_desks_.push_back(std::move(desk));
}

/// What is hopeless alone stays so; what is nearly good enough may gain.
bool DetectionSelection::is_eligible(std::size_t candidate) const {
  return alone_[candidate] > least_log_odds_ - kWithinReach;
}

/// Ahead of a choice, which judges one after the other.
void DetectionSelection::render_eligible() {
  std::vector<std::size_t> fresh;
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    if (is_eligible(i) && !memory_[i].rendered) fresh.push_back(i);
  }
  parallel_chunks(static_cast<int>(fresh.size()), 2, jobs_, [&](int, int begin, int end) {
    EvidenceGatherer gatherer(scene_, sensor_);
    for (int i = begin; i < end; ++i) {
      const std::size_t index = fresh[static_cast<std::size_t>(i)];
      const Candidate& pose = candidates_[index];
      JudgedCandidate& known = memory_[index];
      known.rendered = std::make_unique<RenderedModel>(
          gatherer.render(models_[static_cast<std::size_t>(pose.model)], pose.T_camera_model));
      known.reached = gatherer.reached();
    }
  });
}

/// What the candidate explains beside the chosen ones. In whatever order they were chosen, together
/// they claim the same pixels.
const JudgedCandidate::Judgement& DetectionSelection::look_at(
    std::size_t candidate, Desk& desk, const std::vector<SelectedCandidate>& chosen) {
  JudgedCandidate& known = memory_[candidate];
  JudgedCandidate::Judgement judgement;
  judgement.beside = within(known.reached, chosen);
  {
    const std::lock_guard lock(mutex_);
    for (const JudgedCandidate::Judgement& before : known.judgements) {
      if (before.beside == judgement.beside) return before;
    }
  }
  const Candidate& pose = candidates_[candidate];
  const RecognitionModel& model = models_[static_cast<std::size_t>(pose.model)];
  const auto claimant = static_cast<std::int32_t>(candidate);
  judgement.evidence = desk.gatherer.gather_again(model, pose.T_camera_model, *known.rendered,
                                                  &desk.claims, claimant);
  desk.gatherer.explained_pixels(judgement.pixels);
  const std::lock_guard lock(mutex_);
  return known.judgements.emplace_back(std::move(judgement));
}

SelectedCandidate DetectionSelection::judge(std::size_t candidate, Desk& desk,
                                            const std::vector<SelectedCandidate>& chosen) {
  const JudgedCandidate::Judgement& judgement = look_at(candidate, desk, chosen);
  SelectedCandidate judged;
  judged.candidate = candidate;
  judged.evidence = judgement.evidence;
  judged.features = acceptance_features(judged.evidence, dilation_);
  judged.log_odds = acceptance_.log_odds(judged.features);
  if (judged.log_odds >= least_log_odds_) judged.pixels = judgement.pixels;
  return judged;
}

/// Takes candidates best first, those of `first` before all others, each judged beside the ones
/// taken before; none that is the same object as `without`.
DetectionSelection::Choice DetectionSelection::choose(const std::vector<std::size_t>& first,
                                                      std::optional<std::size_t> without) {
  std::unique_ptr<Desk> desk = free_desk();
  PixelClaims& claims = desk->claims;
  std::vector<double> log_odds = alone_;
  std::vector<char> is_stale(candidates_.size(), 0);
  std::vector<char> is_open(candidates_.size(), 1);
  Choice choice{{}, alone_features_};
  for (std::size_t i = 0; without && i < candidates_.size(); ++i) {
    if (is_same_object(i, *without)) is_open[i] = 0;
  }
  const auto take = [&](SelectedCandidate judged) {
    const std::size_t i = judged.candidate;
    for (const int pixel : judged.pixels) {
      std::int32_t& owner = claims[static_cast<std::size_t>(pixel)];
      if (owner < 0) owner = static_cast<std::int32_t>(i);
    }
    is_open[i] = 0;
    for (std::size_t other = 0; other < candidates_.size(); ++other) {
      if (is_open[other] != 0 && is_eligible(other) && overlap(i, other)) {
        is_stale[other] = 1;
        log_odds[other] = std::max(log_odds[other], alone_[other]);
      }
    }
    choice.selected.push_back(std::move(judged));
  };
  const auto judge_now = [&](std::size_t i) {
    SelectedCandidate judged = judge(i, *desk, choice.selected);
    choice.decided[i] = judged.features;
    return judged;
  };
  for (const std::size_t i : first) {
    SelectedCandidate judged = judge_now(i);
    if (judged.log_odds >= least_log_odds_) take(std::move(judged));
    is_open[i] = 0;
  }
  for (;;) {
    std::size_t best = candidates_.size();
    const auto rank = [&](std::size_t i) {
      return log_odds[i] + (is_stale[i] != 0 ? kWithinReach : 0.0);
    };
    for (std::size_t i = 0; i < candidates_.size(); ++i) {
      if (is_open[i] == 0 || !(rank(i) >= least_log_odds_)) continue;
      if (best == candidates_.size() || rank(i) > rank(best)) best = i;
    }
    if (best == candidates_.size()) break;
    const bool was_stale = is_stale[best] != 0;
    SelectedCandidate judged = judge_now(best);
    log_odds[best] = judged.log_odds;
    is_stale[best] = 0;
    // Claims only grow: what is mostly another's stays so.
    if (is_mostly_claimed(judged.evidence)) {
      is_open[best] = 0;
    } else if (!was_stale && judged.log_odds >= least_log_odds_) {
      take(std::move(judged));
    }
  }
  for (const SelectedCandidate& taken : choice.selected) {
    for (const int pixel : taken.pixels) claims[static_cast<std::size_t>(pixel)] = -1;
  }
  leave(std::move(desk));
  return choice;
}

/// Forces candidates that lost to others to the front; keeps what gains.
void DetectionSelection::exchange(Choice& choice) {
  std::vector<std::size_t> losers;
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    if (alone_[i] < least_log_odds_) continue;
    const bool is_selected = std::any_of(
        choice.selected.begin(), choice.selected.end(),
        [&](const auto& s) { return s.candidate == i || is_same_object(s.candidate, i); });
    const bool is_new = std::none_of(losers.begin(), losers.end(),
                                     [&](std::size_t other) { return is_same_object(i, other); });
    if (!is_selected && is_new) losers.push_back(i);
  }
  std::stable_sort(losers.begin(), losers.end(),
                   [&](std::size_t a, std::size_t b) { return alone_[a] > alone_[b]; });
  losers.resize(std::min(losers.size(), kMostExchanges));
  std::vector<Choice> others(losers.size());
  parallel_for(static_cast<int>(losers.size()), jobs_, [&](int i) {
    const auto index = static_cast<std::size_t>(i);
    others[index] = choose({losers[index]});
  });
  for (Choice& other : others) {
    if (sum_of_log_odds(other.selected) > sum_of_log_odds(choice.selected) + kWorthExchanging) {
      choice = std::move(other);
    }
  }
}

/// How much each of the set would be missed: the others take its place as far as they can, or the
/// choice begins anew without it. What is less likely right than wrong takes nobody's place.
void DetectionSelection::find_margins(std::vector<SelectedCandidate>& selected) {
  const double least = std::exchange(least_log_odds_, kEvenOdds);
  // First without each member anew, then what is kept of the others: so those that are at work at
  // the same time have least in common.
  const std::size_t size = selected.size();
  std::vector<double> gains(2 * size);
  parallel_for(static_cast<int>(gains.size()), jobs_, [&](int i) {
    const auto index = static_cast<std::size_t>(i);
    const std::size_t member = selected[index % size].candidate;
    std::vector<std::size_t> others;
    if (index >= size) {
      for (const SelectedCandidate& other : selected) {
        if (other.candidate != member) others.push_back(other.candidate);
      }
    }
    gains[index] = sum_of_gains(choose(others, member).selected);
  });
  const double all = sum_of_gains(selected);
  for (std::size_t i = 0; i < size; ++i) {
    selected[i].margin = all - std::max(gains[i], gains[size + i]);
  }
  least_log_odds_ = least;
}

std::vector<SelectedCandidate> DetectionSelection::select_clear() {
  render_eligible();
  choice_ = choose({});
  return best_first(std::move(choice_.selected));
}

std::vector<SelectedCandidate> DetectionSelection::select_best() {
  least_log_odds_ = std::min(least_log_odds_, kEvenOdds);
  render_eligible();
  choice_ = choose({});
  exchange(choice_);
  find_margins(choice_.selected);
  return best_first(std::move(choice_.selected));
}

}  // namespace binpick
