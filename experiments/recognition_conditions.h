#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "models/config_visitor.h"

namespace binpick {

/// Under which conditions a recognition trial looks at what. Handbook: docs/recognition.md.
struct RecognitionConditions {
  // The pile.
  std::vector<std::string> objects;  ///< dropped, see recognition_object
  std::vector<std::string> models;   ///< searched; empty: those of `objects`, each once
  double frame_size = 0.40;          ///< inside of the frame that they are dropped into, m
  std::int64_t scene_seed = 0;       ///< 0: every trial has its own pile; else all trials have this

  // The wanted occlusion, IJRR 2012, eq. (15).
  std::string target;            ///< the model that has it; empty: the pile is seen as it is
  double occlusion = 0.6;        ///< in [0, 1]
  double occlusion_band = 0.02;  ///< taken when within this of `occlusion`

  // The sensor.
  std::string sensor = "kinect";                       ///< kinect, laser, gaussian or exact
  Eigen::Vector3d camera_position{1.064, 0.0, 0.774};  ///< m
  Eigen::Vector3d camera_look_at{0.55, 0.0, 0.0};      ///< m
  std::int64_t width = 640, height = 480;              ///< px
  double focal_length = 575.0;                         ///< px
  double resolution = 1.0;                             ///< factor of width, height and focal length
  double noise = 1.0;         ///< factor of the sensor's depth noise and bow
  double bow = 0.0025;        ///< of the Kinect, m at the corners at 1 m
  std::int64_t dilation = 0;  ///< silhouettes grow by this, px
  /// Sensor gaussian: standard deviation of each coordinate over the diagonal of the objects' box.
  double gaussian = 0.0;
  /// Whether all that shows no object is cut out of the scan, as in data sets of objects alone.
  bool objects_only = false;

  // The recognizer.
  double model_scale = 1.0;  ///< searched models over true objects
  double visibility = 0.15;  ///< V
  std::int64_t jobs = 1;     ///< threads

  void visit(ConfigVisitor& visitor);
  /// What is scanned and how, without the recognizer's part: what decides the sensor's data.
  [[nodiscard]] RecognitionConditions of_scan() const;
  [[nodiscard]] bool operator==(const RecognitionConditions&) const = default;
  /// The models that are searched, each once.
  [[nodiscard]] std::vector<std::string> searched_models() const;
};

}  // namespace binpick
