// What a view's photo gives to partial charts. Texels that no view shows are filled later, see partial_filler.h.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "atlas/baking/baking.h"
#include "atlas/baking/texel_sample.h"
#include "io/image.h"

namespace gpvc::atlas {

void take_view(PartialChart& part, AtlasBuild& build, const ViewPhoto& photo) {
  const Chart& chart = build.set.charts[part.chart];
  const bool own = chart.view == photo.id;  // the chart is this view's projection
  const CellBox box = partial_box(chart);
  const auto width = static_cast<std::uint32_t>(box.x1 - box.x0);
  StripOffsets strip(own ? build.correction.strip(part.chart) : nullptr, box);
  Page& page = build.page_of(part.chart);
  std::vector<Color> layers(page.layers());
  std::vector<Color> samples(page.layers() - 1);
  part.open_sums(samples.size());
  TexelSampler sampler(build, photo);
  for (const TexelShares& shares : part.shares_of(photo.id)) {
    const TexelSource& source = part.sources[shares.source];
    const int y = box.y0 + static_cast<int>(shares.texel / width);
    sampler.begin(source, y, box.x0 + static_cast<int>(shares.texel % width), shares.count);
    for (std::uint32_t number = shares.texel; number < shares.texel + shares.count; ++number) {
      const int x = box.x0 + static_cast<int>(number % width);
      const auto exposed = sampler.sample(x, samples);
      if (!exposed) {
        part.known[number] = false;
        part.is_open = true;
        continue;
      }
      // Offsets and strips belong to the chart's own view. The colours of other views are corrected by exposure alone.
      Color added;
      if (own)
        added = build.correction.added(source.face, build.set.corners[source.face], x + 0.5, y + 0.5, strip.at(x, y));
      layers[0] = corrected(exposed->color, added, exposed->gain);
      for (std::size_t layer = 1; layer < layers.size(); ++layer)
        layers[layer] =
            build.painting.painted(layer, samples[layer - 1], photo.id, exposed->frame, exposed->gain, added);
      if (shares.weight < PartialChart::kBlendSteps) {
        part.add_to_sums(number, static_cast<float>(shares.weight) / PartialChart::kBlendSteps, layers);
      } else {
        if (const auto texel = build.own_texel(part.chart, x, y))
          page.put(texel->x, texel->y, layers, state_of(shares.reach));
      }
    }
  }
}

void write_blended(const PartialChart& part, AtlasBuild& build) {
  const CellBox box = partial_box(build.set.charts[part.chart]);
  const auto width = static_cast<std::uint32_t>(box.x1 - box.x0);
  Page& page = build.page_of(part.chart);
  std::vector<Color> layers;
  for (std::size_t i = 0; i < part.blended.size(); ++i) {
    const BlendedTexel& blended = part.blended[i];
    if (!part.known[blended.texel]) continue;
    const auto texel = build.own_texel(part.chart, box.x0 + static_cast<int>(blended.texel % width),
                                       box.y0 + static_cast<int>(blended.texel / width));
    if (!texel) continue;
    layers.assign(1, blended.color);
    const std::span<const Color> sums = part.sums_of(i);
    layers.insert(layers.end(), sums.begin(), sums.end());
    page.put(texel->x, texel->y, layers, state_of(blended.reach));
  }
}

}  // namespace gpvc::atlas
