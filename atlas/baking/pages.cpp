#include "atlas/baking/pages.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>

#include "io/freed_memory.h"
#include "io/push_pull.h"

namespace gpvc::atlas {

Page::Page(const PageSize& blocks, int edge) : block(edge) {
  image.width = edge * blocks.width;
  image.height = edge * blocks.height;
  block_owner.assign(static_cast<std::size_t>(blocks.width) * static_cast<std::size_t>(blocks.height), kNoOwner);
}

void Page::open() {
  image.pixels.assign(3 * texels(), 0);
  state.assign(texels(), TexelState::empty);
}

void Page::spill(io::ScratchFile& file, std::size_t place) {
  file.write(place, image.pixels.data(), image.pixels.size());
  file.write(place + image.pixels.size(), state.data(), state.size());
  free_memory(image.pixels);
  free_memory(state);
}

void Page::reload(const io::ScratchFile& file, std::size_t place) {
  open();
  file.read(place, image.pixels.data(), image.pixels.size());
  file.read(place + image.pixels.size(), state.data(), state.size());
}

Image Page::close() {
  Image whole = std::move(image);
  image = {whole.width, whole.height, whole.channels, {}};
  free_memory(state);
  return whole;
}

std::vector<ChartPlace> chart_places(std::span<const ChartShape> shapes, const Packing& packing, int edge) {
  std::vector<ChartPlace> places(shapes.size());
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    const Placement& p = packing.placements[i];
    const ChartShape& s = shapes[i];
    places[i] = {p.page,    edge * p.x, edge * p.y, p.turns, edge * s.blocks.width, edge * s.blocks.height,
                 s.inset_x, s.inset_y};
  }
  return places;
}

std::vector<Page> make_pages(std::span<const ChartShape> shapes, const Packing& packing, int edge) {
  std::vector<Page> pages;
  for (const PageSize& size : packing.pages) pages.emplace_back(size, edge);
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    const PackShape& shape = shapes[i].blocks;
    const Placement& p = packing.placements[i];
    const ChartPlace in_blocks{p.page, p.x, p.y, p.turns, shape.width, shape.height, 0, 0};
    Page& page = pages[p.page];
    for (const CellRun& run : shape.runs) {
      for (int x = run.first; x < run.first + run.length; ++x) {
        const auto at = in_blocks.texel(x, run.row);
        page.block_owner[pixel_index(at.x, at.y, packing.pages[p.page].width)] = static_cast<std::uint32_t>(i);
      }
    }
  }
  return pages;
}

namespace {

/// Grows the padding layer by layer. The texels of a layer turn from empty to padding only when all of them have been
/// computed, so none reads another and their order does not matter.
class Padder {
 public:
  explicit Padder(Page& page)
      : page_(page), width_(page.image.width), height_(page.image.height), queued_(page.state.size(), 0) {}

  std::size_t pad(int padding) {
    std::vector<std::uint32_t> layer = first_layer();
    std::size_t padded = 0;
    for (int round = 0; !layer.empty(); ++round) {
      tbb::parallel_for(tbb::blocked_range<std::size_t>(0, layer.size(), kPart), [&](const auto& range) {
        for (std::size_t k = range.begin(); k < range.end(); ++k) take_mean(layer[k]);
      });
      for (const auto i : layer) page_.state[i] = TexelState::padding;
      if (round < padding) padded += layer.size();
      layer = next_layer(layer, round + 1 < padding);
    }
    return padded;
  }

 private:
  static constexpr std::size_t kPart = 4096;  ///< texels that one task looks at

  struct Neighbour {
    std::uint32_t texel, owner;
    bool diagonal;
  };

  /// Calls visit(neighbour, owner of the texel itself).
  template <typename Visit>
  void for_neighbours(std::uint32_t i, const Visit& visit) const {
    const int x = static_cast<int>(i % static_cast<std::uint32_t>(width_));
    const int y = static_cast<int>(i / static_cast<std::uint32_t>(width_));
    const std::uint32_t own = page_.owner(x, y);
    const auto inside = [edge = page_.block](int at) { return at % edge > 0 && at % edge < edge - 1; };
    const bool in_block = inside(x) && inside(y);
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx)
        if ((dx || dy) && x + dx >= 0 && x + dx < width_ && y + dy >= 0 && y + dy < height_)
          visit(Neighbour{static_cast<std::uint32_t>(page_.at(x + dx, y + dy)),
                          in_block ? own : page_.owner(x + dx, y + dy), dx && dy},
                own);
  }

