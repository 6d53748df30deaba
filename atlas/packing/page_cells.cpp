#include "atlas/packing/page_cells.h"

#include <algorithm>
#include <bit>
#include <numeric>
#include <span>
#include <utility>

#include "io/image.h"

namespace gpvc::atlas {

PackShape quarter_turn(const PackShape& shape) {
  PackShape result{shape.height, shape.width, {}};
  std::vector<char> bits(pixel_index(0, result.height, result.width), 0);
  for (const auto& run : shape.runs)
    for (int x = run.first; x < run.first + run.length; ++x)
      bits[pixel_index(shape.height - 1 - run.row, x, result.width)] = 1;
  for (int y = 0; y < result.height; ++y) {
    const auto line = bits.begin() + static_cast<std::ptrdiff_t>(pixel_index(0, y, result.width));
    const auto end = line + result.width;
    for (auto first = std::find(line, end, 1); first != end;) {
      const auto last = std::find(first, end, 0);
      result.runs.push_back({y, static_cast<int>(first - line), static_cast<int>(last - first)});
      first = std::find(last, end, 1);
    }
  }
  return result;
}

TurnedShape::TurnedShape(PackShape shape) : PackShape(std::move(shape)), check_order(runs.size()) {
  std::iota(check_order.begin(), check_order.end(), 0u);
  // Bit-reversed order visits the ends first, then the middle, then the quarters.
  const int bits = static_cast<int>(std::bit_width(runs.size()));
  const auto reversed = [bits](std::uint32_t value) {
    std::uint32_t result = 0;
    for (int i = 0; i < bits; ++i) result |= ((value >> i) & 1u) << (bits - 1 - i);
    return result;
  };
  std::ranges::sort(check_order, {}, reversed);
}

int PageCells::words_of(int width) { return (width + kWordBits - 1) / kWordBits + 1; }
int PageCells::levels_of(int width) { return static_cast<int>(std::bit_width(static_cast<unsigned>(width))); }

std::size_t PageCells::bytes(int width, int height) {
  return sizeof(std::uint64_t) * static_cast<std::size_t>(levels_of(width)) * static_cast<std::size_t>(height) *
         static_cast<std::size_t>(words_of(width));
}

PageCells::PageCells(int width, int height)
    : width_(width),
      height_(height),
      words_(words_of(width)),
      levels_(levels_of(width)),
      bits_(bytes(width, height) / sizeof(std::uint64_t), 0),
      longest_free_(static_cast<std::size_t>(height), width),
      blocked_columns_(static_cast<std::size_t>(words_)) {}

std::optional<Position> PageCells::find(const TurnedShape& shape, int first_row, int limit) {
  if (shape.width > width_) return std::nullopt;
  for (int y = first_row; y + shape.height <= std::min(height_, limit); ++y) {
    if (!may_fit(shape, y)) continue;
    if (const auto x = find_in_row(shape, y)) return Position{*x, y};
  }
  return std::nullopt;
}

void PageCells::occupy(const TurnedShape& shape, const Position& at) {
  for (const auto& run : shape.runs) {
    std::uint64_t* bits = row(0, at.y + run.row);
    for (int x = at.x + run.first; x < at.x + run.first + run.length; ++x)
      bits[x / kWordBits] |= std::uint64_t{1} << (x % kWordBits);
  }
  for (int y = at.y; y < at.y + shape.height; ++y) refresh(y, at.x, at.x + shape.width);
}

/// Adds the row's bits x + shift to the bits x of `to`, from one word to before another. Beyond the row they are zero.
void PageCells::add_shifted(const std::uint64_t* bits, int shift, int first, int end, std::uint64_t* to) const {
  const int whole = shift / kWordBits, part = shift % kWordBits;
  end = std::min(end, words_ - 1 - whole);  // the last word of a row is zero
  const std::uint64_t* from = bits + whole;
  if (part == 0)
    for (int word = first; word < end; ++word) to[word] |= from[word];
  else
    for (int word = first; word < end; ++word) to[word] |= from[word] >> part | from[word + 1] << (kWordBits - part);
}

/// A quick test before the search: no run is longer than the longest free run of its row.
bool PageCells::may_fit(const TurnedShape& shape, int y) const {
  for (const auto k : shape.check_order) {
    const CellRun& run = shape.runs[k];
    if (run.length > longest_free_[static_cast<std::size_t>(y + run.row)]) return false;
  }
  return true;
}

/// The first column at which the shape fits with its top in row y; see the drawing in the header.
std::optional<int> PageCells::find_in_row(const TurnedShape& shape, int y) {
  constexpr std::uint64_t kAllBlocked = ~std::uint64_t{0};
  const int columns = width_ - shape.width + 1;
  const int words = (columns + kWordBits - 1) / kWordBits;
  const std::span blocked = std::span(blocked_columns_).first(static_cast<std::size_t>(words));
  std::fill(blocked.begin(), blocked.end(), 0);
  if (columns % kWordBits) blocked.back() = kAllBlocked << (columns % kWordBits);
  for (const auto k : shape.check_order) {
    const CellRun& run = shape.runs[k];
    const int level = static_cast<int>(std::bit_width(static_cast<unsigned>(run.length))) - 1;
    const int second_half = run.first + run.length - (1 << level);
    const std::uint64_t* bits = row(level, y + run.row);
    add_shifted(bits, run.first, 0, words, blocked.data());
    if (second_half != run.first) add_shifted(bits, second_half, 0, words, blocked.data());
    if (std::ranges::all_of(blocked, [](std::uint64_t word) { return word == kAllBlocked; })) return std::nullopt;
  }
  for (int word = 0; word < words; ++word)
    if (const std::uint64_t b = blocked[static_cast<std::size_t>(word)]; b != kAllBlocked)
      return word * kWordBits + std::countr_one(b);
  return std::nullopt;
}

/// Recomputes the levels above 0 and the longest free run of a row of which cells from first to before end have changed.
void PageCells::refresh(int y, int first, int end) {
  for (int level = 1; level < levels_; ++level) {
    const std::uint64_t* finer = row(level - 1, y);
    std::uint64_t* bits = row(level, y);
    // The words with bits that stand for one of these cells.
    const int first_word = std::max(0, first - (1 << level) + 1) / kWordBits, end_word = (end - 1) / kWordBits + 1;
    std::copy(finer + first_word, finer + end_word, bits + first_word);
    add_shifted(finer, 1 << (level - 1), first_word, end_word, bits);
  }
  const std::uint64_t* bits = row(0, y);
  int longest = 0, current = 0;
  for (int x = 0; x < width_;) {
    const std::uint64_t rest = bits[x / kWordBits] >> (x % kWordBits);
    const int left = std::min(width_ - x, kWordBits - x % kWordBits);
    const int free = std::min(left, std::countr_zero(rest));
    current += free;
    longest = std::max(longest, current);
    if (free == left) {
      x += left;
      continue;
    }
    current = 0;
    x += free + std::min(left - free, std::countr_one(rest >> free));
  }
  longest_free_[static_cast<std::size_t>(y)] = longest;
}

}  // namespace gpvc::atlas
