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

/// A candidate's features take less than a microsecond.
template <class Work>
void for_each(std::span<const Candidate> candidates, int jobs, const Work& work) {
  constexpr int kChunk = 64;
  parallel_chunks(static_cast<int>(candidates.size()), kChunk, jobs, [&](int, int begin, int end) {
    for (int i = begin; i < end; ++i) work(static_cast<std::size_t>(i));
  });
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
                         int jobs, double fallback) {
  struct Vote {
    double offset = 0.0;
    int weight = 0;
  };
  std::vector<Vote> votes(candidates.size());
  for_each(candidates, jobs, [&](std::size_t i) {
    const HypothesisEvidence& evidence = candidates[i].evidence;
    if (evidence.edges_matched == 0) return;
    const auto own = static_cast<double>(evidence.edge_offset);
    if (acceptance.log_odds(acceptance_features(evidence, own)) < 0.0) return;
    votes[i] = {own, evidence.edges_matched};
  });
  std::erase_if(votes, [](const Vote& vote) { return vote.weight == 0; });
  const int total = std::accumulate(votes.begin(), votes.end(), 0,
                                    [](int sum, const Vote& vote) { return sum + vote.weight; });
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
      dilation_(estimate_dilation(candidates, acceptance, jobs)),
      least_log_odds_(
          std::log(acceptance.least_probability / (1.0 - acceptance.least_probability))),
      jobs_(jobs),
      memory_(std::move(memory)) {
  memory_.resize(candidates.size());
  footprints_.resize(candidates.size());
  alone_features_.resize(candidates.size());
  alone_.resize(candidates.size());
  for_each(candidates, jobs, [&](std::size_t i) {
    const RecognitionModel& model = models_[static_cast<std::size_t>(candidates[i].model)];
    const Eigen::Vector3f centre = candidates[i].T_camera_model * model.centre;
    const Projection& projection = scene.projection();
    const float z = std::max(centre.z(), 1e-3f);
    footprints_[i] = {{projection.fx * centre.x() / z, projection.fy * centre.y() / z},
                      0.5f * model.diameter * projection.fx / z};
    alone_features_[i] = acceptance_features(candidates[i].evidence, dilation_);
    alone_[i] = acceptance.log_odds(alone_features_[i]);
  });
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

const JudgedCandidate::Judgement* DetectionSelection::recall(
    std::size_t candidate, const std::vector<std::size_t>& beside) {
  const std::lock_guard lock(mutex_);
  for (const JudgedCandidate::Judgement& before : memory_[candidate].judgements) {
    if (before.beside == beside) return &before;
  }
  return nullptr;
}

const JudgedCandidate::Judgement& DetectionSelection::look_at(
    std::size_t candidate, EvidenceGatherer& gatherer, const PixelClaims& claims,
    const std::vector<SelectedCandidate>& chosen) {
  JudgedCandidate& known = memory_[candidate];
  JudgedCandidate::Judgement judgement;
  judgement.beside = within(known.reached, chosen);
  if (const auto* before = recall(candidate, judgement.beside)) return *before;
  const Candidate& pose = candidates_[candidate];
  const RecognitionModel& model = models_[static_cast<std::size_t>(pose.model)];
  const auto claimant = static_cast<std::int32_t>(candidate);
  judgement.evidence =
      gatherer.gather_again(model, pose.T_camera_model, *known.rendered, &claims, claimant);
  gatherer.explained_pixels(judgement.pixels);
  const std::lock_guard lock(mutex_);
  return known.judgements.emplace_back(std::move(judgement));
}

class DetectionSelection::Draft {
 public:
  /// With `looks_ahead` idle threads judge what will probably be asked for next.
  Draft(DetectionSelection& selection, bool looks_ahead)
      : s_(selection),
        looks_ahead_(looks_ahead && selection.jobs_ > 1),
        desk_(selection.free_desk()),
        log_odds_(selection.alone_),
        is_stale_(selection.candidates_.size(), 0),
        is_open_(selection.candidates_.size(), 1),
        choice_{{}, selection.alone_features_} {}

  void leave_out(std::size_t object) {
    for (std::size_t i = 0; i < is_open_.size(); ++i) {
      if (s_.is_same_object(i, object)) is_open_[i] = 0;
    }
  }

  void take_if_likely(std::size_t i) {
    SelectedCandidate judged = judge(i);
    if (judged.log_odds >= s_.least_log_odds_) take(std::move(judged));
    is_open_[i] = 0;
  }

  void take_best_first() {
    for (;;) {
      const std::size_t best = highest_ranking();
      if (best == is_open_.size()) break;
      if (looks_ahead_) judge_ahead(best);
      const bool was_stale = is_stale_[best] != 0;
      SelectedCandidate judged = judge(best);
      log_odds_[best] = judged.log_odds;
      is_stale_[best] = 0;
      // Claims only grow: what is mostly another's stays so.
      if (is_mostly_claimed(judged.evidence)) {
        is_open_[best] = 0;
      } else if (!was_stale && judged.log_odds >= s_.least_log_odds_) {
        take(std::move(judged));
      }
    }
  }

  Choice finish() {
    for (const SelectedCandidate& taken : choice_.selected) {
      for (const int pixel : taken.pixels) desk_->claims[static_cast<std::size_t>(pixel)] = -1;
    }
    s_.leave(std::move(desk_));
    return std::move(choice_);
  }

 private:
  [[nodiscard]] double rank(std::size_t i) const {
    return log_odds_[i] + (is_stale_[i] != 0 ? kWithinReach : 0.0);
  }
  [[nodiscard]] bool is_in_question(std::size_t i) const {
    return is_open_[i] != 0 && rank(i) >= s_.least_log_odds_;
  }

  [[nodiscard]] std::size_t highest_ranking() const {
    std::size_t best = is_open_.size();
    for (std::size_t i = 0; i < is_open_.size(); ++i) {
      if (!is_in_question(i)) continue;
      if (best == is_open_.size() || rank(i) > rank(best)) best = i;
    }
    return best;
  }

  SelectedCandidate judge(std::size_t i) {
    const JudgedCandidate::Judgement& judgement =
        s_.look_at(i, desk_->gatherer, desk_->claims, choice_.selected);
    SelectedCandidate judged;
    judged.candidate = i;
    judged.evidence = judgement.evidence;
    judged.features = acceptance_features(judged.evidence, s_.dilation_);
    judged.log_odds = s_.acceptance_.log_odds(judged.features);
    if (judged.log_odds >= s_.least_log_odds_) judged.pixels = judgement.pixels;
    choice_.decided[i] = judged.features;
    return judged;
  }

  void take(SelectedCandidate judged) {
    const std::size_t i = judged.candidate;
    for (const int pixel : judged.pixels) {
      std::int32_t& owner = desk_->claims[static_cast<std::size_t>(pixel)];
      if (owner < 0) owner = static_cast<std::int32_t>(i);
    }
    is_open_[i] = 0;
    for (std::size_t other = 0; other < is_open_.size(); ++other) {
      if (is_open_[other] != 0 && s_.is_eligible(other) && s_.overlap(i, other)) {
        is_stale_[other] = 1;
        log_odds_[other] = std::max(log_odds_[other], s_.alone_[other]);
      }
    }
    choice_.selected.push_back(std::move(judged));
  }

  [[nodiscard]] bool is_known(std::size_t i) const {
    return s_.recall(i, s_.within(s_.memory_[i].reached, choice_.selected)) != nullptr;
  }

  /// Judges `best`, whose turn it is, and beside it as many as there are threads: what comes next
  /// unless the set changes before. A candidate that is not stale is about to be taken: then
  /// it changes for those who overlap it.
  void judge_ahead(std::size_t best) {
    if (is_known(best)) return;
    std::vector<std::size_t> next = {best};
    for (std::size_t i = 0; i < is_open_.size(); ++i) {
      const bool would_change = i == best || (is_stale_[best] == 0 && s_.overlap(best, i));
      if (is_in_question(i) && !would_change && !is_known(i)) next.push_back(i);
    }
    const std::size_t size = std::min(next.size(), static_cast<std::size_t>(s_.jobs_));
    std::partial_sort(next.begin() + 1, next.begin() + static_cast<std::ptrdiff_t>(size),
                      next.end(), [&](std::size_t a, std::size_t b) { return rank(a) > rank(b); });
    next.resize(size);
    parallel_for(static_cast<int>(next.size()), s_.jobs_, [&](int i) {
      const std::size_t candidate = next[static_cast<std::size_t>(i)];
      if (i == 0) {
        s_.look_at(candidate, desk_->gatherer, desk_->claims, choice_.selected);
        return;
      }
      std::unique_ptr<Desk> helper = s_.free_desk();
      s_.look_at(candidate, helper->gatherer, desk_->claims, choice_.selected);
      s_.leave(std::move(helper));
    });
  }

  DetectionSelection& s_;
  const bool looks_ahead_;
  std::unique_ptr<Desk> desk_;
  std::vector<double> log_odds_;
  std::vector<char> is_stale_;  // others were taken since
  std::vector<char> is_open_;
  Choice choice_;
};

DetectionSelection::Choice DetectionSelection::choose() {
  Draft draft(*this, /*looks_ahead=*/true);
  draft.take_best_first();
  return draft.finish();
}

DetectionSelection::Choice DetectionSelection::choose_after(const std::vector<std::size_t>& first,
                                                            std::optional<std::size_t> without,
                                                            bool looks_ahead) {
  Draft draft(*this, looks_ahead);
  if (without) draft.leave_out(*without);
  for (const std::size_t i : first) draft.take_if_likely(i);
  draft.take_best_first();
  return draft.finish();
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
  const bool has_idle_threads = losers.size() < static_cast<std::size_t>(jobs_);
  parallel_for(static_cast<int>(losers.size()), jobs_, [&](int i) {
    const auto index = static_cast<std::size_t>(i);
    others[index] = choose_after({losers[index]}, {}, has_idle_threads);
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
    gains[index] = sum_of_gains(choose_after(others, member).selected);
  });
  const double all = sum_of_gains(selected);
  for (std::size_t i = 0; i < size; ++i) {
    selected[i].margin = all - std::max(gains[i], gains[size + i]);
  }
  least_log_odds_ = least;
}

std::vector<SelectedCandidate> DetectionSelection::select_clear() {
  render_eligible();
  choice_ = choose();
  return best_first(std::move(choice_.selected));
}

std::vector<SelectedCandidate> DetectionSelection::select_best() {
  least_log_odds_ = std::min(least_log_odds_, kEvenOdds);
  render_eligible();
  choice_ = choose();
  exchange(choice_);
  find_margins(choice_.selected);
  return best_first(std::move(choice_.selected));
}

}  // namespace binpick
