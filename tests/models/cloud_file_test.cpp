#include "models/cloud_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstring>

#include "message_of.h"
#include "models/errors.h"
#include "models/lzf.h"
#include "models/model_file.h"
#include "models/pcd_file.h"
#include "models/ply_file.h"
#include "models/random.h"
#include "temporary_folder.h"

namespace binpick {
namespace {

using ::testing::HasSubstr;

template <class T>
std::string bytes_of(T value, std::endian order = std::endian::little) {
  std::string text(sizeof(T), '\0');
  std::memcpy(text.data(), &value, sizeof(T));
  if (order != std::endian::native) std::reverse(text.begin(), text.end());
  return text;
}

void expect_points(const PointCloud& cloud, const std::vector<Eigen::Vector3f>& points) {
  ASSERT_EQ(cloud.points.size(), points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_LT((cloud.points[i] - points[i]).norm(), 1e-6f) << i;
  }
  EXPECT_EQ(cloud.width * cloud.height, static_cast<int>(points.size()));
}

class CloudFile : public ::testing::Test {
 protected:
  PointCloud read(const std::string& text, double unit = 1.0) {
    return read_cloud(folder_.write("cloud", text), unit);
  }
  std::string refusal(const std::string& text) {
    const auto file = folder_.write("cloud", text);
    return message_of<InputError>([&] { static_cast<void>(read_cloud(file)); });
  }