  /// Colours of a chart do not enter blocks that another chart owns.
  static bool may_pass(std::uint32_t from_owner, std::uint32_t to_owner) {
    return to_owner == kNoOwner || to_owner == from_owner;
  }

  /// The texels that add_texels(part, list) lists for each of so many parts.
  template <typename AddTexels>
  std::vector<std::uint32_t> collect(std::size_t parts, const AddTexels& add_texels) {
    std::vector<std::vector<std::uint32_t>> lists(parts);
    tbb::parallel_for(std::size_t{0}, parts, [&](std::size_t part) { add_texels(part, lists[part]); });
    std::vector<std::uint32_t> all;
    for (const auto& list : lists) all.insert(all.end(), list.begin(), list.end());
    return all;
  }

  /// True for the first caller that asks for the texel, on any thread.
  bool enqueue(std::uint32_t i) { return std::atomic_ref(queued_[i]).exchange(1, std::memory_order_relaxed) == 0; }

  /// Ring texels, which have their colour already, and empty texels beside chart texels.
  std::vector<std::uint32_t> first_layer() {
    return collect(static_cast<std::size_t>(height_), [&](std::size_t y, std::vector<std::uint32_t>& list) {
      for (int x = 0; x < width_; ++x) {
        const auto i = static_cast<std::uint32_t>(page_.at(x, static_cast<int>(y)));
        bool first = page_.state[i] == TexelState::ring;
        if (page_.state[i] == TexelState::empty)
          for_neighbours(i, [&](const Neighbour& n, std::uint32_t own) {
            first |= page_.state[n.texel] == TexelState::chart && may_pass(n.owner, own);
          });
        if (first && enqueue(i)) list.push_back(i);
      }
    });
  }

  std::vector<std::uint32_t> next_layer(const std::vector<std::uint32_t>& layer, bool into_free_blocks) {
    return collect((layer.size() + kPart - 1) / kPart, [&](std::size_t part, std::vector<std::uint32_t>& list) {
      const std::size_t end = std::min(layer.size(), (part + 1) * kPart);
      for (std::size_t k = part * kPart; k < end; ++k)
        for_neighbours(layer[k], [&](const Neighbour& n, std::uint32_t own) {
          if (page_.state[n.texel] != TexelState::empty || !may_pass(own, n.owner)) return;
          if (!into_free_blocks && n.owner == kNoOwner) return;
          if (enqueue(n.texel)) list.push_back(n.texel);
        });
    });
  }

  void take_mean(std::uint32_t i) {
    if (page_.state[i] == TexelState::ring) return;
    ColorMean mean;
    for_neighbours(i, [&](const Neighbour& n, std::uint32_t own) {
      if (page_.state[n.texel] != TexelState::empty && may_pass(n.owner, own))
        mean.add(load(page_.image.pixels.data() + std::size_t{3} * n.texel), n.diagonal ? 0.5f : 1.0f);
    });
    store(page_.image.pixels.data() + std::size_t{3} * i, *mean.mean());
  }

  Page& page_;
  int width_, height_;
  std::vector<std::uint8_t> queued_;
};

}  // namespace

std::size_t pad_charts(Page& page, int padding) {
  const auto inside = std::count(page.state.begin(), page.state.end(), TexelState::chart);
  return static_cast<std::size_t>(inside) + Padder(page).pad(padding);
}

void fill_background(Page& page) {
  std::vector<std::uint8_t> known(page.state.size());
  std::transform(page.state.begin(), page.state.end(), known.begin(),
                 [](TexelState s) { return s != TexelState::empty; });
  io::fill_holes(page.image, known, true);
}

void PageMean::add(const Page& page) {
  for (std::size_t i = 0; i < page.state.size(); ++i) {
    if (page.state[i] == TexelState::empty) continue;
    ++count_;
    for (std::size_t k = 0; k < 3; ++k) sum_[k] += page.image.pixels[3 * i + k];
  }
}

void PageMean::add(const PageMean& other) {
  for (std::size_t k = 0; k < 3; ++k) sum_[k] += other.sum_[k];
  count_ += other.count_;
}

Color PageMean::mean() const {
  if (count_ == 0) return {128, 128, 128};
  const auto share = [&](std::uint64_t sum) {
    return static_cast<float>(static_cast<double>(sum) / static_cast<double>(count_));
  };
  return {share(sum_[0]), share(sum_[1]), share(sum_[2])};
}

}  // namespace gpvc::atlas
