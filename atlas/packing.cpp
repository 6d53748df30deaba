#include "atlas/packing.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <tuple>

namespace gpvc {

namespace {

constexpr int kWordBits = 64;

int cells(int texels) { return (texels + kCell - 1) / kCell; }

/// A shape in one of its two orientations, in cells.
struct CellShape {
  int width = 0, height = 0;
  std::vector<CellRun> runs;
  std::vector<std::uint32_t> check_order;  ///< of runs: spread over the rows, so that a misfit shows early
};

void order_checks(CellShape& shape) {
  shape.check_order.resize(shape.runs.size());
  std::iota(shape.check_order.begin(), shape.check_order.end(), 0u);
  // Bit-reversed order visits ends and middles first.
  const int bits = static_cast<int>(std::bit_width(shape.runs.size()));
  const auto reversed = [bits](std::uint32_t value) {
    std::uint32_t result = 0;
    for (int i = 0; i < bits; ++i) result |= ((value >> i) & 1u) << (bits - 1 - i);
    return result;
  };
  std::sort(shape.check_order.begin(), shape.check_order.end(),
            [&](auto a, auto b) { return reversed(a) < reversed(b); });
}

CellShape upright(const PackShape& shape) {
  CellShape result{cells(shape.width), cells(shape.height), shape.runs, {}};
  order_checks(result);
  return result;
}

/// Cells of the turned box are aligned to its own corner, so when the height is no multiple of a cell they
/// straddle the upright cells; both cells that one reaches into are taken.
CellShape turned(const PackShape& shape) {
  const int width = cells(shape.height), height = cells(shape.width);
  std::vector<char> bits(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 0);
  for (const auto& run : shape.runs) {
    // Texel rows [row * kCell, (row + 1) * kCell) of the upright box, cut to it, become columns.
    const int last_texel = shape.height - 1 - run.row * kCell;
    const int first_texel = std::max(0, shape.height - (run.row + 1) * kCell);
    for (int column = first_texel / kCell; column <= last_texel / kCell; ++column)
      for (int row = run.first; row < run.first + run.length; ++row)
        bits[static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
             static_cast<std::size_t>(column)] = 1;
  }
  CellShape result{width, height, {}, {}};
  for (int row = 0; row < height; ++row) {
    const char* line = bits.data() + static_cast<std::size_t>(row) * static_cast<std::size_t>(width);
    for (int x = 0; x < width;) {
      if (!line[x]) {
        ++x;
        continue;
      }
      const int first = x;
      while (x < width && line[x]) ++x;
      result.runs.push_back({row, first, x - first});
    }
  }
  order_checks(result);
  return result;
}

struct Position {
  int x = 0, y = 0;
};

/// Occupied cells of a page. Level k of a row has bit x set when any of the cells x .. x + 2^k - 1 is
/// occupied, so a run of any length is tested with two look-ups.
class PageCells {
 public:
  PageCells(int width, int height)
      : width_(width),
        height_(height),
        words_((width + kWordBits - 1) / kWordBits + 1),
        levels_(std::bit_width(static_cast<unsigned>(width))),
        bits_(static_cast<std::size_t>(levels_) * static_cast<std::size_t>(height) *
                  static_cast<std::size_t>(words_),
              0),
        blocked_(static_cast<std::size_t>(words_)) {}

  /// The lowest position at or below row `first_row` where the shape meets no occupied cell.
  std::optional<Position> find(const CellShape& shape, int first_row) {
    if (shape.width > width_) return std::nullopt;
    for (int y = first_row; y + shape.height <= height_; ++y)
      if (const int x = find_in_row(shape, y); x >= 0) return Position{x, y};
    return std::nullopt;
  }

  void occupy(const CellShape& shape, const Position& at) {
    int touched = -1;
    for (const auto& run : shape.runs) {
      std::uint64_t* bits = row(0, at.y + run.row);
      for (int x = at.x + run.first; x < at.x + run.first + run.length; ++x)
        bits[x / kWordBits] |= std::uint64_t{1} << (x % kWordBits);
      if (touched >= 0 && touched != run.row) refresh(at.y + touched);
      touched = run.row;
    }
    if (touched >= 0) refresh(at.y + touched);
  }

