#include "recognition/conflict_graph.h"

#include <algorithm>
#include <numeric>
#include <unordered_map>
#include <utility>

namespace binpick {

ConflictGraph::ConflictGraph(std::vector<ExplainedSet> hypotheses, double tolerated_share)
    : hypotheses_(std::move(hypotheses)), neighbours_(hypotheses_.size()) {
  int last_point = -1;
  for (const ExplainedSet& set : hypotheses_) {
    if (!set.points.empty()) last_point = std::max(last_point, set.points.back());
  }
  std::vector<std::vector<int>> explained_by(static_cast<std::size_t>(last_point + 1));
  std::vector<int> shared(hypotheses_.size(), 0);
  std::vector<int> touched;
  for (std::size_t b = 0; b < hypotheses_.size(); ++b) {
    touched.clear();
    for (const int point : hypotheses_[b].points) {
      std::vector<int>& others = explained_by[static_cast<std::size_t>(point)];
      for (const int a : others) {
        if (shared[static_cast<std::size_t>(a)]++ == 0) touched.push_back(a);
      }
      others.push_back(static_cast<int>(b));
    }
    std::sort(touched.begin(), touched.end());
    for (const int a : touched) {
      const auto other = static_cast<std::size_t>(a);
      const std::size_t smaller =
          std::min(hypotheses_[other].points.size(), hypotheses_[b].points.size());
      if (shared[other] > tolerated_share * static_cast<double>(smaller)) {
        neighbours_[other].push_back(static_cast<int>(b));
        neighbours_[b].push_back(a);
      }
      shared[other] = 0;
    }
  }
}

bool ConflictGraph::is_better(int a, int b) const {
  const double quality_a = hypotheses_[static_cast<std::size_t>(a)].quality;
  const double quality_b = hypotheses_[static_cast<std::size_t>(b)].quality;
  return quality_a != quality_b ? quality_a > quality_b : a < b;
}

std::vector<int> ConflictGraph::suppress_non_maxima() const {
  std::vector<int> kept;
  for (int node = 0; node < static_cast<int>(hypotheses_.size()); ++node) {
    const std::vector<int>& others = neighbours(node);
    const bool is_maximum = std::none_of(others.begin(), others.end(),
                                         [&](int other) { return is_better(other, node); });
    if (is_maximum) kept.push_back(node);
  }
  return kept;
}

std::vector<int> ConflictGraph::select_greedily() const {
  std::vector<int> order(hypotheses_.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int a, int b) { return is_better(a, b); });
  std::vector<bool> removed(hypotheses_.size(), false);
  std::vector<int> kept;
  for (const int node : order) {
    if (removed[static_cast<std::size_t>(node)]) continue;
    kept.push_back(node);
    for (const int other : neighbours(node)) removed[static_cast<std::size_t>(other)] = true;
  }
  return kept;
}

std::vector<int> suppress_non_maxima(const std::vector<ExplainedSet>& hypotheses) {
  const auto is_better = [&](std::size_t a, std::size_t b) {
    return hypotheses[a].quality > hypotheses[b].quality;  // of equal ones the first stays
  };
  std::vector<int> best;  // by point, -1 where there is none
  for (std::size_t node = 0; node < hypotheses.size(); ++node) {
    for (const int point : hypotheses[node].points) {
      const auto at = static_cast<std::size_t>(point);
      if (at >= best.size()) best.resize(at + 1, -1);
      if (best[at] < 0 || is_better(node, static_cast<std::size_t>(best[at]))) {
        best[at] = static_cast<int>(node);
      }
    }
  }
  std::vector<int> kept;
  for (int node = 0; node < static_cast<int>(hypotheses.size()); ++node) {
    const std::vector<int>& points = hypotheses[static_cast<std::size_t>(node)].points;
    const bool is_maximum = std::all_of(points.begin(), points.end(), [&](int point) {
      return best[static_cast<std::size_t>(point)] == node;
    });
    if (is_maximum) kept.push_back(node);
  }
  return kept;
}

}  // namespace binpick
