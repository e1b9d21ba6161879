#include "models/pcd_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "models/lzf.h"

namespace binpick {
namespace {

struct Field {
  std::string name;
  ScalarType type;
  std::size_t count = 1;   ///< values per point
  std::size_t offset = 0;  ///< bytes before it in a point
};

struct Header {
  std::vector<Field> fields;
  std::size_t point_size = 0;
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
    InputBytes words(std::string(in.line()), in.name());
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
      field.type.size = whole(sizes.words[i], 1, 8);
      if (counts != nullptr) field.count = whole(counts->words[i], 1, 1 << 20);
      parse_type(types.words[i], field.type);
      header.point_size += field.type.size * field.count;
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

/// Calls `value(field, i)` for every number of every point.
template <class Value>
void fill(const Header& header, const Columns& columns, SurfaceData& data, const Value& value) {
  data.points.reserve(header.points);
  if (columns.with_normals()) data.normals.reserve(header.points);
  for (std::size_t i = 0; i < header.points; ++i) {
    const auto triple = [&](const std::array<const Field*, 3>& fields) {
      return Eigen::Vector3d(value(*fields[0], i), value(*fields[1], i), value(*fields[2], i));
    };
    data.points.push_back(triple(columns.position));
    if (columns.with_normals()) data.normals.push_back(triple(columns.normal));
  }
}

void read_ascii(InputBytes& in, const Header& header, const Columns& columns, SurfaceData& data) {
  std::size_t values = 0;
  std::map<const Field*, std::size_t> first_value;
  for (const Field& field : header.fields) {
    first_value[&field] = values;
    values += field.count;
  }
  if (header.points > (in.remaining() + 1) / (2 * values)) {
    in.fail_text(in.position(), fmt::format("{} points of {} values need more than the {} bytes "
                                            "that follow; the file is truncated",
                                            header.points, values, in.remaining()));
  }
  std::vector<double> row(values);
  std::size_t row_read = std::numeric_limits<std::size_t>::max();
  fill(header, columns, data, [&](const Field& field, std::size_t i) {
    if (i != row_read) {
      for (double& number : row) number = in.text_number("a point's value");
      row_read = i;
    }
    return row[first_value.at(&field)];
  });
}

/// `plane_stride` says where a field's values lie: point by point, or field by field.
void read_packed(std::string_view bytes, bool field_by_field, const Header& header,
                 const Columns& columns, SurfaceData& data) {
  fill(header, columns, data, [&](const Field& field, std::size_t i) {
    const std::size_t at = field_by_field ? field.offset * header.points + i * field.type.size
                                          : i * header.point_size + field.offset;
    return read_scalar(bytes.data() + at, field.type, std::endian::little);
  });
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
  if (plain_size != header.points * header.point_size) {
    in.fail_binary(begin, fmt::format("the data unpack to {} bytes but the header promises {}",
                                      plain_size, header.points * header.point_size));
  }
  const std::size_t packed_begin = in.position();
  const std::optional<std::string> plain =
      unpack_lzf(in.take(packed_size, "the compressed points"), plain_size);
  if (!plain) in.fail_binary(packed_begin, "the compressed points are damaged; fetch them again");
  read_packed(*plain, true, header, columns, data);
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
    read_packed(in.take(header.points * header.point_size, "the points"), false, header, columns,
                data);
  } else {
    read_compressed(in, header, columns, data);
  }
  return data;
}

}  // namespace binpick
