#include "sim/png_writer.h"

#include <png.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>

#include "models/errors.h"

namespace binpick {
namespace {

struct FileCloser {
  void operator()(std::FILE* file) const noexcept { std::fclose(file); }
};

// libpng's simplified interface cannot write 16-bit samples as they are, so this uses the full one.
// Its errors jump back to setjmp: no object with a destructor may live between the two.
bool write_rows(std::FILE* file, png_structp png, png_infop info, int width, int height, int depth,
                int colour_type, const std::uint8_t* pixels, std::size_t row_bytes) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_init_io(png, file);
  png_set_compression_level(png, 6);
  png_set_IHDR(png, info, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height), depth,
               colour_type, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  png_write_info(png, info);
  for (int row = 0; row < height; ++row) {
    png_write_row(png, pixels + row_bytes * static_cast<std::size_t>(row));
  }
  png_write_end(png, info);
  return true;
}

void write(const std::filesystem::path& path, int width, int height, int depth, int colour_type,
           const std::uint8_t* pixels, std::size_t row_bytes) {
  std::unique_ptr<std::FILE, FileCloser> file(std::fopen(path.c_str(), "wb"));
  if (!file) throw IoError(path.string() + ": cannot be written; check the folder and its rights");
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png != nullptr ? png_create_info_struct(png) : nullptr;
  bool written = info != nullptr && write_rows(file.get(), png, info, width, height, depth,
                                               colour_type, pixels, row_bytes);
  png_destroy_write_struct(&png, &info);
  written = std::fclose(file.release()) == 0 && written;
  if (!written) {
    std::error_code ignored;
    std::filesystem::remove(path, ignored);
    throw IoError(path.string() + ": writing failed; check the space on the disk");
  }
}

std::array<std::uint8_t, 3> interpolate(double position) {
  static constexpr std::array<std::array<double, 3>, 5> kStops{
      {{250, 230, 120}, {240, 130, 60}, {190, 50, 90}, {80, 40, 130}, {20, 20, 70}}};
  const double scaled = std::clamp(position, 0.0, 1.0) * (kStops.size() - 1);
  const auto lower = std::min(static_cast<std::size_t>(scaled), kStops.size() - 2);
  const double part = scaled - static_cast<double>(lower);
  std::array<std::uint8_t, 3> colour{};
  for (std::size_t i = 0; i < 3; ++i) {
    const double value = (1.0 - part) * kStops[lower][i] + part * kStops[lower + 1][i];
    colour[i] = static_cast<std::uint8_t>(std::lround(value));
  }
  return colour;
}

}  // namespace

void write_png(const std::filesystem::path& file, const ColourImage& image) {
  write(file, image.width, image.height, 8, PNG_COLOR_TYPE_RGB, image.rgb.data(),
        3 * static_cast<std::size_t>(image.width));
}

void write_depth_png(const std::filesystem::path& file, const RangeImage& image) {
  std::vector<std::uint8_t> pixels;
  pixels.reserve(2 * image.depth.size());
  for (const float z : image.depth) {
    const long millimetres = std::clamp(std::lround(1000.0 * double{z}), 0L, 65535L);
    pixels.push_back(static_cast<std::uint8_t>(millimetres >> 8));
    pixels.push_back(static_cast<std::uint8_t>(millimetres & 0xff));
  }
  write(file, image.intrinsics.width, image.intrinsics.height, 16, PNG_COLOR_TYPE_GRAY,
        pixels.data(), 2 * static_cast<std::size_t>(image.intrinsics.width));
}

ColourImage false_colour(const RangeImage& image) {
  std::vector<float> measured;
  for (const float z : image.depth) {
    if (z > 0.0f) measured.push_back(z);
  }
  ColourImage out{image.intrinsics.width, image.intrinsics.height,
                  std::vector<std::uint8_t>(3 * image.depth.size(), 0)};
  if (measured.empty()) return out;
  // The extremes of a noisy image are outliers; the outer hundredths only saturate.
  const auto quantile = [&](double share) {
    const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(measured.size() - 1));
    std::nth_element(measured.begin(), measured.begin() + at, measured.end());
    return double{measured[static_cast<std::size_t>(at)]};
  };
  const double near_z = quantile(0.01);
  const double range = std::max(quantile(0.99) - near_z, 1e-6);
  for (std::size_t i = 0; i < image.depth.size(); ++i) {
    if (image.depth[i] <= 0.0f) continue;
    const std::array<std::uint8_t, 3> colour =
        interpolate((double{image.depth[i]} - near_z) / range);
    std::copy(colour.begin(), colour.end(), out.rgb.begin() + static_cast<std::ptrdiff_t>(3 * i));
  }
  return out;
}

ColourImage false_colour(const SegmentationImage& image) {
  static constexpr std::array<std::array<std::uint8_t, 3>, 8> kObjects{{{230, 80, 60},
                                                                        {70, 150, 230},
                                                                        {90, 190, 90},
                                                                        {240, 190, 60},
                                                                        {170, 100, 220},
                                                                        {80, 210, 210},
                                                                        {240, 130, 180},
                                                                        {160, 130, 80}}};
  ColourImage out{image.width, image.height, {}};
  out.rgb.reserve(3 * image.object.size());
  for (const std::int16_t object : image.object) {
    std::array<std::uint8_t, 3> colour{0, 0, 0};
    if (object == SegmentationImage::kCell) colour = {70, 70, 75};
    if (object == SegmentationImage::kRobot) colour = {140, 140, 150};
    if (object >= 0) colour = kObjects[static_cast<std::size_t>(object) % kObjects.size()];
    out.rgb.insert(out.rgb.end(), colour.begin(), colour.end());
  }
  return out;
}

}  // namespace binpick
