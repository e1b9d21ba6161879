#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "sim/world.h"

namespace binpick {

/// Rows from top to bottom, three bytes per pixel.
struct ColourImage {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgb;
};

/// Row-major from the top: z along the optical axis in metres, 0 where nothing is within range.
struct DepthImage {
  int width = 0;
  int height = 0;
  std::vector<float> z;
};

/// Row-major from the top: object index, or one of the negative values below.
struct SegmentationImage {
  static constexpr int kBackground = -1;  ///< nothing
  static constexpr int kCell = -2;        ///< table, bins, frame
  static constexpr int kRobot = -3;       ///< arm and gripper
  int width = 0;
  int height = 0;
  std::vector<std::int16_t> object;
};

/// The cameras of a cell.
enum class View { kDepthCamera, kPicture };

/// Off-screen rendering through OSMesa. Owns one GL context, made on and bound to the constructing
/// thread; one renderer per thread. Images do not depend on the thread.
class Renderer {
 public:
  /// @throws std::runtime_error when no GL context can be made.
  Renderer(std::shared_ptr<const WorldTemplate> shared, int max_width, int max_height);
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;

  [[nodiscard]] DepthImage depth(World& world, View view, int width, int height);
  [[nodiscard]] ColourImage colour(World& world, View view, int width, int height);
  [[nodiscard]] SegmentationImage segmentation(World& world, View view, int width, int height);

 private:
  struct Context;
  std::unique_ptr<Context> context_;
};

}  // namespace binpick
