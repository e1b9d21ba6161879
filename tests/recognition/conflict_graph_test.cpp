#include "recognition/conflict_graph.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "models/random.h"

namespace binpick {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

/// A chain a - b - c, a apart from c, and d alone; qualities are the explained counts.
std::vector<ExplainedSet> chain() {
  return {{{1, 2, 3, 4, 5}, 5.0}, {{5, 6, 7, 8}, 4.0}, {{8, 9, 10}, 3.0}, {{20}, 1.0}};
}

TEST(ConflictGraph, JoinsHypothesesThatShareAPoint) {
  const ConflictGraph graph(chain());
  EXPECT_THAT(graph.neighbours(0), ElementsAre(1));
  EXPECT_THAT(graph.neighbours(1), ElementsAre(0, 2));
  EXPECT_THAT(graph.neighbours(2), ElementsAre(1));
  EXPECT_THAT(graph.neighbours(3), IsEmpty());
}

TEST(ConflictGraph, SuppressesEveryNodeWithABetterNeighbour) {
  // c goes although b, which is better than c, goes too: suppression as on an image.
  EXPECT_THAT(ConflictGraph(chain()).suppress_non_maxima(), ElementsAre(0, 3));
}

TEST(ConflictGraph, GreedySelectionKeepsWhatOnlyLosersSuppress) {
  EXPECT_THAT(ConflictGraph(chain()).select_greedily(), ElementsAre(0, 2, 3));
}

TEST(ConflictGraph, OfEqualHypothesesTheFirstWins) {
  const std::vector<ExplainedSet> twins = {{{1, 2}, 2.0}, {{1, 2}, 2.0}};
  EXPECT_THAT(ConflictGraph(twins).suppress_non_maxima(), ElementsAre(0));
  EXPECT_THAT(ConflictGraph(twins).select_greedily(), ElementsAre(0));
}

TEST(ConflictGraph, TouchingNeighboursMayShareAFewPoints) {
  // One of the four points of b is shared with a: 25 %.
  EXPECT_THAT(ConflictGraph(chain(), 0.3).neighbours(0), IsEmpty());
  EXPECT_THAT(ConflictGraph(chain(), 0.2).neighbours(0), ElementsAre(1));
}

TEST(ConflictGraph, SuppressionNeedsNoEdges) {
  Random random(2);
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<ExplainedSet> sets(20);
    for (ExplainedSet& set : sets) {
      for (int point = 0; point < 60; ++point) {
        if (random.uniform() < 0.04) set.points.push_back(point);
      }
      set.quality = static_cast<double>(set.points.size());
    }
    EXPECT_EQ(suppress_non_maxima(sets), ConflictGraph(sets).suppress_non_maxima());
  }
  EXPECT_THAT(suppress_non_maxima(chain()), ElementsAre(0, 3));
}

TEST(ConflictGraph, EmptyGraphHasNoNodes) {
  EXPECT_THAT(ConflictGraph({}).suppress_non_maxima(), IsEmpty());
  EXPECT_THAT(ConflictGraph({{{}, 0.0}}).select_greedily(), ElementsAre(0));
}

}  // namespace
}  // namespace binpick
