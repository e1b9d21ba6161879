#include "models/yaml_config.h"

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <optional>
#include <set>
#include <sstream>

#include "models/errors.h"

namespace binpick {
namespace {

constexpr std::size_t kMaxFileBytes = 16u << 20;

struct Problems {
  std::string file;
  std::vector<std::string> lines;

  void add(const YAML::Mark& mark, std::string_view message) {
    lines.push_back(mark.is_null() ? fmt::format("{}: {}", file, message)
                                   : fmt::format("{}:{}:{}: {}", file, mark.line + 1,
                                                 mark.column + 1, message));
  }
  void throw_if_any() const {
    if (!lines.empty()) throw InputError(fmt::format("{}", fmt::join(lines, "\n")));
  }
};

// yaml-cpp reads 010 as 8 and "no" as a number's neighbour; a configuration wants plain decimals.
std::optional<double> parse_number(const std::string& text) {
  double value = 0.0;
  const char* first = text.data() + (text.starts_with('+') ? 1 : 0);
  const auto [end, error] = std::from_chars(first, text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::optional<std::int64_t> parse_integer(const std::string& text) {
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

class YamlReader : public ConfigVisitor {
 public:
  YamlReader(const YAML::Node& node, std::string path, Problems& problems)
      : node_(node), path_(std::move(path)), problems_(problems) {
    collect_keys();
  }

  /// To be called once all fields have been visited.
  void report_unknown_keys() const {
    for (const std::string& key : keys_) {
      if (!visited_.contains(key)) {
        problems_.add(key_mark(key), fmt::format("unknown key '{}'{}", name(key), known_keys()));
      }
    }
  }

  void number(std::string_view key, double& value, const NumberSpec& spec,
              Presence presence) override {
    if (const auto node = find(key, presence)) {
      if (const auto parsed = to_number(*node, name(key), spec)) value = *parsed;
    }
  }

  void integer(std::string_view key, std::int64_t& value, std::int64_t min, std::int64_t max,
               Presence presence) override {
    const auto node = find(key, presence);
    if (!node) return;
    const auto parsed = node->IsScalar() ? parse_integer(node->Scalar()) : std::nullopt;
    if (!parsed) {
      problems_.add(node->Mark(), fmt::format("'{}' must be a whole number", name(key)));
    } else if (*parsed < min || *parsed > max) {
      problems_.add(node->Mark(),
                    fmt::format("'{}' is {}, outside [{}, {}]", name(key), *parsed, min, max));
    } else {
      value = *parsed;
    }
  }

  void boolean(std::string_view key, bool& value, Presence presence) override {
    const auto node = find(key, presence);
    if (!node) return;
    const std::string text = node->IsScalar() ? node->Scalar() : "";
    if (text == "true" || text == "on") {
      value = true;
    } else if (text == "false" || text == "off") {
      value = false;
    } else {
      problems_.add(node->Mark(),
                    fmt::format("'{}' must be true or false (or on, off)", name(key)));
    }
  }

  void text(std::string_view key, std::string& value, Presence presence) override {
    if (const auto node = find(key, presence)) {
      if (node->IsScalar()) {
        value = node->Scalar();
      } else {
        problems_.add(node->Mark(), fmt::format("'{}' must be text", name(key)));
      }
    }
  }

  void choice(std::string_view key, std::string& value, const std::vector<std::string>& choices,
              Presence presence) override {
    const auto node = find(key, presence);
    if (!node) return;
    const std::string text = node->IsScalar() ? node->Scalar() : "";
    if (std::find(choices.begin(), choices.end(), text) == choices.end()) {
      problems_.add(node->Mark(),
                    fmt::format("'{}' must be one of: {}", name(key), fmt::join(choices, ", ")));
    } else {
      value = text;
    }
  }

  void numbers(std::string_view key, std::vector<double>& values, std::size_t size,
               const NumberSpec& spec, Presence presence) override {
    const auto node = find(key, presence);
    if (!node) return;
    if (!node->IsSequence() || (size != 0 && node->size() != size)) {
      const std::string many = size == 0 ? "" : fmt::format("{} ", size);
      problems_.add(node->Mark(), fmt::format("'{}' must be a list of {}numbers", name(key), many));
      return;
    }
    std::vector<double> parsed;
    for (const YAML::Node& entry : *node) {
      if (const auto number_read = to_number(entry, name(key), spec)) {
        parsed.push_back(*number_read);
      }
    }
    if (parsed.size() == node->size()) values = std::move(parsed);
  }

  void texts(std::string_view key, std::vector<std::string>& values, Presence presence) override {
    const auto node = find(key, presence);
    if (!node) return;
    const auto is_scalar = [](const YAML::Node& entry) { return entry.IsScalar(); };
    if (!node->IsSequence() || !std::all_of(node->begin(), node->end(), is_scalar)) {
      problems_.add(node->Mark(), fmt::format("'{}' must be a list of texts", name(key)));
      return;
    }
    values.clear();
    for (const YAML::Node& entry : *node) values.push_back(entry.Scalar());
  }

  void group(std::string_view key, const Fields& fields, Presence presence) override {
    if (const auto node = find(key, presence)) read_mapping(*node, name(key), fields);
  }

  void list(std::string_view key, std::size_t /*size*/,
            const std::function<void(std::size_t)>& resize,
            const std::function<void(ConfigVisitor&, std::size_t)>& element,
            Presence presence) override {
    const auto node = find(key, presence);
    if (!node) return;
    if (!node->IsSequence()) {
      problems_.add(node->Mark(), fmt::format("'{}' must be a list", name(key)));
      return;
    }
    resize(node->size());
    for (std::size_t i = 0; i < node->size(); ++i) {
      read_mapping((*node)[i], fmt::format("{}[{}]", name(key), i),
                   [&](ConfigVisitor& visitor) { element(visitor, i); });
    }
  }

  [[nodiscard]] std::vector<std::string> keys() const override { return keys_; }
  [[nodiscard]] bool reading() const override { return true; }

  void problem(std::string_view key, std::string_view message) override {
    problems_.add(key.empty() ? node_.Mark() : value_mark(key), message);
  }

 private:
  void read_mapping(const YAML::Node& node, const std::string& path, const Fields& fields) {
    YamlReader reader(node, path, problems_);
    if (!node.IsMap()) {
      problems_.add(node.Mark(), fmt::format("'{}' must be a mapping", path));
      return;
    }
    fields(reader);
    reader.report_unknown_keys();
  }

  void collect_keys() {
    if (!node_.IsMap()) return;
    for (const auto& entry : node_) {
      if (!entry.first.IsScalar()) {
        problems_.add(entry.first.Mark(), "a key must be plain text");
        continue;
      }
      const std::string& key = entry.first.Scalar();
      if (std::find(keys_.begin(), keys_.end(), key) != keys_.end()) {
        problems_.add(entry.first.Mark(), fmt::format("key '{}' is given twice", name(key)));
      } else {
        keys_.push_back(key);
      }
    }
  }

  std::optional<YAML::Node> find(std::string_view key, Presence presence) {
    visited_.emplace(key);
    for (const auto& entry : node_) {
      if (entry.first.IsScalar() && entry.first.Scalar() == key) {
        if (!entry.second.IsNull()) return entry.second;
        problems_.add(entry.first.Mark(), fmt::format("'{}' has no value", name(key)));
        return std::nullopt;
      }
    }
    if (presence == Presence::kRequired) {
      problems_.add(node_.Mark(), fmt::format("'{}' is missing", name(key)));
    }
    return std::nullopt;
  }

  std::optional<double> to_number(const YAML::Node& node, const std::string& what,
                                  const NumberSpec& spec) {
    const auto parsed = node.IsScalar() ? parse_number(node.Scalar()) : std::nullopt;
    if (!parsed || !std::isfinite(*parsed)) {
      problems_.add(node.Mark(), fmt::format("'{}' must be a finite number", what));
      return std::nullopt;
    }
    if (*parsed < spec.min || *parsed > spec.max) {
      problems_.add(node.Mark(),
                    fmt::format("'{}' is {}, outside [{}, {}]", what, *parsed, spec.min, spec.max));
      return std::nullopt;
    }
    return *parsed * spec.unit;
  }

  [[nodiscard]] YAML::Mark key_mark(std::string_view key) const {
    for (const auto& entry : node_) {
      if (entry.first.IsScalar() && entry.first.Scalar() == key) return entry.first.Mark();
    }
    return node_.Mark();
  }

  [[nodiscard]] YAML::Mark value_mark(std::string_view key) const {
    for (const auto& entry : node_) {
      if (entry.first.IsScalar() && entry.first.Scalar() == key) return entry.second.Mark();
    }
    return node_.Mark();
  }

  [[nodiscard]] std::string name(std::string_view key) const {
    return path_.empty() ? std::string(key) : fmt::format("{}.{}", path_, key);
  }

  [[nodiscard]] std::string known_keys() const {
    if (visited_.empty()) return "";
    return fmt::format("; known here: {}", fmt::join(visited_, ", "));
  }

  YAML::Node node_;
  std::string path_;
  Problems& problems_;
  std::vector<std::string> keys_;
  std::set<std::string, std::less<>> visited_;
};

class YamlWriter : public ConfigVisitor {
 public:
  explicit YamlWriter(YAML::Emitter& out) : out_(out) {}

  void number(std::string_view key, double& value, const NumberSpec& spec, Presence) override {
    put_key(key);
    out_ << in_file_unit(value, spec);
  }
  void integer(std::string_view key, std::int64_t& value, std::int64_t, std::int64_t,
               Presence) override {
    put_key(key);
    out_ << value;
  }
  void boolean(std::string_view key, bool& value, Presence) override {
    put_key(key);
    out_ << (value ? "true" : "false");
  }
  void text(std::string_view key, std::string& value, Presence) override {
    put_key(key);
    out_ << value;
  }
  void choice(std::string_view key, std::string& value, const std::vector<std::string>&,
              Presence) override {
    put_key(key);
    out_ << value;
  }
  void numbers(std::string_view key, std::vector<double>& values, std::size_t,
               const NumberSpec& spec, Presence) override {
    put_key(key);
    out_ << YAML::Flow << YAML::BeginSeq;
    for (const double value : values) out_ << in_file_unit(value, spec);
    out_ << YAML::EndSeq;
  }
  void texts(std::string_view key, std::vector<std::string>& values, Presence) override {
    put_key(key);
    out_ << YAML::Flow << YAML::BeginSeq;
    for (const std::string& value : values) out_ << value;
    out_ << YAML::EndSeq;
  }
  void group(std::string_view key, const Fields& fields, Presence) override {
    put_key(key);
    out_ << YAML::BeginMap;
    fields(*this);
    out_ << YAML::EndMap;
  }
  void list(std::string_view key, std::size_t size, const std::function<void(std::size_t)>&,
            const std::function<void(ConfigVisitor&, std::size_t)>& element, Presence) override {
    put_key(key);
    out_ << YAML::BeginSeq;
    for (std::size_t i = 0; i < size; ++i) {
      out_ << YAML::BeginMap;
      element(*this, i);
      out_ << YAML::EndMap;
    }
    out_ << YAML::EndSeq;
  }
  [[nodiscard]] std::vector<std::string> keys() const override { return {}; }
  [[nodiscard]] bool reading() const override { return false; }
  void problem(std::string_view, std::string_view) override {}

 private:
  void put_key(std::string_view key) { out_ << YAML::Key << std::string(key) << YAML::Value; }

  // Division by the unit may not undo the multiplication to the last bit; a neighbour always does.
  static std::string in_file_unit(double value, const NumberSpec& spec) {
    double file_value = value / spec.unit;
    for (const double toward :
         {std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()}) {
      const double neighbour = std::nextafter(value / spec.unit, toward);
      if (file_value * spec.unit != value && neighbour * spec.unit == value) file_value = neighbour;
    }
    return fmt::format("{}", file_value);
  }

  YAML::Emitter& out_;
};

// Anchors allow self-references, which yaml-cpp follows for ever; a configuration needs none.
class AliasFinder {
 public:
  static void check(const std::string& text, Problems& problems) {
    std::istringstream stream(text);
    std::string line;
    for (int row = 0; std::getline(stream, line); ++row) {
      char quote = '\0';
      for (std::size_t column = 0; column < line.size(); ++column) {
        const char character = line[column];
        const bool starts_word =
            column == 0 ||
            std::string_view(" \t[{,:-").find(line[column - 1]) != std::string_view::npos;
        if (quote != '\0') {
          if (character == quote) quote = '\0';
        } else if (starts_word && (character == '"' || character == '\'')) {
          quote = character;
        } else if (starts_word && character == '#') {
          break;
        } else if (starts_word && (character == '&' || character == '*') &&
                   column + 1 < line.size() && line[column + 1] != ' ') {
          problems.lines.push_back(
              fmt::format("{}:{}:{}: anchors and aliases are not accepted, write the value out",
                          problems.file, row + 1, column + 1));
        }
      }
    }
  }
};

/// Listens to nothing.
class NoEvents final : public YAML::EventHandler {
 public:
  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark&, YAML::anchor_t) override {}
  void OnAlias(const YAML::Mark&, YAML::anchor_t) override {}
  void OnScalar(const YAML::Mark&, const std::string&, YAML::anchor_t,
                const std::string&) override {}
  void OnSequenceStart(const YAML::Mark&, const std::string&, YAML::anchor_t,
                       YAML::EmitterStyle::value) override {}
  void OnSequenceEnd() override {}
  void OnMapStart(const YAML::Mark&, const std::string&, YAML::anchor_t,
                  YAML::EmitterStyle::value) override {}
  void OnMapEnd() override {}
};

/// Whether there is more than one document. YAML::LoadAll would go on for ever: in some broken
/// texts yaml-cpp finds one empty document after the other without moving on.
bool has_second_document(const std::string& text) {
  std::istringstream stream(text);
  YAML::Parser parser(stream);
  NoEvents ignored;
  return parser.HandleNextDocument(ignored) && parser.HandleNextDocument(ignored);
}

}  // namespace

void ConfigVisitor::interval(std::string_view key, Interval& value, const NumberSpec& spec,
                             Presence presence) {
  std::vector<double> bounds{value.low, value.high};
  numbers(key, bounds, 2, spec, presence);
  if (bounds.size() != 2) return;
  if (bounds[0] > bounds[1]) {
    problem(key, fmt::format("'{}' must be [low, high] with low <= high", key));
    return;
  }
  value = {bounds[0], bounds[1]};
}

void read_yaml_text(const std::string& text, const std::string& name,
                    const ConfigVisitor::Fields& fields) {
  Problems problems{name, {}};
  AliasFinder::check(text, problems);
  problems.throw_if_any();
  YAML::Node document;
  bool is_alone = false;
  try {
    document = YAML::Load(text);
    is_alone = !has_second_document(text);
  } catch (const YAML::Exception& error) {
    problems.add(error.mark, error.msg);
  }
  problems.throw_if_any();
  if (!is_alone || !document.IsMap()) {
    throw InputError(
        fmt::format("{}:1:1: expected one YAML document that is a mapping of keys", name));
  }
  YamlReader reader(document, "", problems);
  fields(reader);
  reader.report_unknown_keys();
  problems.throw_if_any();
}

void read_yaml(const std::filesystem::path& file, const ConfigVisitor::Fields& fields) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) {
    throw InputError(fmt::format("{}: no such file, check the path", file.string()));
  }
  if (std::filesystem::file_size(file, error) > kMaxFileBytes) {
    throw InputError(fmt::format("{}: larger than 16 MiB, not a configuration", file.string()));
  }
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  if (!stream) {
    throw InputError(fmt::format("{}: cannot be read, check its rights", file.string()));
  }
  read_yaml_text(text.str(), file.string(), fields);
}

std::string write_yaml(const ConfigVisitor::Fields& fields) {
  YAML::Emitter out;
  YamlWriter writer(out);
  out << YAML::BeginMap;
  fields(writer);
  out << YAML::EndMap;
  return std::string(out.c_str()) + "\n";
}

}  // namespace binpick
