#include "experiments/replay_track.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <limits>
#include <stdexcept>

namespace binpick {
namespace {

std::int16_t rounded(float value) {
  constexpr float kLowest = std::numeric_limits<std::int16_t>::min();
  constexpr float kHighest = std::numeric_limits<std::int16_t>::max();
  if (std::isnan(value)) return 0;  // a simulation that has diverged
  return static_cast<std::int16_t>(std::lround(std::clamp(value, kLowest, kHighest)));
}

}  // namespace

ReplayTrack keys_of(const RecordedSignal& signal, int tolerance) {
  const std::size_t frames = signal.values.size() / signal.width;
  if (frames > std::size_t{1} << 16) throw std::invalid_argument("a replay has too many frames");
  ReplayTrack track{signal.width, {}, {}};
  std::vector<std::int16_t> now(signal.width);
  for (std::size_t frame = 0; frame < frames; ++frame) {
    const auto first = signal.values.begin() + std::ptrdiff_t(frame * signal.width);
    std::transform(first, first + std::ptrdiff_t(signal.width), now.begin(), rounded);
    const auto moved = [&](std::int16_t a, std::int16_t b) { return std::abs(a - b) > tolerance; };
    const auto last = track.values.end() - std::ptrdiff_t(track.frames.empty() ? 0 : signal.width);
    if (frame > 0 && std::equal(now.begin(), now.end(), last, std::not_fn(moved))) continue;
    track.frames.push_back(static_cast<std::uint16_t>(frame));
    track.values.insert(track.values.end(), now.begin(), now.end());
  }
  return track;
}

}  // namespace binpick