 private:
  std::uint64_t* row(int level, int y) {
    return bits_.data() + (static_cast<std::size_t>(level) * static_cast<std::size_t>(height_) +
                           static_cast<std::size_t>(y)) *
                              static_cast<std::size_t>(words_);
  }

  /// Bits x + shift of a row, as bits x of the answer's word; beyond the row they are zero.
  std::uint64_t shifted(const std::uint64_t* bits, int word, int shift) const {
    const int whole = word + shift / kWordBits, part = shift % kWordBits;
    const std::uint64_t low = whole < words_ ? bits[whole] >> part : 0;
    const std::uint64_t high = part && whole + 1 < words_ ? bits[whole + 1] << (kWordBits - part) : 0;
    return low | high;
  }

  int find_in_row(const CellShape& shape, int y) {
    const int columns = width_ - shape.width + 1;  // candidate positions
    const int used = (columns + kWordBits - 1) / kWordBits;
    std::fill_n(blocked_.begin(), used, 0);
    if (columns % kWordBits)
      blocked_[static_cast<std::size_t>(used - 1)] = ~std::uint64_t{0} << (columns % kWordBits);
    for (const auto k : shape.check_order) {
      const CellRun& run = shape.runs[k];
      const int level = std::bit_width(static_cast<unsigned>(run.length)) - 1;
      const std::uint64_t* bits = row(level, y + run.row);
      const int last = run.first + run.length - (1 << level);
      std::uint64_t all = ~std::uint64_t{0};
      for (int word = 0; word < used; ++word) {
        std::uint64_t& b = blocked_[static_cast<std::size_t>(word)];
        b |= shifted(bits, word, run.first) | shifted(bits, word, last);
        all &= b;
      }
      if (all == ~std::uint64_t{0}) return -1;
    }
    for (int word = 0; word < used; ++word) {
      const std::uint64_t b = blocked_[static_cast<std::size_t>(word)];
      if (b != ~std::uint64_t{0}) return word * kWordBits + std::countr_one(b);
    }
    return -1;
  }

  void refresh(int y) {
    for (int level = 1; level < levels_; ++level) {
      const std::uint64_t* finer = row(level - 1, y);
      std::uint64_t* bits = row(level, y);
      for (int word = 0; word < words_; ++word)
        bits[word] = finer[word] | shifted(finer, word, 1 << (level - 1));
    }
  }

  int width_, height_, words_, levels_;
  std::vector<std::uint64_t> bits_;
  std::vector<std::uint64_t> blocked_;
};

/// Shapes alike enough that where one found no room the next, no larger in cells than its class, is not tried
/// again. Small boxes are their own class; of larger ones, which are few, each is tried from the top.
struct SizeClass {
  static constexpr int kExact = 24;  // cells
  static std::optional<std::pair<int, int>> of(const CellShape& shape) {
    if (shape.width > kExact || shape.height > kExact) return std::nullopt;
    return std::pair(shape.width, shape.height);
  }
};

struct OpenPage {
  PageCells cells;
  std::map<std::pair<int, int>, int> first_row;  ///< per size class: rows above have been searched
};

std::optional<Position> search(OpenPage& page, const CellShape& shape) {
  const auto size_class = SizeClass::of(shape);
  int start = 0;
  if (size_class) {
    const auto known = page.first_row.find(*size_class);
    if (known != page.first_row.end()) start = known->second;
  }
  const auto found = page.cells.find(shape, start);
  if (size_class) page.first_row[*size_class] = found ? found->y : 1 << 28;
  return found;
}

std::int64_t cell_count(const PackShape& shape) {
  std::int64_t count = 0;
  for (const auto& run : shape.runs) count += run.length;
  return count;
}

std::vector<std::uint32_t> by_falling_area(std::span<const PackShape> shapes) {
  std::vector<std::uint32_t> order(shapes.size());
  std::iota(order.begin(), order.end(), 0u);
  std::vector<std::int64_t> area(shapes.size());
  for (std::size_t i = 0; i < shapes.size(); ++i) area[i] = cell_count(shapes[i]);
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return area[a] > area[b]; });
  return order;
}

