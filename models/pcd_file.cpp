#include "models/pcd_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "models/lzf.h"
#include "models/scalar_type.h"

namespace binpick {
namespace {

constexpr std::size_t kLongestHeaderLine = 1u << 16;
constexpr std::size_t kMostUnpackedBytes = std::size_t{256} << 20;

struct Field {
  std::string name;
  ScalarType type;
  std::size_t count = 1;        ///< values per point
  std::size_t offset = 0;       ///< bytes before it in a point
  std::size_t first_value = 0;  ///< values before it in a point
};

struct Header {
  std::vector<Field> fields;
  std::size_t point_size = 0;    ///< bytes
  std::size_t point_values = 0;  ///< numbers
  std::size_t points = 0;
  std::size_t width = 0;
  std::size_t height = 0;
  std::string encoding;
};

/// A header line: where its words stand.
struct Line {
  std::size_t offset = 0;
  std::vector<std::pair<std::size_t, std::string>> words;  ///< offset and text, key left out
};

using Lines = std::map<std::string, Line>;

Lines read_lines(InputBytes& in) {
  static const std::vector<std::string> kKeys{"VERSION", "FIELDS", "SIZE",      "TYPE",   "COUNT",
                                              "WIDTH",   "HEIGHT", "VIEWPOINT", "POINTS", "DATA"};
  Lines lines;
  while (!lines.contains("DATA")) {
    if (in.remaining() == 0) in.fail_text(in.position(), "the header ends without a line DATA");
    const std::size_t begin = in.position();
    const std::string_view text = in.line();
    if (text.size() > kLongestHeaderLine) in.fail_text(begin, "too long for a PCD header");
    InputBytes words(text, in.name());
    const std::string key(words.word());
    if (key.empty() || key.starts_with('#')) continue;
    if (std::find(kKeys.begin(), kKeys.end(), key) == kKeys.end()) {
      in.fail_text(begin, "not a line of a PCD header");
    }
    if (lines.contains(key)) in.fail_text(begin, fmt::format("a second line {}", key));
    Line& line = lines[key];
    line.offset = begin;
    for (std::string word(words.word()); !word.empty(); word = words.word()) {
      line.words.emplace_back(begin + words.position() - word.size(), word);
    }
  }
  return lines;
}

class HeaderParser {
 public:
  explicit HeaderParser(InputBytes& in) : in_(in), lines_(read_lines(in)) {}

  [[nodiscard]] Header parse() const {
    Header header;
    parse_fields(header);
    header.width = single("WIDTH");
    header.height = single("HEIGHT");
    header.points = lines_.contains("POINTS") ? single("POINTS") : header.width * header.height;
    if (header.width * header.height != header.points) {
      in_.fail_text(line("WIDTH").offset, fmt::format("WIDTH x HEIGHT is {} but POINTS is {}",
                                                      header.width * header.height, header.points));
    }
    const Line& data = line("DATA");
    header.encoding = data.words.size() == 1 ? data.words[0].second : "";
    if (header.encoding != "ascii" && header.encoding != "binary" &&
        header.encoding != "binary_compressed") {
      in_.fail_text(data.offset, "DATA must be ascii, binary or binary_compressed");
    }
    return header;
  }

  [[nodiscard]] const Line& line(const std::string& key) const {
    const auto found = lines_.find(key);
    if (found == lines_.end()) in_.fail_text(0, fmt::format("the header has no line {}", key));
    return found->second;
  }

 private:
  [[nodiscard]] std::size_t whole(const std::pair<std::size_t, std::string>& word, std::int64_t min,
                                  std::int64_t max) const {
    InputBytes text(word.second, in_.name());
    std::int64_t value = -1;
    try {
      value = text.text_integer("", min, max);
    } catch (const std::exception&) {
      in_.fail_text(word.first,
                    fmt::format("'{}' is not a whole number in [{}, {}]", word.second, min, max));
    }
    return static_cast<std::size_t>(value);
  }

