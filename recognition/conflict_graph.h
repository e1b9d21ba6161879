#pragma once

#include <vector>

namespace binpick {

/// A hypothesis as the conflict graph sees it.
struct ExplainedSet {
  std::vector<int> points;  ///< the points of S* that it explains, ascending, each once
  double quality = 0.0;     ///< better is larger; the paper counts the explained points
};

/// Nodes are hypotheses; an edge joins two whose explained sets intersect. IJRR 2012, section 4.2,
/// step 7.
class ConflictGraph {
 public:
  /// Two sets conflict if they share at least one point and more than `tolerated_share` of the
  /// smaller set. The paper tolerates none; neighbours in a pile do share the leaves in which they
  /// touch. O(total number of explained points + conflicts).
  explicit ConflictGraph(std::vector<ExplainedSet> hypotheses, double tolerated_share = 0.0);

  [[nodiscard]] const std::vector<int>& neighbours(int node) const {
    return neighbours_[static_cast<std::size_t>(node)];
  }

  /// Non-maximum suppression as in image processing: a node goes if any neighbour is better, even
  /// one that goes itself. Equal ones: the first wins. Returns the nodes that stay, ascending.
  [[nodiscard]] std::vector<int> suppress_non_maxima() const;

  /// Takes nodes best first, each removing its neighbours: a node goes only for one that stays.
  /// Returns the nodes that stay, best first.
  [[nodiscard]] std::vector<int> select_greedily() const;

 private:
  [[nodiscard]] bool is_better(int a, int b) const;

  std::vector<ExplainedSet> hypotheses_;
  std::vector<std::vector<int>> neighbours_;
};

/// ConflictGraph(hypotheses).suppress_non_maxima() without its edges, of which there can be as many
/// as pairs of hypotheses: a node stays if it is the best one at each of its points. O(total number
/// of explained points).
[[nodiscard]] std::vector<int> suppress_non_maxima(const std::vector<ExplainedSet>& hypotheses);

}  // namespace binpick
