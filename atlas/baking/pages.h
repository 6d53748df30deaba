// Pages under construction, and the places of charts on them.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "atlas/atlas.h"
#include "atlas/charts/chart_raster.h"
#include "atlas/charts/chart_shape.h"
#include "atlas/charts/charts.h"
#include "atlas/packing/packing.h"
#include "atlas/sampling/color.h"
#include "atlas/sampling/layers.h"
#include "io/image.h"
#include "io/scratch_file.h"

namespace gpvc::atlas {

enum class TexelState : std::uint8_t {
  empty = 0,
  chart = 1,
  ring = 2,
  padding = 3,
  next = 4  ///< becomes padding; only while charts are padded
};

/// True for texels that take their colour from photos. Without padding there is no ring either.
inline bool is_baked(TexelReach reach, int padding) {
  return reach != TexelReach::outside && (reach != TexelReach::ring || padding > 0);
}

/// The state of a baked texel. \pre not outside
inline TexelState state_of(TexelReach reach) {
  return reach == TexelReach::ring ? TexelState::ring : TexelState::chart;
}

/// What a page holds in the end.
struct FinishedPage {
  Image image;
  PageSamples bands;
};

/// Has texels while it is open. Until it is opened, while it is spilled and after it is closed it has the size of its image
/// alone, and the bands of its samples.
struct Page {
  Image image;
  Samples samples;                         ///< of the image's size; no bands: none
  std::vector<TexelState> state;           ///< per texel
  int block = 1;                           ///< edge of the blocks, which no two charts share; a power of two
  std::vector<std::uint32_t> block_owner;  ///< per block, row-major: a chart, or kNoOwner
  bool is_given = false;                   ///< of a given layout: block_owner is there while the page is open alone

  /// \param blocks size of the page in blocks
  /// \param edge of a block, texels
  /// \param bands that it has beside its image; null: none
  Page(const PageSize& blocks, int edge, const BandSet* bands);
  std::size_t texels() const { return pixel_index(0, image.height, image.width); }
  /// Bytes that an open page takes at most.
  std::size_t bytes() const {
    const double of_texel = page_bytes_per_texel(samples.pixel_bytes()) + (is_given ? kOwnerBytesPerTexel : 0);
    return static_cast<std::size_t>(of_texel * static_cast<double>(texels()));
  }
  /// Bytes of a file that it is spilled to.
  std::size_t spilled_bytes() const { return (4 + samples.pixel_bytes()) * texels(); }
  bool is_open() const { return !state.empty(); }
  /// See AtlasBuild::open().
  void open();
  /// Moves the texels to a file; reload() gets them back, into an open page, from the same place, which has room for
  /// spilled_bytes(). Throws OutputError.
  void spill(io::ScratchFile& file, std::size_t place);
  void reload(const io::ScratchFile& file, std::size_t place);
  /// Frees the texels.
  void drop();
  /// Gives image and samples away; what is left has their size.
  FinishedPage close();
  std::size_t layers() const { return 1 + (samples.bands + 2) / 3; }
  Layer layer(std::size_t number) const { return layer_of(image, &samples, number); }
  PageLayer layer(std::size_t number) {
    const Layer l = std::as_const(*this).layer(number);
    return {l.width, l.height, const_cast<std::byte*>(l.first), l.pixel_bytes, l.channels, l.type};
  }
  std::uint32_t owner(int x, int y) const {
    const int shift = std::countr_zero(static_cast<unsigned>(block));
    return block_owner[pixel_index(x >> shift, y >> shift, image.width >> shift)];
  }
  /// Whether a face of a chart, whose corners are given, shows a texel. Charts of a given layout may touch others, whose texels it
  /// does not show, and lie over others, whose texels it shows.
  bool shows(std::uint32_t chart, const TexelTriangle& face, int x, int y) const {
    return owner(x, y) == chart || contains(face, x + 0.5, y + 0.5);
  }
  std::size_t at(int x, int y) const { return pixel_index(x, y, image.width); }
  /// The colour of a texel in one layer.
  void put(std::size_t number, int x, int y, const Color& color) {
    if (number == 0)
      store(image.at(x, y), color);
    else
      layer(number).put(at(x, y), color);
  }
  /// In all layers, and its state.
  void put(int x, int y, std::span<const Color> colors, TexelState s) {
    for (std::size_t number = 0; number < colors.size(); ++number) put(number, x, y, colors[number]);
    state[at(x, y)] = s;
  }
  Color color(std::size_t number, int x, int y) const {
    return number == 0 ? load(image.at(x, y)) : layer(number).at(x, y);
  }
};

/// Maps a chart's texels to its page.
struct ChartPlace {
  std::uint32_t page = 0;
  int x = 0, y = 0;              ///< page texel of the top-left corner of the turned box
  int turns = 0;                 ///< quarter turns clockwise
  int width = 0, height = 0;     ///< of the box of whole blocks before it is turned
  int inset_x = 0, inset_y = 0;  ///< texels from that box's corner to the chart's first texel

  struct Texel {
    int x, y;
  };
  Texel texel(int i, int j) const { return turned<Texel>(i + inset_x, j + inset_y, 1); }
  /// Page position of a position in the chart's texel coordinates.
  TexelPoint point(const TexelPoint& p) const { return turned<TexelPoint>(p.x + inset_x, p.y + inset_y, 0.0); }

 private:
  /// Where a square of edge `size` whose top-left corner is (u, v) in the box has that corner on the page.
  template <typename Place, typename T>
  Place turned(T u, T v, T size) const {
    switch (turns) {
      case 1:
        return {x + height - size - v, y + u};
      case 2:
        return {x + width - size - u, y + height - size - v};
      case 3:
        return {x + v, y + width - size - u};
      default:
        return {x + u, y + v};
    }
  }
};

std::vector<ChartPlace> chart_places(std::span<const ChartShape> shapes, const Packing& packing, int edge);

/// Closed pages with the owners of their blocks. \param bands as of Page
std::vector<Page> make_pages(std::span<const ChartShape> shapes, const Packing& packing, int edge,
                             const BandSet* bands);

/// The same for a given layout; owners come with open pages (AtlasBuild::open).
std::vector<Page> given_pages(const Packing& packing, const BandSet* bands);

/// Extends charts outwards, each texel taking the mean of the neighbours nearer to the chart: over all of the chart's
/// own blocks, and up to `padding` texels into blocks without an owner. Returns how many texels outside charts lie within
/// `padding` of one. O(page texels + perimeters x padding).
std::size_t pad_charts(Page& page, int padding);

/// Gives every empty texel of the image a colour from the nearest filled ones, see io::fill_holes. A page without a filled
/// texel stays black, and samples stay 0. O(texels).
void fill_background(Page& page);

/// Mean of the filled texels of pages, layer by layer.
class PageMean {
 public:
  void add(const Page& page);
  void add(const PageMean& other);
  /// If there are none, the image's is grey, and 0 that of a later layer.
  Color mean(std::size_t layer) const;

 private:
  /// The texels of a part of a page.
  void add(const Page& page, std::size_t begin, std::size_t end);

  std::array<std::uint64_t, 3> sum_{};
  std::vector<std::array<double, 3>> layers_;  ///< sums of the later layers
  std::uint64_t count_ = 0;
};

}  // namespace gpvc::atlas
