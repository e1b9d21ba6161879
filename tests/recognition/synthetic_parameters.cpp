#include "recognition/synthetic_parameters.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "models/errors.h"

namespace binpick::testing {
namespace {

CameraIntrinsics camera_of(int width, int height, double focal) {
  return {width, height, focal, focal, 0.5 * (width - 1), 0.5 * (height - 1)};
}

bool chance(Random& random, double probability) { return random.uniform() < probability; }

/// Pulsed or phase-shift: noise of a few millimetres without memory, many flying pixels, neither
/// shadow nor dilation. Sarbolandi, Lefloch and Kolb, "Kinect range sensing: structured-light
/// versus time-of-flight Kinect", CVIU 2015; Kinect v2: 512 x 424 px, f = 365 px.
SensorNoise time_of_flight() {
  SensorNoise noise;
  noise.sigma_0 = 0.0005;
  noise.sigma_1 = 0.001;
  noise.sigma_2 = 0.0;
  noise.correlated = 0.2;
  noise.bow = 0.003;
  noise.disparity_step = 0.0;
  noise.baseline = 0.0;
  noise.most_dilation = 0.0;
  noise.raggedness = 0.3;
  noise.mixed_pixels = 0.4;
  noise.window = 1;
  noise.shadow_margin = 0.0;
  noise.grazing_cosine = 0.1;
  return noise;
}

/// A laser stripe scanner of the Vivid 910's kind: 640 x 480 points, 0.1-0.5 mm, a baseline of
/// about 0.2 m between stripe and camera.
SensorNoise laser_scanner() {
  SensorNoise noise;
  noise.sigma_0 = 0.0003;
  noise.sigma_2 = 0.0;
  noise.correlated = 0.1;
  noise.grazing_sigma = 0.00002;
  noise.bow = 0.0003;
  noise.disparity_step = 0.0;
  noise.baseline = 0.2;
  noise.most_dilation = 0.0;
  noise.raggedness = 0.3;
  noise.mixed_pixels = 0.03;
  noise.window = 0;
  noise.shadow_margin = 0.0;
  noise.grazing_cosine = 0.12;
  return noise;
}

/// 0.6-1.2 m above the table, 0-60 degrees off its normal, at most `farthest` from its middle.
void draw_view(SceneParameters& p, double farthest, Random& random) {
  do {
    p.height = random.uniform(0.6, 1.2);
    p.tilt = random.uniform(0.0, std::numbers::pi / 3.0);
  } while (p.height > farthest * std::cos(p.tilt));
  p.bearing = random.uniform(0.0, 2.0 * std::numbers::pi);
}

void make_laser(SceneParameters& p, Random& random) {
  p.noise = laser_scanner();
  p.noise.sigma_0 = random.uniform(0.0001, 0.0005);
  p.camera = camera_of(640, 480, 900.0);
  p.form = ScanForm::kUnorganisedCloud;
  p.viewpoint_error = random.uniform(0.0, 0.01);
  p.height = random.uniform(0.8, 1.0);
}

/// Kinect-like sensors of all makes: ranges about the nominal values, the upper ends as pessimistic
/// as what users report of worn or cheap ones.
void draw_structured_light(SceneParameters& p, Random& random) {
  constexpr std::array<double, 3> kScales = {0.5, 1.0, 2.0};
  const double which = random.uniform();
  const double scale = kScales[which < 0.25 ? 0 : which < 0.85 ? 1 : 2];
  p.camera = camera_of(static_cast<int>(640 * scale), static_cast<int>(480 * scale),
                       580.0 * scale * random.uniform(0.85, 1.3));
  p.noise.sigma_2 = random.uniform(0.0008, 0.003);
  p.noise.correlated = random.uniform(0.3, 0.8);
  p.noise.bow = random.uniform(0.0, 0.003);
  p.noise.disparity_step = chance(random, 0.8) ? 0.125 * scale : 0.0;
  p.noise.least_dilation = std::floor(random.uniform(0.0, 3.0));
  p.noise.most_dilation =
      std::min(p.noise.least_dilation + std::floor(random.uniform(0.0, 3.0)), 3.0);
  p.noise.raggedness = random.uniform(0.2, 1.0);
  p.noise.mixed_pixels = random.uniform(0.0, 0.3);
  p.noise.window = static_cast<int>(random.index(4));
  p.noise.shadow_margin = std::floor(random.uniform(0.0, 5.0));
  p.noise.grazing_cosine = random.uniform(0.1, 0.3);
  const double form = random.uniform();
  if (form > 0.7) p.form = form > 0.85 ? ScanForm::kOrganisedCloud : ScanForm::kUnorganisedCloud;
}

void draw_time_of_flight(SceneParameters& p, Random& random) {
  p.noise = time_of_flight();
  p.noise.sigma_1 = random.uniform(0.0005, 0.002);
  p.noise.mixed_pixels = random.uniform(0.1, 0.5);
  p.noise.window = static_cast<int>(random.index(3));
  p.camera = chance(random, 0.5) ? camera_of(512, 424, 365.0) : camera_of(640, 480, 520.0);
}

void draw_laser(SceneParameters& p, Random& random) {
  make_laser(p, random);
  p.camera = camera_of(640, 480, random.uniform(700.0, 1000.0));
  p.noise.baseline = random.uniform(0.1, 0.25);
  p.noise.mixed_pixels = random.uniform(0.0, 0.06);
  p.noise.raggedness = random.uniform(0.0, 0.5);
  const double form = random.uniform();
  if (form > 0.5) p.form = form > 0.8 ? ScanForm::kRangeImage : ScanForm::kOrganisedCloud;
}

SceneParameters draw_harsh(Random& random) {
  SceneParameters p;
  const double sensor = random.uniform();
  if (sensor < 0.6) draw_structured_light(p, random);
  if (sensor >= 0.6 && sensor < 0.75) draw_time_of_flight(p, random);
  if (sensor >= 0.75) draw_laser(p, random);
  p.noise.shiny_share = chance(random, 0.3) ? random.uniform(0.002, 0.04) : 0.0;
  p.viewpoint_error = p.form == ScanForm::kRangeImage ? 0.0 : random.uniform(0.0, 0.02);
  draw_view(p, 1.4, random);
  p.arrangement = static_cast<Arrangement>(random.index(3));
  const double where = random.uniform();
  if (where > 0.5) p.surroundings = Surroundings::kTableCutAway;
  if (where > 0.68) p.surroundings = Surroundings::kBin;
  if (where > 0.8) p.surroundings = Surroundings::kWall;
  if (where > 0.9) p.surroundings = Surroundings::kColumn;
  const bool separate = p.arrangement == Arrangement::kSeparate;
  p.known = 1 + static_cast<int>(random.index(separate ? 4 : 8));
  p.unknown = static_cast<int>(random.index(separate ? 2 : 5));
  p.copies = chance(random, 0.3) ? 1 : 0;
  p.radius = random.uniform(0.08, 0.22);
  p.table_width = random.uniform(0.8, 1.6);
  p.table_depth = random.uniform(0.6, 1.2);
  p.scale_error = random.uniform(0.0, 0.02);
  p.shape_error = random.uniform(0.0, 0.002);
  return p;
}

}  // namespace

const std::vector<std::string>& variant_names() {
  static const std::vector<std::string> names = {
      "kinect", "separate", "leaning", "dilated", "scaled", "half",  "double",  "noisy", "unknown",
      "copies", "views",    "bin",     "tof",     "laser",  "alone", "nothing", "harsh"};
  return names;
}

SceneParameters draw_parameters(std::string_view variant, Seed seed) {
  Random random(derive_seed(seed, "parameters"));
  if (variant == "harsh") return draw_harsh(random);
  SceneParameters p;
  if (variant == "separate") {
    p.arrangement = Arrangement::kSeparate;
    p.known = 3;
  } else if (variant == "leaning") {
    p.arrangement = Arrangement::kLeaning;
    p.known = 5;
    p.radius = 0.18;
  } else if (variant == "dilated") {
    p.noise.least_dilation = p.noise.most_dilation = 2.0;
  } else if (variant == "scaled") {
    p.scale_error = 0.01;
  } else if (variant == "half") {
    p.camera = camera_of(320, 240, 290.0);
  } else if (variant == "double") {
    p.camera = camera_of(1280, 960, 1160.0);
  } else if (variant == "noisy") {
    p.noise.sigma_2 *= 2.0;
  } else if (variant == "unknown") {
    p.unknown = 3;
  } else if (variant == "copies") {
    p.copies = 2;
  } else if (variant == "views") {
    draw_view(p, 1.5, random);
  } else if (variant == "bin") {
    p.surroundings = Surroundings::kBin;
  } else if (variant == "tof") {
    p.noise = time_of_flight();
    p.camera = camera_of(512, 424, 365.0);
  } else if (variant == "laser" || variant == "alone") {
    make_laser(p, random);
    if (variant == "alone") p.surroundings = Surroundings::kTableCutAway;
  } else if (variant == "nothing") {
    p.known = 0;
    p.unknown = 5;
  } else if (variant != "kinect") {
    std::string names;
    for (const std::string& name : variant_names()) names += " " + name;
    throw InputError("no variant is called '" + std::string(variant) + "'; choose one of" + names);
  }
  return p;
}

Seed frame_seed(Seed master, std::string_view variant, std::uint64_t index) {
  return derive_seed(derive_seed(derive_seed(master, "recognition frames"), variant), index);
}

}  // namespace binpick::testing
