// What a person may hand over by mistake or malice, one row each: every reader answers with a
// cloud, a mesh or one InputError that names the file, soon and within bounds.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cstring>
#include <ostream>

#include "models/cloud_file.h"
#include "models/errors.h"
#include "models/input_bytes.h"
#include "models/model_file.h"
#include "models/pcd_file.h"
#include "models/ply_file.h"
#include "temporary_folder.h"

namespace binpick {
namespace {

using ::testing::HasSubstr;

struct BadFile {
  std::string name;  ///< with the extension that picks the reader
  std::string content;
  std::string complaint;  ///< part of the message
};

void PrintTo(const BadFile& file, std::ostream* out) { *out << file.name; }

const std::string kPlyXyz = "property float x\nproperty float y\nproperty float z\n";
const std::string kPcdXyz = "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n";
const std::string kVtk = "# vtk DataFile Version 3.0\nt\n";

std::string ascii_ply(const std::string& count, const std::string& body) {
  return "ply\nformat ascii 1.0\nelement vertex " + count + "\n" + kPlyXyz + body;
}

std::string mesh_ply(const std::string& faces, const std::string& corners) {
  return ascii_ply("3", "element face " + faces +
                            "\nproperty list uchar int vertex_indices\nend_header\n"
                            "0 0 0\n1 0 0\n0 1 0\n" +
                            corners);
}

std::string huge_stl() {
  std::string stl(84, '\0');
  stl[80] = stl[81] = stl[82] = stl[83] = '\x7f';
  return stl;
}

std::string long_header_line() {
  std::string text = "VERSION .7\nFIELDS";
  for (int i = 0; i < 100000; ++i) text += " x";
  return text + "\nDATA ascii\n";
}

/// 2^30 points of 2^34 bytes, whose product is 0 modulo 2^64.
std::string wrapping_pcd() {
  std::string fields = "FIELDS x y z last";
  std::string sizes = "SIZE 4 4 4 4";
  std::string types = "TYPE F F F F";
  std::string counts = "COUNT 1 1 1 1";
  for (int i = 0; i < 2048; ++i) {
    fields += " _";
    sizes += " 8";
    types += " F";
    counts += i == 0 ? " 1048574" : " 1048576";
  }
  return fields + "\n" + sizes + "\n" + types + "\n" + counts +
         "\nWIDTH 1073741824\nHEIGHT 1\nDATA binary\n0123456789";
}

std::string compressed_pcd(const std::string& fields, std::uint32_t plain_size) {
  std::string text = fields + "DATA binary_compressed\n";
  const std::uint32_t sizes[2] = {4, plain_size};
  text.append(reinterpret_cast<const char*>(sizes), sizeof(sizes));
  return text +
         "\x02"
         "abc";
}

const BadFile kBadFiles[] = {
    {"empty.ply", "", "neither PLY nor PCD"},
    {"empty.obj", "", "empty.obj"},
    {"empty.stl", "", "empty.stl"},
    // Counts that lie.
    {"trillion.ply", ascii_ply("1000000000000", "end_header\n1 2 3\n"), "outside"},
    {"two_billion.ply", ascii_ply("2000000000", "end_header\n1 2 3\n"), "need more than"},
    {"negative.ply", ascii_ply("-5", "end_header\n1 2 3\n"), "outside"},
    {"overflow.ply", ascii_ply("99999999999999999999999", "end_header\n"), "whole number"},
    {"faces.ply", mesh_ply("2000000000", "3 0 1 2\n"), "need more than"},
    {"list.ply", mesh_ply("1", "2000000000 0 1 2\n"), "a list's length"},
    {"list_minus.ply", mesh_ply("1", "-3 0 1 2\n"), "a list's length"},
    {"trillion.pcd", kPcdXyz + "WIDTH 1000000000000\nHEIGHT 1\nDATA binary\n", "whole number"},
    {"negative.pcd", kPcdXyz + "WIDTH -1\nHEIGHT 1\nDATA ascii\n1 2 3\n", "whole number"},
    {"product.pcd", kPcdXyz + "WIDTH 2000000000\nHEIGHT 2000000000\nDATA binary\n1", "need more"},
    {"disagree.pcd", kPcdXyz + "WIDTH 2\nHEIGHT 2\nPOINTS 5\nDATA ascii\n1 2 3\n", "POINTS is 5"},
    {"wraps.pcd", wrapping_pcd(), "need more than"},
    {"many_values.pcd",
     "VERSION .7\nFIELDS x y z a\nSIZE 4 4 4 8\nTYPE F F F F\nCOUNT 1 1 1 1048576\nWIDTH 1\n"
     "HEIGHT 1\nDATA ascii\n1 2 3\n",
     "need more than"},
    {"bomb.pcd", compressed_pcd(kPcdXyz + "WIDTH 300000000\nHEIGHT 1\n", 3600000000u), "more than"},
    {"wrong_size.pcd", compressed_pcd(kPcdXyz + "WIDTH 3\nHEIGHT 1\n", 35), "unpack to 35"},
    {"long_line.pcd", long_header_line(), "too long"},
    {"trillion.vtk", kVtk + "ASCII\nDATASET POLYDATA\nPOINTS 1000000000000 float\n", "outside"},
    {"negative.vtk", kVtk + "BINARY\nDATASET POLYDATA\nPOINTS -7 float\n", "outside"},
    {"cells.vtk", kVtk + "ASCII\nDATASET POLYDATA\nPOINTS 1 float\n1 2 3\nPOLYGONS 2 4\n5 0 0 0\n",
     "a cell's length"},
    {"offsets.vtk",
     "# vtk DataFile Version 5.1\nt\nASCII\nDATASET POLYDATA\nPOINTS 3 float\n0 0 0 1 0 0 0 1 0\n"
     "POLYGONS 2 3\nOFFSETS vtktypeint64\n3 0\nCONNECTIVITY vtktypeint64\n0 1 2\n",
     "must not fall"},
    {"promise.stl", huge_stl(), "promise.stl"},
    // Files that end too soon.
    {"cut_header.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x", "header"},
    {"cut_body.ply",
     "ply\nformat binary_little_endian 1.0\nelement vertex 2\n" + kPlyXyz +
         "end_header\n12345678901234567890",
     "need more than"},
    {"cut.pcd", kPcdXyz + "WIDTH 2\nHEIGHT 1\nDATA binary\n12345678901234567890", "need more than"},
    {"cut.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2", "cut.obj"},
    // Surfaces that are none.
    {"no_faces.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n", "no_faces.obj"},
    {"no_area.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n", "no triangles"},
    {"one_place.obj", "v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\n", "no triangles"},
    {"range.ply", mesh_ply("1", "3 0 1 3\n"), "a vertex index"},
    {"minus.ply", mesh_ply("1", "3 0 1 -1\n"), "a vertex index"},
    {"fraction.ply", mesh_ply("1", "3 0 1 1.5\n"), "a vertex index"},
    {"range.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 2000000000\n", "range.obj"},
    {"minus.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -2000000000\n", "minus.obj"},
    {"nan.obj", "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "nan.obj"},
    {"infinite.ply",
     ascii_ply("3",
               "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
               "0 0 0\n1 0 0\n0 inf 0\n3 0 1 2\n"),
     "not finite"},
};

class BadFiles : public ::testing::TestWithParam<BadFile> {};

double processor_seconds() {
  double seconds = 0.0;
  for (const int who : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
    rusage usage{};
    getrusage(who, &usage);
    seconds += static_cast<double>(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
               1e-6 * static_cast<double>(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
  }
  return seconds;
}

TEST_P(BadFiles, GetOneLineSoonAndWithinBounds) {
  const TemporaryFolder folder;
  const auto file = folder.write(GetParam().name, GetParam().content);
  const double begin = processor_seconds();
  try {
    static_cast<void>(read_model_file(file));
    ADD_FAILURE() << "was read";
  } catch (const InputError& error) {
    const std::string message = error.what();
    EXPECT_THAT(message, HasSubstr(GetParam().name));
    EXPECT_THAT(message, HasSubstr(GetParam().complaint));
    EXPECT_THAT(message, ::testing::Not(HasSubstr("\n")));
  }
  EXPECT_LT(processor_seconds() - begin, 1.0);
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  EXPECT_LT(usage.ru_maxrss, 500L * 1024);  // KiB
#endif
}

INSTANTIATE_TEST_SUITE_P(Table, BadFiles, ::testing::ValuesIn(kBadFiles), [](const auto& row) {
  std::string name = row.param.name;
  for (char& c : name) c = c == '.' ? '_' : c;
  return name;
});

TEST(BadInput, CloudsWithoutAPointAreEmptyAndNoError) {
  const TemporaryFolder folder;
  const auto points = [&](const std::string& name, const std::string& content) {
    return read_cloud(folder.write(name, content)).points.size();
  };
  EXPECT_EQ(points("none.ply", ascii_ply("0", "end_header\n")), 0u);
  EXPECT_EQ(points("none.pcd", kPcdXyz + "WIDTH 0\nHEIGHT 1\nDATA binary\n"), 0u);
  EXPECT_EQ(points("none.vtk", kVtk + "ASCII\nDATASET POLYDATA\nPOINTS 0 float\n"), 0u);
  EXPECT_EQ(points("nan.pcd", kPcdXyz + "WIDTH 2\nHEIGHT 1\nDATA ascii\nnan nan nan\ninf 0 0\n"),
            0u);
  // A number that single precision cannot hold is a point that was not measured.
  EXPECT_EQ(points("large.ply", ascii_ply("2", "end_header\n1e300 0 0\n1 2 3\n")), 1u);
}

/// Binary, as little memory beside the points as possible.
TEST(BadInput, ACloudOfManyPointsCostsLittleMoreThanItsPoints) {
  constexpr std::size_t kPoints = 1'000'000;
  const TemporaryFolder folder;
  std::string rows(kPoints * 12, '\0');
  for (std::size_t i = 0; i < kPoints; ++i) {
    const float point[3] = {static_cast<float>(i), 1.0f, 2.0f};
    std::memcpy(rows.data() + 12 * i, point, sizeof(point));
  }
  const auto file = folder.write("large.pcd", kPcdXyz + "WIDTH " + std::to_string(kPoints) +
                                                  "\nHEIGHT 1\nDATA binary\n" + rows);
  const double begin = processor_seconds();
  const PointCloud cloud = read_cloud(file);
  EXPECT_LT(processor_seconds() - begin, 0.3);
  ASSERT_EQ(cloud.points.size(), kPoints);
  EXPECT_EQ(cloud.points[123'456], Eigen::Vector3f(123'456.0f, 1.0f, 2.0f));
  EXPECT_EQ(cloud.points.back(), Eigen::Vector3f(999'999.0f, 1.0f, 2.0f));
}

}  // namespace
}  // namespace binpick