  [[nodiscard]] std::size_t single(const std::string& key) const {
    const Line& found = line(key);
    if (found.words.size() != 1) in_.fail_text(found.offset, fmt::format("{} is one number", key));
    return whole(found.words[0], 0, std::numeric_limits<std::int32_t>::max());
  }

  void parse_fields(Header& header) const {
    const Line& names = line("FIELDS");
    const Line& sizes = line("SIZE");
    const Line& types = line("TYPE");
    const Line* counts = lines_.contains("COUNT") ? &line("COUNT") : nullptr;
    for (const Line* other : {&sizes, &types, counts}) {
      if (other != nullptr && other->words.size() != names.words.size()) {
        in_.fail_text(other->offset, fmt::format("{} entries for {} FIELDS", other->words.size(),
                                                 names.words.size()));
      }
    }
    for (std::size_t i = 0; i < names.words.size(); ++i) {
      Field field;
      field.name = names.words[i].second;
      field.offset = header.point_size;
      field.first_value = header.point_values;
      field.type.size = whole(sizes.words[i], 1, 8);
      if (counts != nullptr) field.count = whole(counts->words[i], 1, 1 << 20);
      parse_type(types.words[i], field.type);
      header.point_size += field.type.size * field.count;
      header.point_values += field.count;
      header.fields.push_back(std::move(field));
    }
    if (header.fields.empty()) in_.fail_text(names.offset, "FIELDS names no field");
  }

  void parse_type(const std::pair<std::size_t, std::string>& word, ScalarType& type) const {
    const std::string& name = word.second;
    if (name == "F" && (type.size == 4 || type.size == 8)) {
      type.kind = ScalarType::Kind::kFloat;
    } else if (name == "I" && std::has_single_bit(type.size)) {
      type.kind = ScalarType::Kind::kSigned;
    } else if (name == "U" && std::has_single_bit(type.size)) {
      type.kind = ScalarType::Kind::kUnsigned;
    } else {
      in_.fail_text(word.first, fmt::format("no TYPE '{}' of SIZE {}", name, type.size));
    }
  }

  InputBytes& in_;
  Lines lines_;
};

/// The fields that make up points and normals.
struct Columns {
  std::array<const Field*, 3> position{};
  std::array<const Field*, 3> normal{};

