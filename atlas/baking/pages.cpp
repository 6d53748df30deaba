#include "atlas/baking/pages.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cstring>

#include "io/freed_memory.h"
#include "io/provided_memory.h"
#include "io/push_pull.h"

namespace gpvc::atlas {

Page::Page(const PageSize& blocks, int edge, const BandSet* bands) : block(edge) {
  image.width = edge * blocks.width;
  image.height = edge * blocks.height;
  if (bands != nullptr) samples = {image.width, image.height, bands->bands.size(), bands->type, {}};
  block_owner.assign(static_cast<std::size_t>(blocks.width) * static_cast<std::size_t>(blocks.height), kNoOwner);
}

void Page::open() {
  image.pixels = filled(3 * texels(), std::uint8_t{0});
  samples.bytes = filled(samples.pixel_bytes() * texels(), std::byte{0});
  state = filled(texels(), TexelState::empty);
}

namespace {

/// Calls visit(bytes, count) for all that a page spills.
template <typename SomePage, typename Visit>
void for_texels(SomePage& page, const Visit& visit) {
  visit(page.image.pixels.data(), page.image.pixels.size());
  visit(page.samples.bytes.data(), page.samples.bytes.size());
  visit(page.state.data(), page.state.size());
}

}  // namespace

void Page::spill(io::ScratchFile& file, std::size_t place) {
  for_texels(*this, [&](const void* bytes, std::size_t count) {
    file.write(place, bytes, count);
    place += count;
  });
  drop();
}

void Page::drop() {
  image.pixels = {};
  free_memory(samples.bytes);
  free_memory(state);
  if (is_given) free_memory(block_owner);
}

void Page::reload(const io::ScratchFile& file, std::size_t place) {
  for_texels(*this, [&](void* bytes, std::size_t count) {
    file.read(place, bytes, count);
    place += count;
  });
}

FinishedPage Page::close() {
  FinishedPage whole{std::move(image), {std::move(samples), {}}};
  image = {whole.image.width, whole.image.height, whole.image.channels, {}};
  const Samples& given = whole.bands.samples;
  samples = {given.width, given.height, given.bands, given.type, {}};
  if (given.bands > 0) {
    whole.bands.charts.resize(state.size());
    std::ranges::transform(state, whole.bands.charts.begin(),
                           [](TexelState s) { return static_cast<std::uint8_t>(s == TexelState::chart ? 255 : 0); });
  }
  free_memory(state);
  if (is_given) free_memory(block_owner);
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

std::vector<Page> make_pages(std::span<const ChartShape> shapes, const Packing& packing, int edge,
                             const BandSet* bands) {
  std::vector<Page> pages;
  for (const PageSize& size : packing.pages) pages.emplace_back(size, edge, bands);
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

std::vector<Page> given_pages(const Packing& packing, const BandSet* bands) {
  std::vector<Page> pages;
  for (const PageSize& size : packing.pages) {
    Page& page = pages.emplace_back(PageSize{}, 1, bands);
    page.image.width = page.samples.width = size.width;
    page.image.height = page.samples.height = size.height;
    page.is_given = true;
  }
  return pages;
}

namespace {

/// Grows the padding layer by layer. No texel of a layer reads another of it, so their order does not matter.
///
/// The page is divided into bands of a few rows, which each layer visits from top to bottom, three behind the layer before:
/// what many layers read is then still in the processor's cache. At any time, with layer k in band b:
///
///     b - 4, b - 3, b - 2    read, listed for layer k + 2, or turned to padding by layer k + 1
///     b - 1                  turns to padding: band b, which must not read it, has been computed
///     b                      computed by layer k
///     b - 1, b, b + 1        texels around are listed for layer k + 1
///
/// so that all layers work at the same time. A texel gets the number of the first layer that reaches it, as it would layer
/// after layer: layer k has left the bands around a texel before layer k + 1 enters them.
class Padder {
 public:
  explicit Padder(Page& page)
      : page_(page),
        width_(page.image.width),
        height_(page.image.height),
        bands_(static_cast<std::size_t>(height_ + kBandRows - 1) / kBandRows) {}

  std::size_t pad(int padding) {
    layers_.push_back(first_layer());
    add_layer();
    for (std::size_t step = 0;; ++step) {
      // The last layer of the list is empty so far.
      const std::size_t begun = layers_.size() - 1, end = std::min(begun, step / kBandsBehind + 1);
      const std::size_t first = step < bands_ ? 0 : (step - bands_) / kBandsBehind + 1;
      if (first >= begun) break;
      tbb::parallel_for(
          first, end,
          [&](std::size_t k) {
            visit(layers_[k], layers_[k + 1], step - kBandsBehind * k, static_cast<int>(k) + 1 < padding);
          },
          tbb::simple_partitioner());
      if (layers_.back().texels > 0) add_layer();
    }
    std::size_t padded = 0;
    for (std::size_t k = 0; k < std::min(layers_.size(), static_cast<std::size_t>(padding)); ++k)
      padded += layers_[k].texels;
    return padded;
  }

 private:
  static constexpr int kBandRows = 4;
  static constexpr std::size_t kBandsBehind = 3;

  struct Texel {
    int x, y;
  };
  struct Neighbour {
    Texel texel;
    std::size_t at;
    std::uint32_t owner;
    bool diagonal;
  };
  using Bands = std::vector<std::vector<Texel>>;
  struct PaddingLayer {
    Bands bands;         ///< texels that are not padding yet
    std::size_t texels;  ///< listed so far, in all
  };

  static std::size_t band_of(int y) { return static_cast<std::size_t>(y) / kBandRows; }
  void add_layer() { layers_.push_back({Bands(bands_), 0}); }

  /// Calls visit(neighbour, owner of the texel itself).
  template <typename Visit>
  void for_neighbours(const Texel& t, const Visit& visit) const {
    const std::uint32_t own = page_.owner(t.x, t.y);
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        const Texel n{t.x + dx, t.y + dy};
        if ((dx || dy) && n.x >= 0 && n.x < width_ && n.y >= 0 && n.y < height_)
          visit(Neighbour{n, page_.at(n.x, n.y), page_.owner(n.x, n.y), dx && dy}, own);
      }
  }

  /// True for most texels: the neighbours lie in the same block, and so on the page.
  bool is_inside_block(const Texel& t) const {
    const auto inside = [last = page_.block - 1](int at) { return (at & last) > 0 && (at & last) < last; };
    return inside(t.x) && inside(t.y);
  }

  /// Colours of a chart do not enter blocks that another chart owns.
  static bool may_pass(std::uint32_t from_owner, std::uint32_t to_owner) {
    return to_owner == kNoOwner || to_owner == from_owner;
  }

  /// Ring texels, which have their colour already, and empty texels beside chart texels.
  PaddingLayer first_layer() {
    PaddingLayer layer{Bands(bands_), 0};
    tbb::parallel_for(std::size_t{0}, bands_, [&](std::size_t band) {
      const int first = static_cast<int>(band) * kBandRows;
      for (int y = first; y < std::min(first + kBandRows, height_); ++y) add_first_of_row(y, layer.bands[band]);
    });
    for (const std::vector<Texel>& band : layer.bands) {
      layer.texels += band.size();
      for (const Texel& t : band) enqueue(page_.at(t.x, t.y));
    }
    return layer;
  }

  void add_first_of_row(int y, std::vector<Texel>& list) {
    for (int x = 0; x < width_; ++x) {
      if (x % kWord == 0 && has_none_of_first(x, y)) {
        x += kWord - 1;
        continue;
      }
      const TexelState state = page_.state[page_.at(x, y)];
      bool first = state == TexelState::ring;
      if (state == TexelState::empty)
        for_neighbours({x, y}, [&](const Neighbour& n, std::uint32_t own) {
          first |= page_.state[n.at] == TexelState::chart && may_pass(n.owner, own);
        });
      if (first) list.push_back({x, y});
    }
  }

  static constexpr int kWord = 8;  ///< texels that are looked at together

  std::uint64_t states_from(int x, int y) const {
    std::uint64_t states = 0;
    std::memcpy(&states, &page_.state[page_.at(x, y)], kWord);
    return states;
  }

  /// True for most words without a texel of the first layer: all chart, or all empty and not beside a chart.
  bool has_none_of_first(int x, int y) const {
    constexpr std::uint64_t kChart = 0x0101010101010101;  // TexelState::chart, of which a ring has no bit
    if (x == 0 || x + kWord >= width_) return false;
    const std::uint64_t states = states_from(x, y);
    if (states != 0) return states == kChart;
    std::uint64_t around = 0;
    for (int near_y = std::max(0, y - 1); near_y <= std::min(y + 1, height_ - 1); ++near_y)
      around |= states_from(x - 1, near_y) | states_from(x + 1, near_y);
    return (around & kChart) == 0;
  }

  /// Computes the colours of a layer's texels in a band, lists those of the next layer around them, and turns the band above
  /// to padding.
  void visit(PaddingLayer& layer, PaddingLayer& next, std::size_t band, bool into_free_blocks) {
    for (const Texel& t : layer.bands[band]) {
      take_mean(t);
      add_next(t, into_free_blocks, next);
    }
    if (band > 0) turn_to_padding(layer.bands[band - 1]);
    if (band + 1 == bands_) turn_to_padding(layer.bands[band]);
  }

  void turn_to_padding(std::vector<Texel>& texels) {
    for (const Texel& t : texels) page_.state[page_.at(t.x, t.y)] = TexelState::padding;
    free_memory(texels);
  }

  /// Lists the empty texels around one of a layer, each once.
  void add_next(const Texel& t, bool into_free_blocks, PaddingLayer& next) {
    const auto add = [&](const Texel& n) {
      next.bands[band_of(n.y)].push_back(n);
      ++next.texels;
    };
    if (is_inside_block(t)) {
      if (!into_free_blocks && page_.owner(t.x, t.y) == kNoOwner) return;
      for (int y = t.y - 1; y <= t.y + 1; ++y)
        for (int x = t.x - 1; x <= t.x + 1; ++x)
          if (enqueue(page_.at(x, y))) add({x, y});
      return;
    }
    for_neighbours(t, [&](const Neighbour& n, std::uint32_t own) {
      if (!may_pass(own, n.owner) || (!into_free_blocks && n.owner == kNoOwner)) return;
      if (enqueue(n.at)) add(n.texel);
    });
  }

  /// True for the first call for an empty texel.
  bool enqueue(std::size_t at) {
    if (page_.state[at] != TexelState::empty) return false;
    page_.state[at] = TexelState::next;
    return true;
  }

  /// Those that are neither empty nor of the layers to come.
  bool has_color(std::size_t at) const {
    const TexelState state = page_.state[at];
    return state != TexelState::empty && state != TexelState::next;
  }

  /// The sum of colours around a texel, those across an edge twice, as three numbers of 16 bits, and the sum of the weights in a
  /// fourth.
  struct Sum {
    std::uint64_t channels = 0;
    void add(const std::uint8_t* rgb, unsigned weight) {
      channels +=
          weight * (rgb[0] | std::uint64_t{rgb[1]} << 16 | std::uint64_t{rgb[2]} << 32 | std::uint64_t{1} << 48);
    }
    unsigned operator[](std::size_t channel) const {
      return static_cast<unsigned>(channels >> (16 * channel)) & 0xFFFFu;
    }
    /// The channel's sum over that of the weights, rounded half up.
    std::uint8_t mean(std::size_t channel) const {
      const unsigned weight = (*this)[3];
      return static_cast<std::uint8_t>((2 * (*this)[channel] + weight) * kReciprocals[weight] >> kReciprocalBits);
    }
  };

  static constexpr unsigned kMostWeight = 4 * 2 + 4 * 1;
  static constexpr unsigned kReciprocalBits = 18;
  /// m = 2^18 / (2 w), rounded up, so that m 2w = 2^18 + e with e < 2w. For n = 2 sum + w <= 511 w the product n m / 2^18 is n e /
  /// (2w 2^18) above n / 2w, which is 1 / 2w or more below the next whole number: the same when rounded down where n e < 2^18,
  /// and n e < 1022 w^2.
  static constexpr std::array<std::uint32_t, kMostWeight + 1> kReciprocals = [] {
    std::array<std::uint32_t, kMostWeight + 1> all{};
    for (unsigned w = 1; w <= kMostWeight; ++w) all[w] = ((1u << kReciprocalBits) + 2 * w - 1) / (2 * w);
    return all;
  }();
  static_assert(1022 * kMostWeight * kMostWeight < 1u << kReciprocalBits);

  void take_mean(const Texel& t) {
    const std::size_t at = page_.at(t.x, t.y);
    if (page_.state[at] == TexelState::ring) return;
    Sum sum;
    std::uint8_t* const pixels = page_.image.pixels.data();
    if (is_inside_block(t)) {
      const auto width = static_cast<std::size_t>(width_);
      for (const std::size_t row : {at - width, at, at + width}) {
        const unsigned across = row == at ? 2 : 1;
        if (has_color(row - 1)) sum.add(pixels + 3 * (row - 1), across);
        if (row != at && has_color(row)) sum.add(pixels + 3 * row, 2);
        if (has_color(row + 1)) sum.add(pixels + 3 * (row + 1), across);
      }
    } else {
      for_neighbours(t, [&](const Neighbour& n, std::uint32_t own) {
        if (has_color(n.at) && may_pass(n.owner, own)) sum.add(pixels + 3 * n.at, n.diagonal ? 1 : 2);
      });
    }
    for (std::size_t c = 0; c < 3; ++c) pixels[3 * at + c] = sum.mean(c);
    for (std::size_t layer = 1; layer < page_.layers(); ++layer) take_mean(t, layer);
  }

  void take_mean(const Texel& t, std::size_t number) {
    const PageLayer layer = page_.layer(number);
    ColorMean mean;
    for_neighbours(t, [&](const Neighbour& n, std::uint32_t own) {
      if (has_color(n.at) && may_pass(n.owner, own)) mean.add(layer.at(n.at), n.diagonal ? 1 : 2);
    });
    layer.put(page_.at(t.x, t.y), mean.mean().value_or(Color{}));
  }

  Page& page_;
  int width_, height_;
  std::size_t bands_;
  std::vector<PaddingLayer> layers_;
};

}  // namespace

std::size_t pad_charts(Page& page, int padding) { return Padder(page).pad(padding); }

void fill_background(Page& page) {
  static_assert(TexelState::empty == TexelState{0});
  io::fill_holes(page.image, {reinterpret_cast<const std::uint8_t*>(page.state.data()), page.state.size()}, true);
}

void PageMean::add(const Page& page) {
  constexpr std::size_t kPart = 1 << 20;  // on any number of threads, so that sums are rounded alike
  std::vector<PageMean> parts((page.state.size() + kPart - 1) / kPart);
  tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t part) {
    parts[part].add(page, part * kPart, std::min(page.state.size(), (part + 1) * kPart));
  });
  for (const PageMean& part : parts) add(part);
}

