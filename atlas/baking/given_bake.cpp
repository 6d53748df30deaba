// Pages of a given layout: which chart owns each texel, and the texels of charts whose faces are seen whole.
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>

#include "atlas/baking/baking.h"
#include "atlas/baking/poll.h"
#include "atlas/baking/texel_sample.h"
#include "io/grouping.h"

namespace gpvc::atlas {
namespace {

struct PlacedFace {
  std::uint32_t chart, face;
};

/// The source of a face's texels that its label alone gives.
class WholeSources {
 public:
  WholeSources(const AtlasBuild& build, const ViewPhoto& photo) : build_(build), photo_(photo) {}

  /// nullptr for a face without an area.
  const TexelSource* of(std::uint32_t face) {
    if (face == source_.face && begun_) return found_ ? &source_ : nullptr;
    begun_ = true;
    source_ = {face, photo_.id, nullptr, {}, {}, {}};
    const auto map = plane_map(build_.input.mesh, build_.input.scene, build_.set, face);
    found_ = map.has_value();
    if (map) source_.frame_from_texel = frame_from_texel(*map, photo_.view);
    return found_ ? &source_ : nullptr;
  }

 private:
  const AtlasBuild& build_;
  const ViewPhoto& photo_;
  TexelSource source_;
  bool begun_ = false, found_ = false;
};

}  // namespace

std::vector<std::uint32_t> texel_owners(const AtlasBuild& build, std::uint32_t number) {
  const Page& page = build.pages[number];
  const int width = page.image.width, height = page.image.height;
  const auto bands = static_cast<std::size_t>((height + kBandRows - 1) / kBandRows);
  const int padding = build.options.padding;
  const auto of_band = group_items<PlacedFace>(bands, [&](const auto& add) {
    const auto band_of = [&](double y) {
      return static_cast<std::size_t>(std::clamp(y / kBandRows, 0.0, static_cast<double>(bands) - 1));
    };
    for (std::uint32_t c = 0; c < build.set.placed; ++c) {
      if (build.places[c].page != number) continue;
      for (const std::uint32_t face : build.set.charts[c].faces) {
        FrameBox box;
        box.add(build.on_page(c, face));
        for (std::size_t b = band_of(box.y0 - kBandReach); b <= band_of(box.y1 + kBandReach); ++b) add(b, {c, face});
      }
    }
  });
  std::vector<std::uint32_t> owners(page.texels(), kNoOwner);
  tbb::parallel_for(std::size_t{0}, bands, [&](std::size_t b) {
    const int first_row = static_cast<int>(b) * kBandRows;
    const CellBox band{0, first_row, width, std::min(first_row + kBandRows, height)};
    constexpr std::array kHalves{0.0, 0.5, 1.0};  // of TexelReach: centre, touched, ring
    for (const double half : std::span(kHalves).first(padding > 0 ? 3 : 2))
      for (const PlacedFace& placed : of_band[b])
        triangle_spans(build.on_page(placed.chart, placed.face), half, band, [&](int y, int first, int last) {
          for (int x = first; x <= last; ++x)
            if (std::uint32_t& owner = owners[page.at(x, y)]; owner == kNoOwner) owner = placed.chart;
        });
  });
  return owners;
}

void bake_given_band(AtlasBuild& build, const ViewPhoto& photo, std::uint32_t number, int band,
                     std::span<const std::uint32_t> faces, Poll& poll) {
  const Chart& chart = build.set.charts[number];
  const CellBox box = band_box(chart, band);
  const ChartRaster raster = rasterize(faces, build.set.corners, box);
  Page& page = build.page_of(number);
  WholeSources sources(build, photo);
  TexelSampler sampler(build, photo);
  StripOffsets strip(build.correction.strip(number), box);
  std::vector<Color> layers(build.painting.layers()), samples(layers.size() - 1);
  // Blocks of the strip's offsets, row by row.
  for (int by = box.y0; by < box.y1; by += kStripRow) {
    poll();
    for (int bx = box.x0; bx < box.x1; bx += kStripRow)
      for (int y = by; y < std::min(by + kStripRow, box.y1); ++y)
        for (int x = bx; x < std::min(bx + kStripRow, box.x1); ++x) {
          const std::size_t i = raster.at(x, y);
          if (!is_baked(raster.reach[i], build.options.padding)) continue;
          const auto texel = build.own_texel(number, x, y);
          if (!texel) continue;
          const std::uint32_t face = raster.owner[i];
          const TexelSource* source = sources.of(face);
          if (!source) continue;
          sampler.begin(*source, y, x, 1);
          const auto exposed = sampler.sample(x, samples);
          if (!exposed) continue;
          const Color added = build.correction.added(face, build.set.corners[face], x + 0.5, y + 0.5, strip.at(x, y));
          layers[0] = corrected(exposed->color, added, exposed->gain);
          for (std::size_t layer = 1; layer < layers.size(); ++layer)
            layers[layer] =
                build.painting.painted(layer, samples[layer - 1], photo.id, exposed->frame, exposed->gain, added);
          page.put(texel->x, texel->y, layers, state_of(raster.reach[i]));
        }
  }
}

}  // namespace gpvc::atlas
