#include "models/vtk_file.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <map>

#include "models/scalar_type.h"

namespace binpick {
namespace {

constexpr std::int64_t kMaxCount = std::numeric_limits<std::int32_t>::max();

class VtkReader {
 public:
  explicit VtkReader(InputBytes& in) : in_(in) {}

  SurfaceData read() {
    read_header();
    while (true) {
      const std::string section(in_.word());
      if (section.empty()) break;
      read_section(section, in_.position() - section.size());
    }
    if (!has_points_) in_.fail_text(in_.position(), "the file has no POINTS");
    data_.width = static_cast<int>(data_.points.size());
    data_.height = data_.points.empty() ? 0 : 1;
    return std::move(data_);
  }

 private:
  void read_header() {
    if (!in_.line().starts_with("# vtk DataFile Version")) {
      in_.fail_text(0, "a legacy VTK file must begin with '# vtk DataFile Version'");
    }
    in_.line();  // the title
    const std::size_t offset = in_.position();
    const std::string_view encoding = in_.word();
    if (encoding != "ASCII" && encoding != "BINARY") {
      in_.fail_text(offset, "the third line must be ASCII or BINARY");
    }
    binary_ = encoding == "BINARY";
    if (in_.word() != "DATASET" || in_.word() != "POLYDATA") {
      in_.fail_text(in_.position(), "only 'DATASET POLYDATA' is read; convert the data");
    }
  }

  void read_section(const std::string& section, std::size_t offset) {
    if (section == "POINTS") {
      if (has_points_) in_.fail_text(offset, "a second section POINTS");
      has_points_ = true;
      const std::size_t count = read_count("the number of points");
      data_.points = read_vectors(count, read_type(), "a coordinate");
    } else if (section == "VERTICES" || section == "LINES" || section == "POLYGONS" ||
               section == "TRIANGLE_STRIPS") {
      read_cells(section);
    } else if (section == "POINT_DATA" || section == "CELL_DATA") {
      at_points_ = section == "POINT_DATA";
      attribute_count_ = read_count("the number of attribute values");
      if (at_points_ && attribute_count_ != data_.points.size()) {
        in_.fail_text(offset, fmt::format("POINT_DATA for {} points, but there are {}",
                                          attribute_count_, data_.points.size()));
      }
    } else if (section == "METADATA") {
      in_.line();  // the keyword's own
      while (in_.remaining() > 0 && !in_.line().empty()) {
      }
    } else if (!read_attribute(section)) {
      in_.fail_text(offset, "not a section of a legacy VTK polydata file");
    }
  }

  /// SCALARS, NORMALS and their like. False when `section` is none of them.
  bool read_attribute(const std::string& section) {
    if (section == "NORMALS") {
      in_.word();  // its name
      std::vector<Eigen::Vector3f> normals =
          read_vectors(attribute_count_, read_type(), "a normal");
      if (at_points_) data_.normals = std::move(normals);
    } else if (section == "VECTORS") {
      in_.word();
      skip_numbers(attribute_count_, 3, read_type());
    } else if (section == "TENSORS") {
      in_.word();
      skip_numbers(attribute_count_, 9, read_type());
    } else if (section == "TEXTURE_COORDINATES") {
      in_.word();
      const std::size_t dimension = read_count("the texture's dimension");
      skip_numbers(attribute_count_, dimension, read_type());
    } else if (section == "SCALARS") {
      in_.word();
      scalar_type_ = read_type();
      // The number of components may follow on the same line.
      InputBytes rest(in_.line(), in_.name());
      scalar_components_ =
          rest.rest().find_first_not_of(" \t") == std::string_view::npos
              ? 1
              : static_cast<std::size_t>(rest.text_integer("the number of components", 1, 4));
      expect_table_ = true;
    } else if (section == "LOOKUP_TABLE") {
      in_.word();
      if (expect_table_) {
        skip_numbers(attribute_count_, scalar_components_, scalar_type_);
        expect_table_ = false;
      } else {
        const std::size_t entries = read_count("the table's size");
        skip_numbers(entries, 4, {ScalarType::Kind::kUnsigned, 1});
      }
    } else if (section == "COLOR_SCALARS") {
      in_.word();
      const std::size_t components = read_count("the number of components");
      skip_numbers(attribute_count_, components, {ScalarType::Kind::kUnsigned, 1});
    } else if (section == "FIELD") {
      in_.word();
      const std::size_t arrays = read_count("the number of arrays");
      for (std::size_t i = 0; i < arrays; ++i) {
        in_.word();
        const std::size_t components = read_count("the number of components");
        const std::size_t tuples = read_count("the number of tuples");
        skip_numbers(tuples, components, read_type());
      }
    } else {
      return false;
    }
    return true;
  }

