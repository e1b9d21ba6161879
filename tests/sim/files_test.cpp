#include <gtest/gtest.h>
#include <png.h>

#include <cstdlib>
#include <filesystem>
#include <vector>

#include "models/errors.h"
#include "sim/png_writer.h"
#include "sim/video_writer.h"

namespace binpick {
namespace {

class Files : public ::testing::Test {
 protected:
  Files()
      : folder_(std::filesystem::path(::testing::TempDir()) /
                (std::string("files_") +
                 ::testing::UnitTest::GetInstance()->current_test_info()->name())) {
    std::filesystem::create_directories(folder_);
  }
  ~Files() override { std::filesystem::remove_all(folder_); }
  std::filesystem::path folder_;
};

ColourImage gradient(int width, int height) {
  ColourImage image{width, height, {}};
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      for (const int value : {u, v, u + v}) image.rgb.push_back(static_cast<std::uint8_t>(value));
    }
  }
  return image;
}

// libpng's own reader; `format` decides the samples.
template <class Sample>
std::vector<Sample> read_png(const std::filesystem::path& file, png_uint_32 format, int& width) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  EXPECT_NE(png_image_begin_read_from_file(&image, file.c_str()), 0);
  image.format = format;
  std::vector<Sample> pixels(PNG_IMAGE_SIZE(image) / sizeof(Sample));
  EXPECT_NE(png_image_finish_read(&image, nullptr, pixels.data(), 0, nullptr), 0);
  width = static_cast<int>(image.width);
  return pixels;
}

TEST_F(Files, ColourPngReadsBackTheSame) {
  const ColourImage image = gradient(31, 17);
  write_png(folder_ / "a.png", image);
  int width = 0;
  EXPECT_EQ(read_png<std::uint8_t>(folder_ / "a.png", PNG_FORMAT_RGB, width), image.rgb);
  EXPECT_EQ(width, 31);
}

TEST_F(Files, DepthPngHoldsMillimetres) {
  RangeImage image;
  image.intrinsics.width = 2;
  image.intrinsics.height = 2;
  image.depth = {0.0f, 0.8004f, 1.0f, 65.0f};
  write_depth_png(folder_ / "d.png", image);
  int width = 0;
  // Samples of 16 bits without a gamma are read as they are.
  EXPECT_EQ(read_png<std::uint16_t>(folder_ / "d.png", PNG_FORMAT_LINEAR_Y, width),
            (std::vector<std::uint16_t>{0, 800, 1000, 65000}));
  EXPECT_EQ(width, 2);
}

TEST_F(Files, UnwritableFolderIsAnIoError) {
  EXPECT_THROW(write_png(folder_ / "none" / "a.png", gradient(2, 2)), IoError);
}

TEST_F(Files, FullDiskIsAnIoError) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP();
  std::filesystem::create_symlink("/dev/full", folder_ / "full.png");
  EXPECT_THROW(write_png(folder_ / "full.png", gradient(300, 300)), IoError);
}

TEST_F(Files, FalseColoursTellNothingFromSomething) {
  RangeImage image;
  image.intrinsics.width = 3;
  image.intrinsics.height = 1;
  image.depth = {0.0f, 0.8f, 1.2f};
  const ColourImage colours = false_colour(image);
  EXPECT_EQ(colours.rgb[0] + colours.rgb[1] + colours.rgb[2], 0);
  EXPECT_GT(colours.rgb[3], colours.rgb[6]);
}

TEST_F(Files, FilmIsWritten) {
  if (std::system("command -v ffmpeg > /dev/null 2>&1") != 0) GTEST_SKIP() << "no ffmpeg";
  VideoWriter film(folder_ / "film.mp4", 64, 48, 25);
  for (int i = 0; i < 10; ++i) film.add(gradient(64, 48));
  film.finish();
  EXPECT_GT(std::filesystem::file_size(folder_ / "film.mp4"), 500u);
}

TEST_F(Files, FilmInAMissingFolderIsAnIoError) {
  if (std::system("command -v ffmpeg > /dev/null 2>&1") != 0) GTEST_SKIP() << "no ffmpeg";
  EXPECT_THROW(
      {
        VideoWriter film(folder_ / "none" / "film.mp4", 640, 480, 25);
        for (int i = 0; i < 20; ++i) film.add(gradient(640, 480));
        film.finish();
      },
      IoError);
}

}  // namespace
}  // namespace binpick
