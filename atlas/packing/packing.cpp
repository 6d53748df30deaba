#include "atlas/packing/packing.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <random>
#include <tuple>

#include "atlas/packing/page_cells.h"

namespace gpvc::atlas {

namespace {

/// With more shapes than this, small ones fill the gaps in any order, and trying several orders would cost too much.
constexpr std::size_t kManyShapes = 8000;
/// Bytes of the pages that attempts fill side by side, unless a single page takes more.
constexpr std::size_t kMostBytes = std::size_t{256} << 20;

using Turns = std::array<TurnedShape, 4>;

std::int64_t cell_count(const PackShape& shape) {
  std::int64_t count = 0;
  for (const auto& run : shape.runs) count += run.length;
  return count;
}

enum class Order { area, longest_edge, height };

struct Attempt {
  Order order;
  double fill;             ///< share of a near-square last page that its shapes are expected to cover
  std::uint32_t seed = 0;  ///< 0: strictly in order; otherwise shapes of similar size are shuffled
};

/// Shapes from large to small.
std::vector<std::uint32_t> placement_order(std::span<const PackShape> shapes, const Attempt& how) {
  constexpr double kShuffle = 0.7;  // sizes within a factor of e^1.4 may change places
  std::vector<double> key(shapes.size());
  std::mt19937 random(how.seed);
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    const PackShape& s = shapes[i];
    const std::int64_t size = how.order == Order::area           ? cell_count(s)
                              : how.order == Order::longest_edge ? std::max(s.width, s.height)
                                                                 : std::min(s.width, s.height);
    key[i] = static_cast<double>(size);
    // Scaled by hand, because standard distributions differ between libraries.
    if (how.seed) key[i] *= std::exp(kShuffle * (static_cast<double>(random()) / 0x80000000u - 1));
  }
  std::vector<std::uint32_t> order(shapes.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return key[a] > key[b]; });
  return order;
}

/// Shapes of one class skip the rows where an earlier one of the class found no room. Small boxes have a class per
/// size. Larger boxes have none if there are few shapes, so that each is tried from the first row; if there are many,
/// boxes that differ by up to an eighth share a class.
std::optional<std::pair<int, int>> size_class(const TurnedShape& shape, bool many) {
  constexpr int kExact = 16;  // cells
  if (!many && (shape.width > kExact || shape.height > kExact)) return std::nullopt;
  const auto coarse = [&](int edge) {
    if (edge <= kExact) return edge;
    return kExact + static_cast<int>(std::log(double(edge) / kExact) / std::log(1.125));
  };
  return std::pair(coarse(shape.width), coarse(shape.height));
}

struct OpenPage {
  PageCells cells;
  std::map<std::pair<int, int>, int> first_row;  ///< per size class: earlier rows have been searched
};

/// \param limit the shape must end before this row
std::optional<Position> search(OpenPage& page, const TurnedShape& shape, int limit, bool many) {
  const auto key = size_class(shape, many);
  if (!key) return page.cells.find(shape, 0, limit);
  int& start = page.first_row[*key];
  const auto found = page.cells.find(shape, start, limit);
  if (found || limit >= page.cells.height()) start = found ? found->y : std::numeric_limits<int>::max() / 2;
  return found;
}

/// Numbers of the pages to be filled.
struct PageRange {
  std::uint32_t first = 0, most = std::numeric_limits<std::uint32_t>::max();
};

class Packer {
 public:
  Packer(std::span<const PackShape> shapes, bool many) : turns_(shapes.size()), many_(many) {
    tbb::parallel_for(std::size_t{0}, shapes.size(), [&](std::size_t i) {
      PackShape shape = shapes[i];
      for (std::size_t t = 0; t < turns(); ++t) turns_[i][t] = TurnedShape(std::exchange(shape, quarter_turn(shape)));
    });
  }

  /// Places shapes on pages of the given size: lot after lot, each in its order, on its own pages or in gaps of the one
  /// before. False if they do not fit in the range's pages.
  bool place(std::span<const std::vector<std::uint32_t>> lots, PageSize size, const PageRange& range,
             std::vector<Placement>& placements) const {
    std::vector<OpenPage> pages;
    for (const auto& lot : lots) {
      const auto first = static_cast<std::uint32_t>(std::max<std::size_t>(pages.size(), 1) - 1);
      for (const auto i : lot) {
        for (std::uint32_t p = first;; ++p) {
          if (p == pages.size()) {
            if (p == range.most) return false;
            pages.push_back({PageCells(size.width, size.height), {}});
          }
          if (const auto put = place_on(pages[p], turns_[i])) {
            placements[i] = {range.first + p, put->first.x, put->first.y, put->second};
            break;
          }
        }
      }
      // Earlier pages are not searched again.
      for (std::size_t p = 0; p + 1 < pages.size(); ++p) pages[p] = {PageCells(0, 0), {}};
    }
    return true;
  }

 private:
  /// With many shapes, half turns gain nothing.
  std::size_t turns() const { return many_ ? 2 : 4; }

  std::optional<std::pair<Position, int>> place_on(OpenPage& page, const Turns& turned) const {
    std::optional<std::pair<Position, int>> best;
    int best_end = page.cells.height() + 1;
    for (std::size_t t = 0; t < turns(); ++t) {
      const TurnedShape& shape = turned[t];
      const auto at = search(page, shape, std::min(page.cells.height(), best_end), many_);
      if (!at) continue;
      const int end = at->y + shape.height;
      if (best && std::tuple(end, at->x) >= std::tuple(best_end, best->first.x)) continue;
      best = std::pair(*at, static_cast<int>(t));
      best_end = end;
    }
    if (best) page.cells.occupy(turned[static_cast<std::size_t>(best->second)], best->first);
    return best;
  }

