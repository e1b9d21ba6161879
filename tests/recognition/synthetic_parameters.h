#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "models/random.h"
#include "models/range_image.h"
#include "recognition/synthetic_sensor.h"

namespace binpick::testing {

enum class Arrangement {
  kSeparate,  ///< standing or lying, well apart
  kPile,      ///< dropped on each other, standing or lying
  kLeaning    ///< dropped on each other, tilted up to 40 degrees
};

enum class Surroundings {
  kTable,         ///< and the floor below it
  kTableCutAway,  ///< the table was removed from the scan up to 6 mm above it
  kBin,           ///< within four low walls on the table
  kWall,          ///< an upright board stands behind the objects
  kColumn         ///< a post or the foot of a machine stands beside them
};

/// What is handed to the recognizer.
enum class ScanForm {
  kRangeImage,
  kOrganisedCloud,   ///< in the camera's frame, with NaN where nothing was measured
  kUnorganisedCloud  ///< in a frame of its own, without what was not measured
};

/// One scene and its scan. The defaults are the nominal Kinect scene: as measured on a public scan
/// (camera 0.774 m above the table, 33.6 degrees off its normal, sensor as in SensorNoise), models
/// exact but for 1 mm (the rms residual of the models' faces in that scan was 1.1-1.3 mm).
struct SceneParameters {
  // What lies there.
  Arrangement arrangement = Arrangement::kPile;
  Surroundings surroundings = Surroundings::kTable;
  int known = 7;             ///< objects of the known models, in turn
  int unknown = 0;           ///< objects of other shapes
  int copies = 0;            ///< objects like the models but 0.85 or 1.15 times their size
  double radius = 0.16;      ///< of the pile, m
  double table_width = 1.3;  ///< m
  double table_depth = 0.9;  ///< m

  // How the objects differ from their models: models from CAD or a scan are rarely better than 1 %
  // and 1-2 mm.
  double scale_error = 0.0;    ///< each object is larger or smaller by this share
  double shape_error = 0.001;  ///< largest smooth displacement of the surface, m

  // The camera looks at the middle of the table.
  CameraIntrinsics camera{640, 480, 580.0, 580.0, 319.5, 239.5};
  double height = 0.774;  ///< above the table, m
  double tilt = 0.586;    ///< of the optical axis off the table's normal, rad
  double bearing = 0.0;   ///< of the camera about the vertical, rad

  SensorNoise noise;
  ScanForm form = ScanForm::kRangeImage;
  double viewpoint_error = 0.0;  ///< of a cloud: distance of the stated from the true one, m
};

/// The variants by name:
///   kinect      the nominal pile of seven
///   separate, leaning   the other arrangements, three and five objects
///   dilated     silhouettes dilated by 2 px
///   scaled      objects 1 % larger or smaller than their models
///   half, double   320 x 240 and 1280 x 960 px
///   noisy       twice the noise
///   unknown     three unknown objects in the pile
///   copies      two near-copies of the models, 0.85 or 1.15 times their size, in the pile
///   views       camera 0.6-1.2 m above the table, 0-60 degrees off its normal, at most 1.5 m away
///   bin         in a bin
///   tof         time-of-flight camera
///   laser       laser scanner of about 290 000 points, unorganised, viewpoint off by up to 1 cm
///   alone       the same, with nothing but the objects in the scan
///   nothing     five unknown objects, no known one
///   harsh       all of the above drawn at random, with wider ranges of the sensor's parameters
[[nodiscard]] const std::vector<std::string>& variant_names();

/// The parameters of one scene. @throws InputError for an unknown variant.
[[nodiscard]] SceneParameters draw_parameters(std::string_view variant, Seed seed);

/// Master seeds 1 to 999 are for tuning and calibration; results are reported on seeds from 1000
/// on, which nothing may be tuned on.
constexpr Seed kLastTuningSeed = 999;

/// The seed of frame `index` of a variant.
[[nodiscard]] Seed frame_seed(Seed master, std::string_view variant, std::uint64_t index);

}  // namespace binpick::testing
