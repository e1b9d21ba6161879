#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace binpick {

/// A signal of several numbers over the frames of a replay, kept where it changes: the numbers of
/// a key hold until the next key. Numbers are multiples of a step that the reader knows.
struct ReplayTrack {
  std::size_t width = 0;              ///< numbers per key
  std::vector<std::uint16_t> frames;  ///< of each key, rising; the first is 0
  std::vector<std::int16_t> values;   ///< key by key
};

/// A signal as it was recorded: frame by frame, `width` numbers each, in multiples of the step.
struct RecordedSignal {
  std::size_t width = 0;
  std::vector<float> values;
};

/// Keeps the frames in which a number differs from the last key's by more than `tolerance`. Numbers
/// beyond 16 bits are clipped. At most 65536 frames.
[[nodiscard]] ReplayTrack keys_of(const RecordedSignal& signal, int tolerance);

}  // namespace binpick
