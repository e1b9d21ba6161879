#include "experiments/config_override.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "models/errors.h"
#include "models/yaml_config.h"

namespace binpick {
namespace {

/// Passes every field on as optional, so that a document of one key changes one field. Inside lists
/// nothing is relaxed: a list is replaced as a whole.
class PartialReader : public ConfigVisitor {
 public:
  explicit PartialReader(ConfigVisitor& reader) : reader_(reader) {}

  void number(std::string_view key, double& value, const NumberSpec& spec, Presence) override {
    reader_.number(key, value, spec);
  }
  void integer(std::string_view key, std::int64_t& value, std::int64_t min, std::int64_t max,
               Presence) override {
    reader_.integer(key, value, min, max);
  }
  void boolean(std::string_view key, bool& value, Presence) override {
    reader_.boolean(key, value);
  }
  void text(std::string_view key, std::string& value, Presence) override {
    reader_.text(key, value);
  }
  void choice(std::string_view key, std::string& value, const std::vector<std::string>& choices,
              Presence) override {
    reader_.choice(key, value, choices);
  }
  void numbers(std::string_view key, std::vector<double>& values, std::size_t size,
               const NumberSpec& spec, Presence) override {
    reader_.numbers(key, values, size, spec);
  }
  void texts(std::string_view key, std::vector<std::string>& values, Presence) override {
    reader_.texts(key, values);
  }
  void group(std::string_view key, const Fields& fields, Presence) override {
    reader_.group(key, [&](ConfigVisitor& inner) {
      PartialReader partial(inner);
      fields(partial);
    });
  }
  void list(std::string_view key, std::size_t size, const std::function<void(std::size_t)>& resize,
            const std::function<void(ConfigVisitor&, std::size_t)>& element, Presence) override {
    reader_.list(key, size, resize, element);
  }
  [[nodiscard]] std::vector<std::string> keys() const override { return reader_.keys(); }
  [[nodiscard]] bool reading() const override { return reader_.reading(); }
  void problem(std::string_view key, std::string_view message) override {
    reader_.problem(key, message);
  }

 private:
  ConfigVisitor& reader_;
};

std::string yaml_text(const std::string& text) {
  return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace

ConfigOverride ConfigOverride::parse(const std::string& text) {
  const std::size_t sign = text.find('=');
  const std::string path = text.substr(0, sign);
  const bool empty_key =
      path.empty() || path.front() == '.' || path.back() == '.' || path.find("..") != path.npos;
  // A line break would begin a key of its own.
  const bool one_value = sign + 1 < text.size() && text.find_first_of("\r\n") == text.npos;
  if (sign == std::string::npos || empty_key || !one_value) {
    throw InputError(fmt::format("--set '{}': expected path=value, e.g. trials=20", text));
  }
  return {path, text.substr(sign + 1)};
}

ConfigOverride ConfigOverride::literal(const std::string& path, const std::string& text) {
  return {path, yaml_text(text)};
}

void apply_override(const ConfigOverride& change, const std::string& origin,
                    const ConfigVisitor::Fields& fields) {
  std::string yaml;
  std::string indent;
  std::istringstream path(change.path);
  for (std::string key; std::getline(path, key, '.'); indent += "  ") {
    yaml += (yaml.empty() ? "" : "\n") + indent + yaml_text(key) + ":";
  }
  read_yaml_text(yaml + " " + change.value, origin, [&](ConfigVisitor& reader) {
    PartialReader partial(reader);
    fields(partial);
  });
}

}  // namespace binpick