  std::size_t read_count(std::string_view what) {
    return static_cast<std::size_t>(in_.text_integer(what, 0, kMaxCount));
  }

  ScalarType read_type() {
    using Kind = ScalarType::Kind;
    static const std::map<std::string_view, ScalarType> kTypes{
        {"float", {Kind::kFloat, 4}},         {"double", {Kind::kFloat, 8}},
        {"char", {Kind::kSigned, 1}},         {"unsigned_char", {Kind::kUnsigned, 1}},
        {"short", {Kind::kSigned, 2}},        {"unsigned_short", {Kind::kUnsigned, 2}},
        {"int", {Kind::kSigned, 4}},          {"unsigned_int", {Kind::kUnsigned, 4}},
        {"long", {Kind::kSigned, 8}},         {"unsigned_long", {Kind::kUnsigned, 8}},
        {"vtktypeint64", {Kind::kSigned, 8}}, {"vtktypeint32", {Kind::kSigned, 4}},
        {"vtkIdType", {Kind::kSigned, 8}}};
    const std::string_view name = in_.word();
    const auto found = kTypes.find(name);
    if (found == kTypes.end()) {
      in_.fail_text(in_.position() - name.size(), fmt::format("unknown VTK type '{}'", name));
    }
    return found->second;
  }

  /// Refuses numbers that the rest of the file cannot hold; ends the line before binary data.
  void begin_numbers(std::size_t count, std::size_t components, ScalarType type) {
    if (binary_) in_.line();
    const double least = static_cast<double>(count) * static_cast<double>(components) *
                         (binary_ ? static_cast<double>(type.size) : 2.0);
    if (least > static_cast<double>(in_.remaining()) + 1.0) {
      const std::string message = fmt::format(
          "{} x {} numbers need more than the {} bytes that follow; the file is "
          "truncated or its header wrong",
          count, components, in_.remaining());
      if (binary_) in_.fail_binary(in_.position(), message);
      in_.fail_text(in_.position(), message);
    }
  }

  double next(ScalarType type, std::string_view what) {
    if (!binary_) return in_.text_number(what);
    return read_scalar(in_.take(type.size, what).data(), type, std::endian::big);
  }

  std::vector<Eigen::Vector3f> read_vectors(std::size_t count, ScalarType type,
                                            std::string_view what) {
    begin_numbers(count, 3, type);
    if (binary_) {
      const std::size_t stride = 3 * type.size;
      return read_triples(
          in_.take(count * stride, what),
          {PackedColumn{0, stride, type}, {type.size, stride, type}, {2 * type.size, stride, type}},
          count, std::endian::big);
    }
    std::vector<Eigen::Vector3f> vectors(count);
    for (Eigen::Vector3f& vector : vectors) {
      for (float& number : vector) number = static_cast<float>(in_.text_number(what));
    }
    return vectors;
  }

  void skip_numbers(std::size_t count, std::size_t components, ScalarType type) {
    begin_numbers(count, components, type);
    if (binary_) {
      in_.take(count * components * type.size, "data");
    } else {
      for (std::size_t i = 0; i < count * components; ++i) {
        static_cast<void>(in_.text_number("a number"));
      }
    }
  }

