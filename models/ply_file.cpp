#include "models/ply_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>

#include "models/scalar_type.h"

namespace binpick {
namespace {

constexpr std::size_t kMostProperties = 1000;  // of all elements together
constexpr std::size_t kMostTriangles = 10'000'000;

struct Property {
  std::string name;
  ScalarType type;
  bool is_list = false;
  ScalarType count_type;
};

struct Element {
  std::string name;
  std::size_t count = 0;
  std::size_t offset = 0;  ///< of its header line
  std::vector<Property> properties;
};

enum class Encoding { kAscii, kLittleEndian, kBigEndian };

struct Header {
  Encoding encoding = Encoding::kAscii;
  std::vector<Element> elements;
};

ScalarType parse_type(const InputBytes& in, std::string_view word) {
  using Kind = ScalarType::Kind;
  static const std::map<std::string_view, ScalarType> kTypes{
      {"char", {Kind::kSigned, 1}},     {"int8", {Kind::kSigned, 1}},
      {"uchar", {Kind::kUnsigned, 1}},  {"uint8", {Kind::kUnsigned, 1}},
      {"short", {Kind::kSigned, 2}},    {"int16", {Kind::kSigned, 2}},
      {"ushort", {Kind::kUnsigned, 2}}, {"uint16", {Kind::kUnsigned, 2}},
      {"int", {Kind::kSigned, 4}},      {"int32", {Kind::kSigned, 4}},
      {"uint", {Kind::kUnsigned, 4}},   {"uint32", {Kind::kUnsigned, 4}},
      {"float", {Kind::kFloat, 4}},     {"float32", {Kind::kFloat, 4}},
      {"double", {Kind::kFloat, 8}},    {"float64", {Kind::kFloat, 8}}};
  const auto found = kTypes.find(word);
  if (found == kTypes.end()) {
    in.fail_text(in.position() - word.size(), fmt::format("unknown PLY type '{}'", word));
  }
  return found->second;
}

Property parse_property(InputBytes& in) {
  Property property;
  std::string_view type = in.word();
  if (type == "list") {
    property.is_list = true;
    property.count_type = parse_type(in, in.word());
    if (property.count_type.kind == ScalarType::Kind::kFloat) {
      in.fail_text(in.position(), "a list's length must be of a whole-number type");
    }
    type = in.word();
  }
  property.type = parse_type(in, type);
  property.name = in.word();
  return property;
}

/// Elements must fit into what is left of the file, or memory would be reserved for nothing.
void check_counts(const InputBytes& in, const Header& header) {
  double least = 0.0;
  for (const Element& element : header.elements) {
    if (element.properties.empty()) {
      in.fail_text(element.offset, fmt::format("element '{}' has no properties", element.name));
    }
    double row = 0.0;
    for (const Property& property : element.properties) {
      const std::size_t binary = property.is_list ? property.count_type.size : property.type.size;
      row += header.encoding == Encoding::kAscii ? 2.0 : static_cast<double>(binary);
    }
    least += row * static_cast<double>(element.count);
    // The last number of an ASCII file needs no white space behind it.
    if (least > static_cast<double>(in.remaining()) + 1.0) {
      in.fail_text(element.offset,
                   fmt::format("{} elements '{}' need more than the {} bytes that follow; the file "
                               "is truncated or its header wrong",
                               element.count, element.name, in.remaining()));
    }
  }
}

Header parse_header(InputBytes& in) {
  if (in.line() != "ply") in.fail_text(0, "a PLY file must begin with the line 'ply'");
  Header header;
  bool has_format = false;
  std::size_t properties = 0;
  while (true) {
    const std::string_view keyword = in.word();
    const std::size_t offset = in.position() - keyword.size();
    if (keyword == "end_header") break;
    if (keyword == "comment" || keyword == "obj_info") {
      in.line();
      continue;
    }
    if (keyword == "format") {
      const std::string_view format = in.word();
      if (format == "ascii") {
        header.encoding = Encoding::kAscii;
      } else if (format == "binary_little_endian") {
        header.encoding = Encoding::kLittleEndian;
      } else if (format == "binary_big_endian") {
        header.encoding = Encoding::kBigEndian;
      } else {
        in.fail_text(offset, "the format must be ascii, binary_little_endian or binary_big_endian");
      }
      if (in.word() != "1.0") in.fail_text(offset, "the format's version must be 1.0");
      has_format = true;
    } else if (keyword == "element") {
      Element element;
      element.name = in.word();
      element.offset = offset;
      element.count = static_cast<std::size_t>(
          in.text_integer("the number of elements", 0, std::numeric_limits<std::int32_t>::max()));
      header.elements.push_back(std::move(element));
      if (header.elements.size() > kMostProperties) in.fail_text(offset, "too many elements");
    } else if (keyword == "property" && !header.elements.empty()) {
      header.elements.back().properties.push_back(parse_property(in));
      if (++properties > kMostProperties) in.fail_text(offset, "too many properties");
    } else {
      in.fail_text(offset, keyword.empty() ? "the file ends within its header"
                                           : "not a line of a PLY header");
    }
  }
  in.line();
  if (!has_format) in.fail_text(0, "the header names no format");
  check_counts(in, header);
  return header;
}

/// Numbers one after the other, in whichever encoding.
class NumberSource {
 public:
  NumberSource(InputBytes& in, Encoding encoding) : in_(in), encoding_(encoding) {}

