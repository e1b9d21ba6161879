#include "recognition/pair_table.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "models/random.h"
#include "recognition/shapes.h"

namespace binpick {
namespace {

using testing::make_box;
using testing::make_prism;

std::vector<RecognitionModel> two_models() {
  return {make_recognition_model("box", make_box({0.15, 0.1, 0.06}), {}),
          make_recognition_model("prism", make_prism(6, 0.05, 0.14), {})};
}

PairTableOptions all_pairs() {
  PairTableOptions options;
  options.width = 0.06f;
  options.tolerance = 0.003f;
  return options;
}

/// All pairs of `model` of the table's width.
template <class Visit>
void for_each_pair(const RecognitionModel& model, const PairTableOptions& options,
                   const Visit& visit) {
  for (const OrientedPoint& u : model.surface) {
    for (const OrientedPoint& v : model.surface) {
      const float distance = (u.p - v.p).norm();
      if (std::abs(distance - options.width) <= options.tolerance) visit(u, v);
    }
  }
}

TEST(PairTable, ReturnsEveryModelPairFromItsCell) {
  const std::vector<RecognitionModel> models = two_models();
  const PairTable table(models, all_pairs());
  std::size_t pairs = 0;
  for (std::size_t m = 0; m < models.size(); ++m) {
    for_each_pair(models[m], all_pairs(), [&](const OrientedPoint& u, const OrientedPoint& v) {
      const auto frame = pair_frame(u, v);
      if (!frame) return;
      ++pairs;
      const PairFrame inverse = frame->inverse().matrix().topRows<3>();
      const auto list = table.pairs(PairTable::cell(pair_descriptor(u, v)), m);
      EXPECT_TRUE(std::any_of(list.begin(), list.end(),
                              [&](const PairFrame& stored) { return stored == inverse; }));
    });
  }
  EXPECT_EQ(table.size(), pairs);
  EXPECT_GT(pairs, 1000u);
  EXPECT_DOUBLE_EQ(table.kept_fraction(), 1.0);
}

TEST(PairTable, MovedPairAlignsItsModel) {
  const std::vector<RecognitionModel> models = two_models();
  const PairTable table(models, all_pairs());
  Random random(3);
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = random.rotation().toRotationMatrix();
  pose.translation() << 0.1, -0.2, 0.9;
  const Eigen::Isometry3f T = pose.cast<float>();
  int hits = 0;
  int tried = 0;
  for_each_pair(models[1], all_pairs(), [&](const OrientedPoint& u, const OrientedPoint& v) {
    const OrientedPoint w{T * u.p, T.linear() * u.n};
    const OrientedPoint x{T * v.p, T.linear() * v.n};
    const auto F_wx = pair_frame(w, x);
    if (!F_wx) return;
    ++tried;
    for (const PairFrame& stored : table.pairs(PairTable::cell(pair_descriptor(w, x)), 1)) {
      Eigen::Isometry3f F_uv_inverse = Eigen::Isometry3f::Identity();
      F_uv_inverse.matrix().topRows<3>() = stored;
      if ((*F_wx * F_uv_inverse).isApprox(T, 1e-3f)) {
        ++hits;
        break;
      }
    }
  });
  // Angles within rounding of a cell's edge may fall into the neighbour.
  EXPECT_GT(hits, 0.9 * tried);
}

TEST(PairTable, RemovesCrowdedCellsUntilTheFractionIsKept) {
  const std::vector<RecognitionModel> models = two_models();
  const PairTable all(models, all_pairs());
  PairTableOptions options = all_pairs();
  options.kept_fraction = 0.4;
  const PairTable some(models, options);
  EXPECT_LE(some.kept_fraction(), 0.4);
  // Cells go whole: the last one that went may take more than was needed.
  EXPECT_GT(some.kept_fraction(), 0.3);
  std::size_t largest_kept = 0;
  std::size_t smallest_removed = all.size();
  for (std::uint32_t cell = 0; cell < PairTable::kCells; ++cell) {
    const std::size_t before = all.pairs(cell, 0).size() + all.pairs(cell, 1).size();
    const std::size_t after = some.pairs(cell, 0).size() + some.pairs(cell, 1).size();
    EXPECT_TRUE(after == before || after == 0);
    if (before == 0) continue;
    if (after > 0) largest_kept = std::max(largest_kept, after);
    if (after == 0) smallest_removed = std::min(smallest_removed, before);
  }
  EXPECT_LE(largest_kept, smallest_removed);
}

TEST(PairTable, SymmetryIsStoredOnce) {
  Eigen::Isometry3d half_turn = Eigen::Isometry3d::Identity();
  half_turn.linear() =
      Eigen::AngleAxisd(3.14159265358979, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const TriangleMesh mesh = make_prism(6, 0.05, 0.14);
  PairTableOptions options = all_pairs();
  const PairTable full({make_recognition_model("prism", mesh, {half_turn})}, options);
  options.reduce_symmetry = true;
  const PairTable reduced({make_recognition_model("prism", mesh, {half_turn})}, options);
  EXPECT_NEAR(static_cast<double>(reduced.size()) / static_cast<double>(full.size()), 0.5, 0.08);
}

TEST(PairTable, CoplanarPairsCanBeLeftOut) {
  const std::vector<RecognitionModel> models = two_models();
  PairTableOptions options = all_pairs();
  options.drop_coplanar = true;
  const PairTable table(models, options);
  const PairDescriptor flat{0.0f, 1.5707f, 1.5707f};
  EXPECT_TRUE(table.pairs(PairTable::cell(flat), 0).empty());
  EXPECT_GT(table.size(), 100u);
  EXPECT_LT(table.kept_fraction(), 0.9);
}

}  // namespace
}  // namespace binpick
