#include "recognition/pixel_verdicts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "models/random.h"
#include "recognition/coverage_mask.h"

namespace binpick {
namespace {

constexpr std::size_t kWidest = 150;

/// Rows of a rendered model over a scene that agrees with it, or does not, in every way.
class Rows {
 public:
  explicit Rows(Seed seed) : random_(seed) {
    for (int i = 0; i < 5; ++i) {
      Eigen::Vector3f n = random_.unit_vector().cast<float>();
      if (n.z() > 0.0f) n = -n;
      mesh_.normals.push_back(n);
      mesh_.roughness.push_back(i == 0 ? 1.0f : 0.0f);
    }
    rules_.mesh = &mesh_;
    rules_.R_camera_model = Eigen::AngleAxisf(0.2f, Eigen::Vector3f::UnitX()).toRotationMatrix();
    rules_.roughest = 0.5f;
    rules_.tolerance = 0.002f;
    rules_.sensor = {0.0003f, 0.0015f, 0.3f, 1.0f};
    rules_.pixel_width = 0.002f;
    rules_.claimant = 3;
  }

  /// Judges a row of `size` pixels by both paths.
  void judge(std::size_t size, bool with_claims) {
    std::vector<float> depth(size), ray_x(size);
    std::vector<std::int32_t> triangle(size), claims(size);
    std::vector<ScenePixel> scene(size);
    std::int32_t current = -1;
    for (std::size_t i = 0; i < size; ++i) {
      if (random_.uniform() < 0.15) current = static_cast<std::int32_t>(random_.index(6)) - 1;
      triangle[i] = current;
      depth[i] = current < 0 ? 0.0f : 0.9f;
      ray_x[i] = rules_.pixel_width * static_cast<float>(i);
      claims[i] = static_cast<std::int32_t>(random_.index(6)) - 1;
      scene[i] = scene_pixel(depth[i], current);
    }
    const PixelRow row = {size,
                          depth.data(),
                          triangle.data(),
                          scene.data(),
                          with_claims ? claims.data() : nullptr,
                          ray_x.data(),
                          0.05f};
    compare(row);
  }

  [[nodiscard]] const VerdictSums& sums() const { return sums_; }

 private:
  ScenePixel scene_pixel(float depth, std::int32_t triangle) {
    ScenePixel pixel;
    if (random_.uniform() < 0.1) return pixel;
    pixel.depth = depth + static_cast<float>(0.01 * random_.normal());
    pixel.flags = static_cast<std::uint8_t>(random_.index(4));
    Eigen::Vector3f n = random_.unit_vector().cast<float>();
    if (triangle >= 0 && random_.uniform() < 0.7) {
      n = rules_.R_camera_model * mesh_.normals[static_cast<std::size_t>(triangle)];
    }
    pixel.nx = static_cast<std::int8_t>(127.0f * n.x());
    pixel.ny = static_cast<std::int8_t>(127.0f * n.y());
    pixel.nz = static_cast<std::int8_t>(127.0f * n.z());
    return pixel;
  }

