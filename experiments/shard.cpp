#include "experiments/shard.h"

#include <fmt/format.h>

#include <charconv>
#include <cstdlib>
#include <string_view>

#include "models/errors.h"

namespace binpick {
namespace {

std::optional<std::int64_t> parse_integer(std::string_view text) {
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::optional<std::int64_t> environment_integer(const char* name) {
  const char* text = std::getenv(name);
  return text == nullptr ? std::nullopt : parse_integer(text);
}

}  // namespace

Shard Shard::parse(const std::string& text) {
  const std::size_t slash = text.find('/');
  if (slash != std::string::npos) {
    const auto index = parse_integer(std::string_view(text).substr(0, slash));
    const auto count = parse_integer(std::string_view(text).substr(slash + 1));
    if (index && count && 0 <= *index && *index < *count) return {*index, *count};
  }
  throw InputError(fmt::format("--shard '{}': expected i/n with 0 <= i < n, e.g. 0/8", text));
}

std::optional<Shard> Shard::from_environment() {
  const auto task = environment_integer("SLURM_ARRAY_TASK_ID");
  const auto count = environment_integer("SLURM_ARRAY_TASK_COUNT");
  if (!task || !count || *count < 1) return std::nullopt;
  const std::int64_t index = *task - environment_integer("SLURM_ARRAY_TASK_MIN").value_or(0);
  if (index < 0 || index >= *count) {
    throw InputError(fmt::format(
        "SLURM_ARRAY_TASK_ID={} does not fit an array of {} tasks in steps of one", *task, *count));
  }
  return Shard{index, *count};
}

}  // namespace binpick