  [[nodiscard]] bool with_normals() const {
    return normal[0] != nullptr && normal[1] != nullptr && normal[2] != nullptr;
  }
};

Columns find_columns(const InputBytes& in, const Header& header, std::size_t fields_offset) {
  const auto find = [&](std::string_view name) -> const Field* {
    const Field* found = nullptr;
    for (const Field& field : header.fields) {
      if (field.name != name) continue;
      if (found != nullptr || field.count != 1 || field.type.kind != ScalarType::Kind::kFloat) {
        in.fail_text(fields_offset,
                     fmt::format("field '{}' must be there once, with TYPE F and COUNT 1", name));
      }
      found = &field;
    }
    return found;
  };
  Columns columns{{find("x"), find("y"), find("z")},
                  {find("normal_x"), find("normal_y"), find("normal_z")}};
  for (const Field* field : columns.position) {
    if (field == nullptr) in.fail_text(fields_offset, "FIELDS must name x, y and z");
  }
  return columns;
}

void read_ascii(InputBytes& in, const Header& header, const Columns& columns, SurfaceData& data) {
  // Every value takes a digit and a separator; the last needs no separator.
  if (header.points > (in.remaining() + 1) / (2 * header.point_values)) {
    in.fail_text(in.position(), fmt::format("{} points of {} values need more than the {} bytes "
                                            "that follow; the file is truncated",
                                            header.points, header.point_values, in.remaining()));
  }
  if (header.points == 0) return;
  std::vector<double> row(header.point_values);
  const auto triple = [&row](const std::array<const Field*, 3>& fields) {
    return Eigen::Vector3f(Eigen::Vector3d(row[fields[0]->first_value], row[fields[1]->first_value],
                                           row[fields[2]->first_value])
                               .cast<float>());
  };
  data.points.reserve(header.points);
  if (columns.with_normals()) data.normals.reserve(header.points);
  for (std::size_t i = 0; i < header.points; ++i) {
    for (double& number : row) number = in.text_number("a point's value");
    data.points.push_back(triple(columns.position));
    if (columns.with_normals()) data.normals.push_back(triple(columns.normal));
  }
}

enum class Layout { kPointByPoint, kFieldByField };

void read_packed(std::string_view bytes, Layout layout, const Header& header,
                 const Columns& columns, SurfaceData& data) {
  const auto triples = [&](const std::array<const Field*, 3>& fields) {
    std::array<PackedColumn, 3> packed;
    for (std::size_t k = 0; k < 3; ++k) {
      const Field& field = *fields[k];
      packed[k] = layout == Layout::kFieldByField
                      ? PackedColumn{field.offset * header.points, field.type.size, field.type}
                      : PackedColumn{field.offset, header.point_size, field.type};
    }
    return read_triples(bytes, packed, header.points, std::endian::little);
  };
  data.points = triples(columns.position);
  if (columns.with_normals()) data.normals = triples(columns.normal);
}

void read_binary(InputBytes& in, const Header& header, const Columns& columns, SurfaceData& data) {
  if (header.points > in.remaining() / header.point_size) {
    in.fail_binary(in.position(), fmt::format("{} points of {} bytes need more than the {} bytes "
                                              "that follow; the file is truncated",
                                              header.points, header.point_size, in.remaining()));
  }
  read_packed(in.take(header.points * header.point_size, "the points"), Layout::kPointByPoint,
              header, columns, data);
}

void read_compressed(InputBytes& in, const Header& header, const Columns& columns,
                     SurfaceData& data) {
  const std::size_t begin = in.position();
  const ScalarType size_type{ScalarType::Kind::kUnsigned, 4};
  const auto size = [&](std::string_view what) {
    return static_cast<std::size_t>(
        read_scalar(in.take(4, what).data(), size_type, std::endian::little));
  };
  const std::size_t packed_size = size("the compressed size");
  const std::size_t plain_size = size("the uncompressed size");
  // Divided, as the product of two numbers that the file chose may overflow.
  if (plain_size / header.point_size != header.points || plain_size % header.point_size != 0) {
    in.fail_binary(
        begin, fmt::format("the data unpack to {} bytes but the header promises {} points of {}",
                           plain_size, header.points, header.point_size));
  }
  if (plain_size > kMostUnpackedBytes) {
    in.fail_binary(begin, fmt::format("the data unpack to more than {} MB; write the cloud with "
                                      "DATA binary",
                                      kMostUnpackedBytes >> 20));
  }
  const std::size_t packed_begin = in.position();
  const std::optional<std::string> plain =
      unpack_lzf(in.take(packed_size, "the compressed points"), plain_size);
  if (!plain) in.fail_binary(packed_begin, "the compressed points are damaged; fetch them again");
  read_packed(*plain, Layout::kFieldByField, header, columns, data);
}

}  // namespace

SurfaceData read_pcd(InputBytes& in) {
  const HeaderParser parser(in);
  const Header header = parser.parse();
  const Columns columns = find_columns(in, header, parser.line("FIELDS").offset);
  SurfaceData data;
  data.width = static_cast<int>(header.width);
  data.height = static_cast<int>(header.height);
  if (header.encoding == "ascii") {
    read_ascii(in, header, columns, data);
  } else if (header.encoding == "binary") {
    read_binary(in, header, columns, data);
  } else {
    read_compressed(in, header, columns, data);
  }
  return data;
}

}  // namespace binpick
