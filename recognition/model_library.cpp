#include "recognition/model_library.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <limits>
#include <set>

#include "models/errors.h"
#include "recognition/parallel_for.h"
#include "recognition/table_hit_rate.h"

namespace binpick {
namespace {

constexpr double kPairWidthShare = 0.6;       // of the smallest middle extent
constexpr double kPairToleranceShare = 0.05;  // of the pair width
constexpr double kLeavesPerDiameter = 34.0;
constexpr double kPaperKeptFraction = 0.4;
/// Eq. (11) reckons with a table that knows every pair: all points of the models' covers make its
/// pairs.
constexpr float kPaperPointsPerDiameter = 1.5f * static_cast<float>(kLeavesPerDiameter);

RecognitionModel prepare(const ModelSource& source) {
  return std::visit(
      [&](const auto& shape) {
        return make_recognition_model(source.name, shape, source.symmetries);
      },
      source.shape);
}

/// All models; of those that are none, the first one's error is thrown.
std::vector<RecognitionModel> prepare_all(const std::vector<ModelSource>& sources, int jobs) {
  std::vector<RecognitionModel> models(sources.size());
  std::vector<std::exception_ptr> errors(sources.size());
  parallel_for(static_cast<int>(sources.size()), jobs, [&](int i) {
    const auto index = static_cast<std::size_t>(i);
    try {
      models[index] = prepare(sources[index]);
    } catch (...) {
      errors[index] = std::current_exception();
    }
  });
  for (const std::exception_ptr& error : errors) {
    if (error) std::rethrow_exception(error);
  }
  return models;
}

}  // namespace

ModelLibrary::ModelLibrary(const std::vector<ModelSource>& sources, RecognizerSetting setting,
                           int jobs)
    : setting_(setting) {
  if (sources.empty()) throw InputError("model library: no model given; name at least one");
  std::set<std::string> names;
  double middle_extent = std::numeric_limits<double>::infinity();
  double diameter = std::numeric_limits<double>::infinity();
  for (const ModelSource& source : sources) {
    if (!names.insert(source.name).second) {
      throw InputError(fmt::format("model library: {} is given twice; name it once", source.name));
    }
  }
  models_ = prepare_all(sources, jobs);
  for (const RecognitionModel& model : models_) {
    middle_extent = std::min(middle_extent, static_cast<double>(model.middle_extent));
    diameter = std::min(diameter, static_cast<double>(model.diameter));
  }
  pair_width_ = kPairWidthShare * middle_extent;
  pair_tolerance_ = kPairToleranceShare * pair_width_;
  leaf_size_ = diameter / kLeavesPerDiameter;

  PairTableOptions options;
  options.width = static_cast<float>(pair_width_);
  options.tolerance = static_cast<float>(pair_tolerance_);
  options.kept_fraction = setting == RecognizerSetting::kPaper ? kPaperKeptFraction : 1.0;
  options.drop_coplanar = setting == RecognizerSetting::kDefault;
  options.reduce_symmetry = setting == RecognizerSetting::kDefault;
  parallel_for(static_cast<int>(models_.size()), jobs, [&](int i) {
    RecognitionModel& model = models_[static_cast<std::size_t>(i)];
    if (setting == RecognizerSetting::kPaper) {
      set_pair_points(model, kPaperPointsPerDiameter);
    } else {
      densify_pair_points(model, options);
    }
  });
  pairs_ = PairTable(models_, options, jobs);
  coplanar_pairs_.resize(models_.size());
  parallel_for(static_cast<int>(models_.size()), jobs, [&](int i) {
    const auto index = static_cast<std::size_t>(i);
    coplanar_pairs_[index] = binpick::coplanar_pairs(models_[index], options);
  });
}

}  // namespace binpick