  std::int64_t next_whole(ScalarType type, std::string_view what, std::int64_t limit) {
    const std::size_t offset = in_.position();
    const double value = next(type, what);
    if (!(value >= 0.0 && value < static_cast<double>(limit)) || value != std::floor(value)) {
      const std::string message =
          fmt::format("{} is {}, not a whole number in [0, {})", what, value, limit);
      if (binary_) in_.fail_binary(offset, message);
      in_.fail_text(offset, message);
    }
    return static_cast<std::int64_t>(value);
  }

  /// Cells as (length, indices...) in files before version 5, as offsets and indices since.
  void read_cells(const std::string& section) {
    const std::size_t first = read_count("the number of cells");
    const std::size_t second = read_count("the size of the cells");
    const std::size_t before = in_.position();
    if (in_.word() == "OFFSETS") {
      read_offset_cells(section, first, second);
      return;
    }
    in_.seek(before);
    const ScalarType type{ScalarType::Kind::kSigned, 4};
    begin_numbers(second, 1, type);
    std::size_t left = second;
    std::vector<std::int32_t> corners;
    for (std::size_t i = 0; i < first; ++i) {
      const auto length = static_cast<std::size_t>(
          next_whole(type, "a cell's length", static_cast<std::int64_t>(left)));
      corners.clear();
      for (std::size_t k = 0; k < length; ++k) corners.push_back(next_corner(type));
      left -= length + 1;
      add_cell(section, corners);
    }
  }

  void read_offset_cells(const std::string& section, std::size_t offsets, std::size_t indices) {
    const ScalarType offset_type = read_type();
    begin_numbers(offsets, 1, offset_type);
    std::vector<std::size_t> begin(offsets);
    for (std::size_t& value : begin) {
      value = static_cast<std::size_t>(
          next_whole(offset_type, "a cell's offset", static_cast<std::int64_t>(indices) + 1));
    }
    if (in_.word() != "CONNECTIVITY") {
      in_.fail_text(in_.position(), "OFFSETS must be followed by CONNECTIVITY");
    }
    const ScalarType index_type = read_type();
    begin_numbers(indices, 1, index_type);
    std::vector<std::int32_t> all(indices);
    for (std::int32_t& corner : all) corner = next_corner(index_type);
    for (std::size_t i = 0; i + 1 < begin.size(); ++i) {
      if (begin[i] > begin[i + 1]) in_.fail_binary(in_.position(), "cell offsets must not fall");
      add_cell(section, {all.begin() + static_cast<std::ptrdiff_t>(begin[i]),
                         all.begin() + static_cast<std::ptrdiff_t>(begin[i + 1])});
    }
  }

  std::int32_t next_corner(ScalarType type) {
    return static_cast<std::int32_t>(
        next_whole(type, "a point's index", static_cast<std::int64_t>(data_.points.size())));
  }

  void add_cell(const std::string& section, const std::vector<std::int32_t>& corners) {
    for (std::size_t k = 2; k < corners.size(); ++k) {
      if (section == "POLYGONS") {
        data_.triangles.push_back({corners[0], corners[k - 1], corners[k]});
      } else if (section == "TRIANGLE_STRIPS") {
        // Every other triangle of a strip runs the other way round.
        if (k % 2 == 0) {
          data_.triangles.push_back({corners[k - 2], corners[k - 1], corners[k]});
        } else {
          data_.triangles.push_back({corners[k - 1], corners[k - 2], corners[k]});
        }
      }
    }
  }

  InputBytes& in_;
  SurfaceData data_;
  bool binary_ = false;
  bool has_points_ = false;
  bool at_points_ = false;
  bool expect_table_ = false;
  std::size_t attribute_count_ = 0;
  std::size_t scalar_components_ = 1;
  ScalarType scalar_type_;
};

}  // namespace

SurfaceData read_vtk(InputBytes& in) { return VtkReader(in).read(); }

}  // namespace binpick