  TemporaryFolder folder_;
  const std::vector<Eigen::Vector3f> two_{{1.0f, 2.0f, 3.0f}, {-4.0f, 5.5f, 0.25f}};
};

TEST_F(CloudFile, WrittenPlyReadsBackBitForBit) {
  Random random(9);
  PointCloud cloud;
  for (int i = 0; i < 500; ++i) {
    cloud.points.push_back(random.unit_vector().cast<float>());
    cloud.normals.push_back(random.unit_vector().cast<float>().normalized());
  }
  const auto file = folder_.path() / "written.ply";
  write_ply(file, cloud);
  const PointCloud back = read_cloud(file);
  EXPECT_EQ(back.points, cloud.points);
  ASSERT_TRUE(back.has_normals());
  for (std::size_t i = 0; i < 500; ++i) {
    EXPECT_LT((back.normals[i] - cloud.normals[i]).norm(), 1e-6f);
  }
  EXPECT_THROW(write_ply(folder_.path() / "absent" / "x.ply", cloud), IoError);
}

TEST_F(CloudFile, ReadsPlyInAllEncodings) {
  const std::string properties =
      "element vertex 2\nproperty double x\nproperty float y\nproperty short z\n"
      "property list uchar int tags\nproperty uchar red\nend_header\n";
  const std::vector<Eigen::Vector3f> expected{{1.5f, 2.0f, -3.0f}, {4.0f, 5.5f, 6.0f}};
  expect_points(read("ply\r\nformat ascii 1.0\r\ncomment by hand\n" + properties +
                     "1.5 2 -3 2 7 8 255\n4 +5.5 6 0 0"),
                expected);
  for (const std::endian order : {std::endian::little, std::endian::big}) {
    const std::string name =
        order == std::endian::little ? "binary_little_endian" : "binary_big_endian";
    std::string text = "ply\nformat " + name + " 1.0\n" + properties;
    text += bytes_of(1.5, order) + bytes_of(2.0f, order) + bytes_of(std::int16_t{-3}, order) +
            '\x01' + bytes_of(7, order) + '\xff';
    text += bytes_of(4.0, order) + bytes_of(5.5f, order) + bytes_of(std::int16_t{6}, order) + '\0' +
            '\0';
    expect_points(read(text), expected);
  }
}

TEST_F(CloudFile, ReadsPcdInAllEncodings) {
  const std::string header =
      "# .PCD v0.7\nVERSION 0.7\nFIELDS rgb x y z\nSIZE 4 4 4 4\nTYPE U F F F\nCOUNT 1 1 1 1\n"
      "WIDTH 2\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\nDATA ";
  expect_points(read(header + "ascii\n4278190335 1 2 3\n0 -4 5.5 .25\n"), two_);

  std::string rows;
  std::string columns = bytes_of(1) + bytes_of(1);
  for (const Eigen::Vector3f& p : two_) {
    rows += bytes_of(1) + bytes_of(p.x()) + bytes_of(p.y()) + bytes_of(p.z());
  }
  for (int k = 0; k < 3; ++k) columns += bytes_of(two_[0][k]) + bytes_of(two_[1][k]);
  expect_points(read(header + "binary\n" + rows), two_);

  // Plain runs are valid LZF: 31 means that 32 bytes follow.
  const std::string packed = '\x1f' + columns;
  const auto size = [](std::size_t n) { return bytes_of(static_cast<std::uint32_t>(n)); };
  expect_points(read(header + "binary_compressed\n" + size(packed.size()) + size(32) + packed),
                two_);
}

TEST_F(CloudFile, ReadsVtkInBothEncodingsAndItsNormals) {
  const std::string head = "# vtk DataFile Version 3.0\ntitle\n";
  const PointCloud ascii =
      read(head +
           "ASCII\nDATASET POLYDATA\nPOINTS 2 float\n1 2 3\n-4 5.5 0.25\nVERTICES 1 3\n2 0 1\n"
           "POINT_DATA 2\nSCALARS heat float\nLOOKUP_TABLE default\n1 2\n"
           "NORMALS n float\n0 0 2\n1 0 0\n");
  expect_points(ascii, two_);
  ASSERT_TRUE(ascii.has_normals());
  EXPECT_EQ(ascii.normals[0], Eigen::Vector3f(0, 0, 1));

  std::string binary = head + "BINARY\nDATASET POLYDATA\nPOINTS 2 double\n";
  for (const Eigen::Vector3f& p : two_) {
    for (int k = 0; k < 3; ++k) binary += bytes_of(static_cast<double>(p[k]), std::endian::big);
  }
  binary += "\nPOLYGONS 1 4\n";
  for (const int value : {3, 0, 1, 0}) binary += bytes_of(value, std::endian::big);
  binary += "\nPOINT_DATA 2\nNORMALS n float\n";
  for (const float value : {0.f, 0.f, 1.f, 1.f, 0.f, 0.f}) {
    binary += bytes_of(value, std::endian::big);
  }
  const PointCloud cloud = read(binary + "\n");
  expect_points(cloud, two_);
  EXPECT_EQ(cloud.normals[1], Eigen::Vector3f(1, 0, 0));
}

TEST_F(CloudFile, OrganisedCloudsKeepTheirGaps) {
  const std::string body = "SIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n";
  const PointCloud organised =
      read("VERSION .7\nFIELDS x y z\n" + body +
           "WIDTH 2\nHEIGHT 2\nDATA ascii\n1 2 3\nnan nan nan\n4 5 6\n7 8 9");
  EXPECT_TRUE(organised.organised());
  ASSERT_EQ(organised.points.size(), 4u);
  EXPECT_TRUE(std::isnan(organised.points[1].x()));
  EXPECT_EQ(organised.points[3], Eigen::Vector3f(7, 8, 9));

  const PointCloud loose = read("VERSION .7\nFIELDS x y z\n" + body +
                                "WIDTH 3\nHEIGHT 1\nDATA ascii\n1 2 3\nnan nan nan\n4 5 6\n");
  EXPECT_EQ(loose.points.size(), 2u);
  EXPECT_EQ(loose.width, 2);
}

TEST_F(CloudFile, UnitsScalePointsButNotNormals) {
  const PointCloud cloud = read(
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
      "property float z\nproperty float nx\nproperty float ny\nproperty float nz\nend_header\n"
      "1000 0 500 0 3 4\n",
      0.001);
  EXPECT_LT((cloud.points[0] - Eigen::Vector3f(1.0f, 0.0f, 0.5f)).norm(), 1e-6f);
  EXPECT_LT((cloud.normals[0] - Eigen::Vector3f(0.0f, 0.6f, 0.8f)).norm(), 1e-6f);
}

TEST_F(CloudFile, TextErrorsHaveLineAndColumn) {
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\n"
      "property float y\nproperty float z\nend_header\n";
  EXPECT_THAT(refusal(ply + "1 2 3\n4 five 6\n"), HasSubstr("cloud:9:3: 'five'"));
  EXPECT_THAT(refusal(ply + "1 2 3\n4 5      "), HasSubstr("truncated"));
  EXPECT_THAT(refusal("ply\nformat ascii 2.0\n"), HasSubstr("cloud:2:1: "));
  EXPECT_THAT(refusal("ply\nformat ascii 1.0\nelement vertex many\n"), HasSubstr("cloud:3:16: "));
  EXPECT_THAT(refusal("ply\nformat ascii 1.0\nelement vertex 1\nproperty quad x\n"),
              HasSubstr("cloud:4:10: unknown PLY type"));
  EXPECT_THAT(refusal("FIELDS x y z\nSIZE 4 4\n"), HasSubstr("cloud:"));
  EXPECT_THAT(refusal("FIELDS x y z\nSIZE 4 4 3\nTYPE F F F\nWIDTH 1\nHEIGHT 1\nDATA ascii\n1 2 3"),
              HasSubstr("cloud:3:10: no TYPE 'F' of SIZE 3"));
  EXPECT_THAT(refusal("# vtk DataFile Version 3.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\n"),
              HasSubstr("cloud:4:"));
  EXPECT_THAT(refusal("hello\n"), HasSubstr("cloud:1:1: "));
  EXPECT_THAT(refusal(""), HasSubstr("cloud:1:1: "));
}

TEST_F(CloudFile, PromisesThatTheFileCannotKeepAreRefusedAtOnce) {
  // Each of these would ask for gigabytes if the header were believed.
  EXPECT_THAT(refusal("ply\nformat binary_little_endian 1.0\nelement vertex 2000000000\n"
                      "property double x\nproperty double y\nproperty double z\nend_header\n12345"),
              HasSubstr("cloud:3:1: "));
  EXPECT_THAT(refusal("ply\nformat ascii 1.0\nelement vertex 99999999999999\n"),
              HasSubstr("outside"));
  const std::string pcd =
      "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 50000\nHEIGHT 40000\n";
  EXPECT_THAT(refusal(pcd + "DATA ascii\n1 2 3\n"), HasSubstr("need more than"));
  EXPECT_THAT(refusal(pcd + "DATA binary\n123456789012"), HasSubstr(": byte "));
  EXPECT_THAT(refusal(pcd + "DATA binary_compressed\n" + bytes_of(std::uint32_t{4}) +
                      bytes_of(std::uint32_t{4000000000u}) + "1234"),
              HasSubstr(": byte "));
  EXPECT_THAT(refusal("# vtk DataFile Version 3.0\nt\nBINARY\nDATASET POLYDATA\n"
                      "POINTS 2000000000 double\n1234"),
              HasSubstr(": byte "));
  EXPECT_THAT(refusal("# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\n"
                      "POINTS 1 float\n1 2 3\nPOLYGONS 1 2000000000\n3 0 0 0\n"),
              HasSubstr("need more than"));
}

TEST_F(CloudFile, EveryTruncationIsRefusedOrHarmless) {
  // No prefix of a good file may crash a reader or give points that the whole file does not have.
  std::vector<std::string> files;
  PointCloud cloud;
  cloud.points = two_;
  write_ply(folder_.path() / "w.ply", cloud);
  files.push_back(read_whole_file(folder_.path() / "w.ply"));
  files.push_back(
      "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\n"
      "DATA ascii\n1 2 3\n-4 5.5 0.25\n");
  files.push_back(
      "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS 2 float\n"
      "1 2 3 -4 5.5 0.25\nPOINT_DATA 2\nNORMALS n float\n0 0 1 1 0 0\n");
  for (const std::string& file : files) {
    int refused = 0;
    for (std::size_t length = 0; length < file.size(); ++length) {
      try {
        EXPECT_LE(read(file.substr(0, length)).points.size(), 2u);
      } catch (const InputError&) {
        ++refused;
      }
    }
    EXPECT_GT(refused, static_cast<int>(file.size() / 2));
  }
}

TEST_F(CloudFile, FlippedBytesNeverCrashAReader) {
  PointCloud cloud;
  Random random(31);
  for (int i = 0; i < 20; ++i) cloud.points.push_back(random.unit_vector().cast<float>());
  write_ply(folder_.path() / "w.ply", cloud);
  const std::string ply = read_whole_file(folder_.path() / "w.ply");
  std::string pcd =
      "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 8\nHEIGHT 1\n"
      "DATA binary_compressed\n";
  pcd += bytes_of(std::uint32_t{99}) + bytes_of(std::uint32_t{96});
  for (int run = 0; run < 3; ++run) pcd += '\x1f' + std::string(32, 'a');
  int refused = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    std::string text = trial % 2 == 0 ? ply : pcd;
    for (std::uint64_t flips = 1 + random.index(3); flips > 0; --flips) {
      text[random.index(text.size())] = static_cast<char>(random.index(256));
    }
    try {
      InputBytes in(text, "flipped");
      static_cast<void>(trial % 2 == 0 ? read_ply(in) : read_pcd(in));
    } catch (const InputError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 100);
}

TEST(Lzf, UnpacksRunsAndOverlappingCopies) {
  // "ab", then seven bytes copied from two back: abababab a.
  const std::string packed{'\x01', 'a', 'b', static_cast<char>(5 << 5), '\x01'};
  EXPECT_EQ(unpack_lzf(packed, 9), "ababababa");
  // The long form: 7 + 3 + 2 = 12 bytes.
  const std::string longer{'\x00', 'x', static_cast<char>(7 << 5), '\x03', '\x00'};
  EXPECT_EQ(unpack_lzf(longer, 13), std::string(13, 'x'));
}

TEST(Lzf, RefusesDamage) {
  EXPECT_EQ(unpack_lzf(std::string{'\x01', 'a'}, 2), std::nullopt);           // run cut off
  EXPECT_EQ(unpack_lzf(std::string{'\x20', '\x00'}, 3), std::nullopt);        // copy from before
  EXPECT_EQ(unpack_lzf(std::string{'\x00', 'a', '\x20'}, 4), std::nullopt);   // offset cut off
  EXPECT_EQ(unpack_lzf(std::string{'\x00', 'a', '\xe0'}, 40), std::nullopt);  // length cut off
  EXPECT_EQ(unpack_lzf(std::string{'\x01', 'a', 'b'}, 1), std::nullopt);      // too long
  EXPECT_EQ(unpack_lzf(std::string{'\x01', 'a', 'b'}, 3), std::nullopt);      // too short
  EXPECT_EQ(unpack_lzf("", std::size_t{1} << 40), std::nullopt);
}

TEST(ModelFile, FacesMakeAMeshAndTheirAbsenceACloud) {
  const TemporaryFolder folder;
  const std::string vertices =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
      "property float z\n";
  const std::string body = "0 0 0\n1 0 0\n0 1 0\n";
  const auto mesh = read_model_file(folder.write(
      "a.ply", vertices + "element face 1\nproperty list uchar int vertex_indices\nend_header\n" +
                   body + "3 0 1 2\n"));
  ASSERT_TRUE(std::holds_alternative<TriangleMesh>(mesh));
  EXPECT_EQ(std::get<TriangleMesh>(mesh).triangles.size(), 1u);
  EXPECT_TRUE(std::holds_alternative<PointCloud>(
      read_model_file(folder.write("b.ply", vertices + "end_header\n" + body))));
  EXPECT_TRUE(std::holds_alternative<TriangleMesh>(
      read_model_file(folder.write("c.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"))));
  const auto strip = read_model_file(
      folder.write("d.vtk",
                   "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS 4 float\n"
                   "0 0 0 1 0 0 0 1 0 1 1 0\nTRIANGLE_STRIPS 1 5\n4 0 1 2 3\n"));
  ASSERT_TRUE(std::holds_alternative<TriangleMesh>(strip));
  // Both triangles of the strip face the same way.
  const TriangleMesh& surface = std::get<TriangleMesh>(strip);
  ASSERT_EQ(surface.triangles.size(), 2u);
  for (const auto& t : surface.triangles) {
    const auto corner = [&](std::size_t k) { return surface.vertices[std::size_t(t[k])]; };
    EXPECT_GT((corner(1) - corner(0)).cross(corner(2) - corner(0)).z(), 0.0);
  }
  EXPECT_THROW(static_cast<void>(read_model_file(folder.write("e.ply", vertices))), InputError);
  EXPECT_THROW(static_cast<void>(read_model_file(folder.path() / "absent.pcd")), InputError);
}

}  // namespace
}  // namespace binpick
