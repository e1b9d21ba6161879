#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "models/geometry.h"

namespace binpick {

/// Bounds and unit of a number in a configuration file. `unit` converts the file's value to SI:
/// 0.001 for a key that ends in _mm, pi/180 for _deg.
struct NumberSpec {
  double min = -std::numeric_limits<double>::infinity();  ///< in the file's unit, inclusive
  double max = std::numeric_limits<double>::infinity();
  double unit = 1.0;
};

inline constexpr double kMillimetre = 0.001;
inline constexpr double kDegree = 3.14159265358979323846 / 180.0;

enum class Presence { kOptional, kRequired };

/// One pass over the fields of a configuration struct. A struct has a single
/// `void visit(ConfigVisitor&)` that names each field once; a reader fills the fields from YAML, a
/// writer saves the effective configuration, a documenter lists the keys.
/// An optional field that the file leaves out keeps its value.
class ConfigVisitor {
 public:
  using Fields = std::function<void(ConfigVisitor&)>;

  virtual ~ConfigVisitor() = default;

  virtual void number(std::string_view key, double& value, const NumberSpec& spec = {},
                      Presence presence = Presence::kOptional) = 0;
  virtual void integer(std::string_view key, std::int64_t& value, std::int64_t min,
                       std::int64_t max, Presence presence = Presence::kOptional) = 0;
  virtual void boolean(std::string_view key, bool& value,
                       Presence presence = Presence::kOptional) = 0;
  virtual void text(std::string_view key, std::string& value,
                    Presence presence = Presence::kOptional) = 0;
  /// One of `choices`.
  virtual void choice(std::string_view key, std::string& value,
                      const std::vector<std::string>& choices,
                      Presence presence = Presence::kOptional) = 0;
  /// A list of numbers; `size` fixes its length, 0 leaves it open.
  virtual void numbers(std::string_view key, std::vector<double>& values, std::size_t size,
                       const NumberSpec& spec = {}, Presence presence = Presence::kOptional) = 0;
  virtual void texts(std::string_view key, std::vector<std::string>& values,
                     Presence presence = Presence::kOptional) = 0;
  /// A nested mapping.
  virtual void group(std::string_view key, const Fields& fields,
                     Presence presence = Presence::kOptional) = 0;
  /// A list of mappings. When reading, `resize` is called with the list's length first, then
  /// `element` once per entry with its index. When writing, `size` entries are visited.
  virtual void list(std::string_view key, std::size_t size,
                    const std::function<void(std::size_t)>& resize,
                    const std::function<void(ConfigVisitor&, std::size_t)>& element,
                    Presence presence = Presence::kOptional) = 0;
  /// The keys of this mapping in file order, for mappings with free keys. Empty when not reading.
  [[nodiscard]] virtual std::vector<std::string> keys() const = 0;
  [[nodiscard]] virtual bool reading() const = 0;
  /// Reports that the value at `key` (or this mapping, when `key` is empty) makes no sense.
  virtual void problem(std::string_view key, std::string_view message) = 0;

  // Conveniences on top of the above.
  void interval(std::string_view key, Interval& value, const NumberSpec& spec = {},
                Presence presence = Presence::kOptional);
  template <class Vector>
  void vector(std::string_view key, Vector& value, const NumberSpec& spec = {},
              Presence presence = Presence::kOptional) {
    std::vector<double> numbers_of(value.data(), value.data() + value.size());
    numbers(key, numbers_of, static_cast<std::size_t>(value.size()), spec, presence);
    if (numbers_of.size() == static_cast<std::size_t>(value.size())) {
      for (Eigen::Index i = 0; i < value.size(); ++i) {
        value.data()[i] = static_cast<typename Vector::Scalar>(numbers_of[std::size_t(i)]);
      }
    }
  }
  template <class Element>
  void elements(std::string_view key, std::vector<Element>& values,
                Presence presence = Presence::kOptional) {
    list(
        key, values.size(), [&](std::size_t size) { values.assign(size, Element{}); },
        [&](ConfigVisitor& visitor, std::size_t i) { values[i].visit(visitor); }, presence);
  }
};

}  // namespace binpick