/// Puts `order` on pages of the given size; at most `most_pages`, nullopt when they do not suffice.
bool place(std::span<const PackShape> shapes, std::span<const std::uint32_t> order, PageSize size,
           std::uint32_t first_page, std::uint32_t most_pages, std::vector<Placement>& placements) {
  std::vector<OpenPage> pages;
  const int width = size.width / kCell, height = size.height / kCell;
  for (const auto i : order) {
    const CellShape shape = upright(shapes[i]), other = turned(shapes[i]);
    for (std::size_t p = 0;; ++p) {
      if (p == pages.size()) {
        if (p == most_pages) return false;
        pages.push_back({PageCells(width, height), {}});
      }
      const auto a = search(pages[p], shape), b = search(pages[p], other);
      if (!a && !b) continue;
      const bool turn =
          !a || (b && std::tuple(b->y + other.height, b->x) < std::tuple(a->y + shape.height, a->x));
      const Position at = turn ? *b : *a;
      pages[p].cells.occupy(turn ? other : shape, at);
      placements[i] = {first_page + static_cast<std::uint32_t>(p), at.x * kCell, at.y * kCell, turn};
      break;
    }
  }
  return true;
}

/// Narrows the last page so that its content comes out near-square instead of a wide strip.
void square_last_page(std::span<const PackShape> shapes, std::span<const std::uint32_t> order, int page_size,
                      std::vector<Placement>& placements) {
  std::uint32_t last = 0;
  for (const auto& p : placements) last = std::max(last, p.page);
  std::vector<std::uint32_t> mine;
  std::int64_t area = 0;
  int least_width = 0;
  for (const auto i : order) {
    if (placements[i].page != last) continue;
    mine.push_back(i);
    area += cell_count(shapes[i]) * kCell * kCell;
    least_width = std::max(least_width, std::min(cells(shapes[i].width), cells(shapes[i].height)) * kCell);
  }
  constexpr double kExpectedFill = 0.92;
  const double edge = std::sqrt(static_cast<double>(area) / kExpectedFill);
  const int width = std::max(least_width, cells(static_cast<int>(edge)) * kCell);
  if (width >= page_size) return;
  std::vector<Placement> narrow = placements;
  if (place(shapes, mine, {width, page_size}, last, 1, narrow)) placements = std::move(narrow);
}

}  // namespace

PackShape box_shape(int width, int height) {
  PackShape shape{width, height, {}};
  for (int row = 0; row < cells(height); ++row) shape.runs.push_back({row, 0, cells(width)});
  return shape;
}

Packing pack_shapes(std::span<const PackShape> shapes, int page_size) {
  Packing packing;
  if (shapes.empty()) return packing;
  assert(page_size % kCell == 0);
  for ([[maybe_unused]] const auto& shape : shapes)
    assert(shape.width <= page_size && shape.height <= page_size);
  packing.placements.resize(shapes.size());
  const auto order = by_falling_area(shapes);
  place(shapes, order, {page_size, page_size}, 0, 0xFFFFFFFFu, packing.placements);
  square_last_page(shapes, order, page_size, packing.placements);
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    const Placement& p = packing.placements[i];
    if (p.page >= packing.pages.size()) packing.pages.resize(p.page + 1);
    PageSize& page = packing.pages[p.page];
    page.width = std::max(page.width, p.x + (p.turned ? shapes[i].height : shapes[i].width));
    page.height = std::max(page.height, p.y + (p.turned ? shapes[i].width : shapes[i].height));
  }
  return packing;
}

}  // namespace gpvc
