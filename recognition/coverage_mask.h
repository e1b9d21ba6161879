#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace binpick {

/// Which pixels of a window a model covers, one bit each, so that 64 are looked at together. What
/// lies outside the window, up to kBorder rows above and below and 64 columns beside it, is not
/// covered.
class CoverageMask {
 public:
  static constexpr int kBorder = 3;

  /// An empty mask.
  void reset(int width, int height) {
    words_ = (width + 63) / 64;
    words_per_row_ = static_cast<std::size_t>(words_) + 2;
    bits_.assign(words_per_row_ * static_cast<std::size_t>(height + 2 * kBorder), 0);
  }
  /// Words that hold a row's pixels, those of lower columns in lower bits.
  [[nodiscard]] int words() const noexcept { return words_; }
  [[nodiscard]] std::uint64_t* row(int v) { return bits_.data() + offset(v); }
  [[nodiscard]] const std::uint64_t* row(int v) const { return bits_.data() + offset(v); }

  /// The pixels of a word whose neighbours `step` (< 64) pixels to the left, right, above and below
  /// are covered.
  struct Neighbours {
    std::uint64_t left, right, above, below;

    [[nodiscard]] std::uint64_t all() const noexcept { return left & right & above & below; }
  };
  [[nodiscard]] Neighbours neighbours(int word, int v, int step) const {
    const std::uint64_t* here = row(v) + word;
    return {here[0] << step | here[-1] >> (64 - step), here[0] >> step | here[1] << (64 - step),
            row(v - step)[word], row(v + step)[word]};
  }

  /// Seven pixels of a row: bit i is column u - 3 + i.
  [[nodiscard]] unsigned seven_about(int u, int v) const {
    const auto first = static_cast<std::size_t>(u) + 64 - 3;  // from the word before the row's
    const std::uint64_t* words = row(v) - 1 + first / 64;
    const std::size_t shift = first % 64;
    const std::uint64_t above = shift == 0 ? 0 : words[1] << (64 - shift);
    return static_cast<unsigned>((words[0] >> shift | above) & 0x7f);
  }

 private:
  [[nodiscard]] std::size_t offset(int v) const {
    return static_cast<std::size_t>(v + kBorder) * words_per_row_ + 1;
  }

  int words_ = 0;
  std::size_t words_per_row_ = 2;
  std::vector<std::uint64_t> bits_;
};

/// Calls visit(u) for the pixels of word `word` that are set, in ascending order.
template <class Visit>
void for_each_pixel(std::uint64_t bits, int word, const Visit& visit) {
  for (; bits != 0; bits &= bits - 1) visit(64 * word + std::countr_zero(bits));
}

}  // namespace binpick