  double next(ScalarType type, std::string_view what) {
    if (encoding_ == Encoding::kAscii) return in_.text_number(what);
    return read_scalar(in_.take(type.size, what).data(), type, order());
  }

  /// A whole number in [0, limit).
  std::size_t next_index(ScalarType type, std::string_view what, std::size_t limit) {
    const std::size_t offset = in_.position();
    const double value = next(type, what);
    if (!(value >= 0.0 && value < static_cast<double>(limit)) || value != std::floor(value)) {
      fail(offset, fmt::format("{} is {}, not a whole number in [0, {})", what, value, limit));
    }
    return static_cast<std::size_t>(value);
  }

  [[noreturn]] void fail(std::size_t offset, std::string_view message) const {
    if (encoding_ == Encoding::kAscii) in_.fail_text(offset, message);
    in_.fail_binary(offset, message);
  }

  [[nodiscard]] std::size_t position() const { return in_.position(); }
  [[nodiscard]] std::size_t remaining() const { return in_.remaining(); }
  [[nodiscard]] std::endian order() const {
    return encoding_ == Encoding::kBigEndian ? std::endian::big : std::endian::little;
  }

 private:
  InputBytes& in_;
  Encoding encoding_;
};

std::size_t read_length(NumberSource& numbers, const Property& property) {
  return numbers.next_index(property.count_type, "a list's length", numbers.remaining() + 1);
}

void skip_list(NumberSource& numbers, const Property& property) {
  for (std::size_t left = read_length(numbers, property); left > 0; --left) {
    static_cast<void>(numbers.next(property.type, "a list's item"));
  }
}

/// Reads a polygon's corners and adds it as a fan of triangles.
void read_polygon(NumberSource& numbers, const Property& property, std::size_t vertices,
                  SurfaceData& data) {
  const std::size_t begin = numbers.position();
  const std::size_t length = read_length(numbers, property);
  std::int32_t first = 0;
  std::int32_t previous = 0;
  for (std::size_t k = 0; k < length; ++k) {
    const auto corner =
        static_cast<std::int32_t>(numbers.next_index(property.type, "a vertex index", vertices));
    if (k == 0) first = corner;
    if (k >= 2) data.triangles.push_back({first, previous, corner});
    previous = corner;
    if (data.triangles.size() > kMostTriangles) {
      numbers.fail(begin, fmt::format("more than {} triangles; simplify the mesh", kMostTriangles));
    }
  }
}

/// Where the coordinates and normals stand among a vertex's properties.
struct VertexLayout {
  std::array<std::size_t, 3> position{};
  std::array<std::size_t, 3> normal{};
  bool with_normals = false;
};

VertexLayout find_layout(const InputBytes& in, const Element& element) {
  const std::size_t none = element.properties.size();
  const auto column = [&](std::string_view name) {
    const auto found =
        std::find_if(element.properties.begin(), element.properties.end(),
                     [&](const Property& p) { return p.name == name && !p.is_list; });
    return static_cast<std::size_t>(found - element.properties.begin());
  };
  VertexLayout layout{{column("x"), column("y"), column("z")},
                      {column("nx"), column("ny"), column("nz")}};
  if (std::find(layout.position.begin(), layout.position.end(), none) != layout.position.end()) {
    in.fail_text(element.offset, "vertices need the properties x, y and z");
  }
  layout.with_normals =
      std::find(layout.normal.begin(), layout.normal.end(), none) == layout.normal.end();
  return layout;
}

/// Vertices one number after the other, for text and for rows of varying length.
void read_vertex_rows(NumberSource& numbers, const Element& element, const VertexLayout& layout,
                      SurfaceData& data) {
  std::vector<double> row(element.properties.size());
  const auto triple = [&row](const std::array<std::size_t, 3>& at) {
    return Eigen::Vector3f(Eigen::Vector3d(row[at[0]], row[at[1]], row[at[2]]).cast<float>());
  };
  data.points.reserve(element.count);
  if (layout.with_normals) data.normals.reserve(element.count);
  for (std::size_t i = 0; i < element.count; ++i) {
    for (std::size_t k = 0; k < row.size(); ++k) {
      const Property& property = element.properties[k];
      if (property.is_list) {
        skip_list(numbers, property);
      } else {
        row[k] = numbers.next(property.type, "a vertex property");
      }
    }
    data.points.push_back(triple(layout.position));
    if (layout.with_normals) data.normals.push_back(triple(layout.normal));
  }
}

void read_vertices(InputBytes& in, Encoding encoding, const Element& element, SurfaceData& data) {
  const VertexLayout layout = find_layout(in, element);
  NumberSource numbers(in, encoding);
  const bool has_list = std::any_of(element.properties.begin(), element.properties.end(),
                                    [](const Property& p) { return p.is_list; });
  if (encoding == Encoding::kAscii || has_list) {
    read_vertex_rows(numbers, element, layout, data);
    return;
  }
  std::vector<std::size_t> offsets;
  std::size_t row_size = 0;
  for (const Property& property : element.properties) {
    offsets.push_back(row_size);
    row_size += property.type.size;
  }
  // check_counts saw to it that the product is no larger than the file.
  const std::string_view bytes = in.take(element.count * row_size, "the vertices");
  const auto triples = [&](const std::array<std::size_t, 3>& at) {
    std::array<PackedColumn, 3> columns;
    for (std::size_t k = 0; k < 3; ++k) {
      columns[k] = {offsets[at[k]], row_size, element.properties[at[k]].type};
    }
    return read_triples(bytes, columns, element.count, numbers.order());
  };
  data.points = triples(layout.position);
  if (layout.with_normals) data.normals = triples(layout.normal);
}

void read_faces(NumberSource& numbers, const Element& element, std::size_t vertices,
                SurfaceData& data) {
  for (std::size_t i = 0; i < element.count; ++i) {
    for (const Property& property : element.properties) {
      if (!property.is_list) {
        static_cast<void>(numbers.next(property.type, "a face property"));
        continue;
      }
      if (property.name == "vertex_indices" || property.name == "vertex_index") {
        read_polygon(numbers, property, vertices, data);
      } else {
        skip_list(numbers, property);
      }
    }
  }
}

void skip_element(NumberSource& numbers, const Element& element) {
  for (std::size_t i = 0; i < element.count; ++i) {
    for (const Property& property : element.properties) {
      if (property.is_list) {
        skip_list(numbers, property);
      } else {
        static_cast<void>(numbers.next(property.type, "a property"));
      }
    }
  }
}

}  // namespace

SurfaceData read_ply(InputBytes& in) {
  const Header header = parse_header(in);
  std::size_t vertices = 0;
  bool has_vertices = false;
  for (const Element& element : header.elements) {
    if (element.name != "vertex") continue;
    if (has_vertices) in.fail_text(element.offset, "a second element 'vertex'; keep one");
    has_vertices = true;
    vertices = element.count;
  }
  if (!has_vertices) in.fail_text(0, "the PLY file has no element 'vertex'");

  SurfaceData data;
  NumberSource numbers(in, header.encoding);
  for (const Element& element : header.elements) {
    if (element.name == "vertex") {
      read_vertices(in, header.encoding, element, data);
    } else if (element.name == "face") {
      read_faces(numbers, element, vertices, data);
    } else {
      skip_element(numbers, element);
    }
  }
  data.width = static_cast<int>(vertices);
  data.height = vertices > 0 ? 1 : 0;
  return data;
}

}  // namespace binpick