  void compare(const PixelRow& row) {
    struct Result {
      std::vector<Verdict> verdicts;
      std::array<std::array<std::uint64_t, 3>, 3> masks = {};
      VerdictSums sums;
    };
    const auto run = [&](JudgeRow judge_row) {
      Result result;
      result.verdicts.assign(row.size, Verdict::kOutside);
      judge_row(row, rules_,
                {result.verdicts.data(), result.masks[0].data(), result.masks[1].data(),
                 result.masks[2].data()},
                result.sums);
      return result;
    };
    const Result a = run(portable_judge_row());
    const Result b = run(best_judge_row());
    EXPECT_EQ(a.verdicts, b.verdicts);
    EXPECT_EQ(a.masks, b.masks);
    EXPECT_EQ(a.sums.counts, b.sums.counts);
    EXPECT_EQ(a.sums.normals, b.sums.normals);
    EXPECT_EQ(a.sums.residual, b.sums.residual);
    EXPECT_EQ(a.sums.residual_squares, b.sums.residual_squares);
    EXPECT_EQ(a.sums.normal_error, b.sums.normal_error);
    EXPECT_EQ(a.sums.scatter, b.sums.scatter);
    for (std::size_t i = 0; i < row.size; ++i) {
      const auto bit = [&](std::size_t mask) { return a.masks[mask][i / 64] >> (i % 64) & 1u; };
      EXPECT_EQ(bit(0) != 0, row.triangle[i] >= 0);
      EXPECT_EQ(bit(0) != 0, a.verdicts[i] != Verdict::kOutside);
      EXPECT_EQ(bit(1) != 0, a.verdicts[i] == Verdict::kSeenThrough);
      EXPECT_EQ(bit(2) != 0, a.verdicts[i] == Verdict::kNearOccluded);
    }
    for (std::size_t k = 0; k < kVerdicts; ++k) sums_.counts[k] += a.sums.counts[k];
    sums_.normals += a.sums.normals;
  }

  Random random_;
  RenderMesh mesh_;
  VerdictRules rules_;
  VerdictSums sums_;
};

TEST(PixelVerdicts, FastestAndPortableOnesGiveTheSameBits) {
  Rows rows(5);
  for (std::size_t size = 0; size <= kWidest; ++size) {
    rows.judge(size, false);
    rows.judge(size, true);
  }
  // Every verdict occurs.
  for (std::size_t k = 1; k < kVerdicts; ++k) {
    EXPECT_GT(rows.sums().counts[k], 50) << "verdict " << k;
  }
  EXPECT_GT(rows.sums().normals, 50);
  EXPECT_LT(rows.sums().normals, rows.sums().count(Verdict::kMatched));
}

TEST(CoverageMask, NeighboursAndSevensMatchPixelByPixel) {
  constexpr int kWidth = 131;
  constexpr int kHeight = 9;
  Random random(2);
  std::vector<char> pixels(kWidth * kHeight);
  CoverageMask mask;
  mask.reset(kWidth, kHeight);
  const auto covers = [&](int u, int v) {
    return u >= 0 && v >= 0 && u < kWidth && v < kHeight &&
           pixels[static_cast<std::size_t>(v * kWidth + u)] != 0;
  };
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      if (random.uniform() < 0.4) continue;
      pixels[static_cast<std::size_t>(v * kWidth + u)] = 1;
      mask.row(v)[u / 64] |= std::uint64_t{1} << (u % 64);
    }
  }
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      for (const int step : {1, 2, 3}) {
        const CoverageMask::Neighbours beside = mask.neighbours(u / 64, v, step);
        const auto bit = [&](std::uint64_t word) { return (word >> (u % 64) & 1u) != 0; };
        EXPECT_EQ(bit(beside.left), covers(u - step, v));
        EXPECT_EQ(bit(beside.right), covers(u + step, v));
        EXPECT_EQ(bit(beside.above), covers(u, v - step));
        EXPECT_EQ(bit(beside.below), covers(u, v + step));
      }
      for (int i = 0; i < 7; ++i) {
        EXPECT_EQ((mask.seven_about(u, v) >> i & 1u) != 0, covers(u - 3 + i, v));
      }
    }
    std::vector<int> visited;
    for (int word = 0; word < mask.words(); ++word) {
      for_each_pixel(mask.row(v)[word], word, [&](int u) { visited.push_back(u); });
    }
    EXPECT_TRUE(std::is_sorted(visited.begin(), visited.end()));
    EXPECT_EQ(std::count_if(visited.begin(), visited.end(), [&](int u) { return covers(u, v); }),
              static_cast<std::ptrdiff_t>(visited.size()));
    EXPECT_GT(visited.size(), 20u);
  }
}

}  // namespace
}  // namespace binpick
