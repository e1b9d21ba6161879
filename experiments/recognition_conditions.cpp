#include "experiments/recognition_conditions.h"

#include <algorithm>

namespace binpick {

void RecognitionConditions::visit(ConfigVisitor& visitor) {
  const NumberSpec share{0.0, 1.0, 1.0};
  const NumberSpec place{-5.0, 5.0, 1.0};
  visitor.texts("objects", objects);
  visitor.texts("models", models);
  visitor.number("frame_size", frame_size, {0.1, 1.0, 1.0});
  visitor.integer("scene_seed", scene_seed, 0, 1'000'000);
  visitor.text("target", target);
  visitor.number("occlusion", occlusion, share);
  visitor.number("occlusion_band", occlusion_band, {0.001, 1.0, 1.0});
  visitor.choice("sensor", sensor, {"kinect", "laser", "gaussian", "exact"});
  visitor.vector("camera_position", camera_position, place);
  visitor.vector("camera_look_at", camera_look_at, place);
  visitor.integer("width", width, 16, 4096);
  visitor.integer("height", height, 16, 4096);
  visitor.number("focal_length_px", focal_length, {10.0, 10'000.0, 1.0});
  visitor.number("resolution", resolution, {0.1, 4.0, 1.0});
  visitor.number("noise", noise, {0.0, 10.0, 1.0});
  visitor.number("bow_mm", bow, {0.0, 20.0, kMillimetre});
  visitor.integer("dilation_px", dilation, 0, 10);
  visitor.number("gaussian_percent", gaussian, {0.0, 10.0, 0.01});
  visitor.boolean("objects_only", objects_only);
  visitor.number("model_scale", model_scale, {0.5, 2.0, 1.0});
  visitor.number("visibility", visibility, {0.001, 0.999, 1.0});
  visitor.integer("jobs", jobs, 1, 1024);
  if (!visitor.reading()) return;
  if (objects.empty()) visitor.problem("objects", "'objects' needs at least one name");
  if (objects_only && sensor == "gaussian") {
    visitor.problem("objects_only", "'objects_only' wants a sensor that gives a range image");
  }
  if (!target.empty() && std::find(objects.begin(), objects.end(), target) == objects.end()) {
    visitor.problem("target", "'target' is none of the objects");
  }
}

RecognitionConditions RecognitionConditions::of_scan() const {
  const RecognitionConditions defaults;
  RecognitionConditions result = *this;
  result.models = defaults.models;
  result.model_scale = defaults.model_scale;
  result.visibility = defaults.visibility;
  result.jobs = defaults.jobs;
  return result;
}

std::vector<std::string> RecognitionConditions::searched_models() const {
  std::vector<std::string> result;
  for (const std::string& name : models.empty() ? objects : models) {
    if (std::find(result.begin(), result.end(), name) == result.end()) result.push_back(name);
  }
  return result;
}

}  // namespace binpick