  std::vector<Turns> turns_;
  bool many_;
};

std::vector<PageSize> page_sizes(std::span<const PackShape> shapes, const std::vector<Placement>& placements) {
  std::vector<PageSize> pages;
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    const Placement& p = placements[i];
    if (p.page >= pages.size()) pages.resize(p.page + 1);
    const PackShape& s = shapes[i];
    const int across = p.turns % 2 ? s.height : s.width, down = p.turns % 2 ? s.width : s.height;
    PageSize& page = pages[p.page];
    page.width = std::max(page.width, p.x + across);
    page.height = std::max(page.height, p.y + down);
  }
  return pages;
}

std::int64_t texels(const std::vector<PageSize>& pages) {
  std::int64_t sum = 0;
  for (const auto& p : pages) sum += std::int64_t{p.width} * p.height;
  return sum;
}

/// Measured on real charts, orders and widths differ by 3 % of the texels, shuffled orders by as much again, and none
/// is best everywhere. The number of attempts is such that the time hardly depends on the number of shapes.
std::vector<Attempt> attempts(std::size_t shapes) {
  if (shapes > kManyShapes) return {{Order::area, 0.95}};
  constexpr std::size_t kPlacements = 24000;
  std::vector<Attempt> tries{
      {Order::area, 0.98}, {Order::area, 0.89}, {Order::longest_edge, 0.95}, {Order::height, 0.89}};
  const std::size_t shuffled = std::min<std::size_t>(28, kPlacements / (shapes + 1));
  for (std::uint32_t i = 1; i <= shuffled; ++i)
    tries.push_back({i % 3 ? Order::area : Order::longest_edge, 0.85 + 0.013 * (7 * i % 11), i});
  return tries;
}

/// Width of a near-square page for the shapes, at least the shorter edge of each.
int square_width(std::span<const PackShape> shapes, std::span<const std::uint32_t> which, double fill) {
  std::int64_t area = 0;
  int least = 0;
  for (const auto i : which) {
    area += cell_count(shapes[i]);
    least = std::max(least, std::min(shapes[i].width, shapes[i].height));
  }
  return std::max(least, static_cast<int>(std::ceil(std::sqrt(static_cast<double>(area) / fill))));
}

/// Divides shapes, large to small, by rank into lots that fill a page each.
std::vector<std::vector<std::uint32_t>> lots_by_rank(std::span<const PackShape> shapes,
                                                     const std::vector<std::uint32_t>& order, int page_size) {
  // Shapes of real charts cover up to nine tenths of a page.
  const std::int64_t most = std::int64_t{page_size} * page_size * 9 / 10;
  std::vector<std::uint32_t> ranked = order;
  std::ranges::stable_sort(ranked, {}, [&](std::uint32_t i) { return shapes[i].rank; });
  std::vector<std::uint32_t> lot_of(shapes.size(), 0);
  std::int64_t cells = 0;
  for (const auto i : ranked) lot_of[i] = static_cast<std::uint32_t>((cells += cell_count(shapes[i])) / most);
  std::vector<std::vector<std::uint32_t>> lots(ranked.empty() ? 0 : lot_of[ranked.back()] + 1);
  for (const auto i : order) lots[lot_of[i]].push_back(i);
  return lots;
}

std::vector<Placement> attempt(const Packer& packer, std::span<const PackShape> shapes, int page_size,
                               const Attempt& how) {
  std::vector<Placement> placements(shapes.size());
  const std::vector<std::uint32_t> order = placement_order(shapes, how);
  const auto on_one_page = [&](const std::vector<std::uint32_t>& which, std::uint32_t page,
                               std::vector<Placement>& at) {
    const int width = square_width(shapes, which, how.fill);
    return width < page_size && packer.place({&which, 1}, {width, page_size}, {page, 1}, at);
  };
  if (on_one_page(order, 0, placements)) return placements;
  packer.place(lots_by_rank(shapes, order, page_size), {page_size, page_size}, {}, placements);
  // The last page's shapes are placed again, near-square instead of in a wide strip.
  std::uint32_t last = 0;
  for (const auto& p : placements) last = std::max(last, p.page);
  std::vector<std::uint32_t> rest;
  for (const auto i : order)
    if (placements[i].page == last) rest.push_back(i);
  std::vector<Placement> narrow = placements;
  return on_one_page(rest, last, narrow) ? narrow : placements;
}

}  // namespace

Packing pack_shapes(std::span<const PackShape> shapes, int page_size) {
  if (shapes.empty()) return {};
  for ([[maybe_unused]] const auto& shape : shapes) assert(shape.width <= page_size && shape.height <= page_size);
  const bool many = shapes.size() > kManyShapes;
  const Packer packer(shapes, many);
  const std::vector<Attempt> tries = attempts(shapes.size());
  std::vector<Packing> results(tries.size());
  // An attempt holds the cells of a page at a time, of which there are as many as texels where the padding is 1.
  const std::size_t at_once = std::max<std::size_t>(1, kMostBytes / PageCells::bytes(page_size, page_size));
  for (std::size_t begin = 0; begin < tries.size(); begin += at_once)
    tbb::parallel_for(begin, std::min(begin + at_once, tries.size()), [&](std::size_t k) {
      results[k].placements = attempt(packer, shapes, page_size, tries[k]);
      results[k].pages = page_sizes(shapes, results[k].placements);
    });
  // Fewer pages come first: each is a material of the model and a texture to bind.
  return std::move(*std::ranges::min_element(
      results, {}, [](const Packing& result) { return std::pair(result.pages.size(), texels(result.pages)); }));
}

}  // namespace gpvc::atlas