void PageMean::add(const Page& page, std::size_t begin, std::size_t end) {
  layers_.resize(page.layers() - 1);
  for (std::size_t i = begin; i < end; ++i) {
    if (page.state[i] == TexelState::empty) continue;
    ++count_;
    for (std::size_t k = 0; k < 3; ++k) sum_[k] += page.image.pixels[3 * i + k];
    for (std::size_t l = 0; l < layers_.size(); ++l) {
      const Color color = page.layer(l + 1).at(i);
      layers_[l][0] += double{color.r};
      layers_[l][1] += double{color.g};
      layers_[l][2] += double{color.b};
    }
  }
}

void PageMean::add(const PageMean& other) {
  for (std::size_t k = 0; k < 3; ++k) sum_[k] += other.sum_[k];
  layers_.resize(std::max(layers_.size(), other.layers_.size()));
  for (std::size_t l = 0; l < other.layers_.size(); ++l)
    for (std::size_t k = 0; k < 3; ++k) layers_[l][k] += other.layers_[l][k];
  count_ += other.count_;
}

Color PageMean::mean(std::size_t layer) const {
  const auto share = [&](double sum) { return static_cast<float>(sum / static_cast<double>(count_)); };
  if (layer == 0) {
    if (count_ == 0) return {128, 128, 128};
    return {share(static_cast<double>(sum_[0])), share(static_cast<double>(sum_[1])),
            share(static_cast<double>(sum_[2]))};
  }
  if (count_ == 0) return {};
  const std::array<double, 3>& sum = layers_[layer - 1];
  return {share(sum[0]), share(sum[1]), share(sum[2])};
}

}  // namespace gpvc::atlas
