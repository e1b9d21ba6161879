#include "recognition/pair_table.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "recognition/parallel_for.h"

namespace binpick {
namespace {

struct StoredPair {
  std::uint32_t cell;
  std::uint32_t model;
  PairFrame frame;
};

/// Whether `p` lies in the fundamental domain of the model's symmetries: the part of space that is
/// closer to a generic point than to any of its images.
bool in_fundamental_domain(const Eigen::Vector3f& p, const RecognitionModel& model) {
  const Eigen::Vector3d generic =
      (model.centre + model.diameter * Eigen::Vector3f(0.31f, 0.53f, 0.79f)).cast<double>();
  const double distance = (p.cast<double>() - generic).squaredNorm();
  return std::all_of(model.symmetries.begin(), model.symmetries.end(),
                     [&](const Eigen::Isometry3d& symmetry) {
                       const Eigen::Vector3d image = symmetry * generic;
                       return distance <= (1.0 + 1e-9) * (p.cast<double>() - image).squaredNorm();
                     });
}

/// Visits the pairs of one model that have the wanted width and a frame.
template <class Visit>
void for_each_pair(const RecognitionModel& model, const PairTableOptions& options,
                   const Visit& visit) {
  const float nearest = options.width - options.tolerance;
  const float farthest = options.width + options.tolerance;
  for (const OrientedPoint& u : model.surface) {
    if (options.reduce_symmetry && !in_fundamental_domain(u.p, model)) continue;
    for (const OrientedPoint& v : model.surface) {
      const float squared = (v.p - u.p).squaredNorm();
      if (squared < nearest * nearest || squared > farthest * farthest) continue;
      if (const auto frame = pair_frame(u, v)) visit(pair_descriptor(u, v), *frame);
    }
  }
}

PairFrame inverse_of(const Eigen::Isometry3f& frame) {
  return frame.inverse().matrix().topRows<3>();
}

struct CollectedPairs {
  std::vector<StoredPair> pairs;
  std::size_t considered = 0;  // with the ones left out as coplanar
};

CollectedPairs collect_pairs(const RecognitionModel& model, std::uint32_t index,
                             const PairTableOptions& options) {
  CollectedPairs collected;
  for_each_pair(model, options, [&](const PairDescriptor& f, const Eigen::Isometry3f& frame) {
    ++collected.considered;
    if (options.drop_coplanar && is_coplanar(f)) return;
    collected.pairs.push_back({PairTable::cell(f), index, inverse_of(frame)});
  });
  return collected;
}

/// The removal of the most crowded cells: marks the cells that stay.
std::vector<bool> cells_to_keep(const std::vector<StoredPair>& pairs, double kept_fraction) {
  std::vector<std::uint32_t> population(PairTable::kCells, 0);
  for (const StoredPair& pair : pairs) ++population[pair.cell];
  std::vector<std::uint32_t> by_population(PairTable::kCells);
  std::iota(by_population.begin(), by_population.end(), 0u);
  std::stable_sort(by_population.begin(), by_population.end(),
                   [&](auto a, auto b) { return population[a] > population[b]; });
  std::vector<bool> keep(PairTable::kCells, true);
  const auto limit = static_cast<std::size_t>(kept_fraction * static_cast<double>(pairs.size()));
  std::size_t remaining = pairs.size();
  for (const std::uint32_t crowded : by_population) {
    if (remaining <= limit) break;
    keep[crowded] = false;
    remaining -= population[crowded];
  }
  return keep;
}

}  // namespace

std::vector<PairFrame> coplanar_pairs(const RecognitionModel& model,
                                      const PairTableOptions& options) {
  std::vector<PairFrame> pairs;
  for_each_pair(model, options, [&](const PairDescriptor& f, const Eigen::Isometry3f& frame) {
    if (is_coplanar(f)) pairs.push_back(inverse_of(frame));
  });
  return pairs;
}

std::uint32_t PairTable::cell(const PairDescriptor& f) noexcept {
  constexpr float kScale = static_cast<float>(kBins) / std::numbers::pi_v<float>;
  const auto bin = [](float angle) {
    return std::min(static_cast<std::uint32_t>(angle * kScale), kBins - 1);
  };
  return (bin(f.normals) * kBins + bin(f.first)) * kBins + bin(f.second);
}

PairTable::PairTable(const std::vector<RecognitionModel>& models, const PairTableOptions& options,
                     int jobs)
    : models_(models.size()) {
  std::vector<CollectedPairs> collected(models.size());
  parallel_for(static_cast<int>(models.size()), jobs, [&](int i) {
    const auto index = static_cast<std::size_t>(i);
    collected[index] = collect_pairs(models[index], static_cast<std::uint32_t>(i), options);
  });
  std::vector<StoredPair> pairs;
  std::size_t considered = 0;
  for (const CollectedPairs& of_model : collected) {
    pairs.insert(pairs.end(), of_model.pairs.begin(), of_model.pairs.end());
    considered += of_model.considered;
  }
  const std::vector<bool> keep = cells_to_keep(pairs, options.kept_fraction);

  offsets_.assign(kCells * models_ + 1, 0);
  for (const StoredPair& pair : pairs) {
    if (keep[pair.cell]) ++offsets_[pair.cell * models_ + pair.model + 1];
  }
  std::partial_sum(offsets_.begin(), offsets_.end(), offsets_.begin());
  frames_.resize(offsets_.back());
  std::vector<std::uint32_t> next(offsets_.begin(), offsets_.end() - 1);
  for (const StoredPair& pair : pairs) {
    if (keep[pair.cell]) frames_[next[pair.cell * models_ + pair.model]++] = pair.frame;
  }
  if (considered > 0) {
    kept_fraction_ = static_cast<double>(frames_.size()) / static_cast<double>(considered);
  }
}

}  // namespace binpick
