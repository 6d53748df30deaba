// Adds coarse colours of other views to plain charts, chart by chart as far as memory goes.
#include <tbb/parallel_for.h>

#include <algorithm>
#include <memory>

#include "atlas/baking/baking.h"
#include "atlas/baking/blend_field.h"
#include "atlas/baking/poll.h"
#include "io/freed_memory.h"

namespace gpvc::atlas {

namespace {

/// A band of a chart to which a view adds something.
struct BlendedBand {
  BlendField* field = nullptr;
  std::size_t band = 0;
};

InventedColor blend_batch(AtlasBuild& build, std::span<const std::uint32_t> charts, const Progress& progress) {
  std::vector<BlendField> fields;
  fields.reserve(charts.size());
  for (const std::uint32_t chart : charts) fields.emplace_back(build, chart);
  tbb::parallel_for(std::size_t{0}, fields.size(), [&](std::size_t i) { fields[i].open(); });
  std::vector<std::vector<BlendedBand>> work(build.input.scene.views.size());
  for (BlendField& field : fields)
    for (std::size_t band = 0; band < field.bands(); ++band)
      for (const std::uint32_t view : field.views_of(band)) work[view].push_back({&field, band});
  const std::size_t views = count_wanted(work);
  std::size_t done = 0;
  const auto fetch = [&](ViewId id) { return std::make_shared<const CoarseRows>(*build.input.photos.coarse(id)); };
  each_fetched(work, PhotoOrder::ascending, fetch,
               [&](ViewId id, std::shared_ptr<const CoarseRows>& coarse, const std::vector<BlendedBand>& mine) {
                 const int step = lattice_step(build.input.scene.views[index(id)].camera);
                 Poll poll(progress, done, views);
                 tbb::parallel_for(std::size_t{0}, mine.size(), [&](std::size_t i) {
                   poll();
                   mine[i].field->add(mine[i].band, id, *coarse, step);
                 });
                 if (progress) progress(++done, views);
               });
  std::vector<InventedColor> invented(fields.size());
  tbb::parallel_for(std::size_t{0}, fields.size(), [&](std::size_t i) {
    fields[i].apply(build);
    invented[i] = fields[i].invented_color();
  });
  InventedColor all;
  for (const InventedColor& each : invented) all.add(each);
  return all;
}

}  // namespace

InventedColor blend_charts(AtlasBuild& build, const PageRange& pages, std::size_t bytes, const Progress& progress) {
  InventedColor invented;
  if (build.blending.empty()) return invented;
  std::vector<std::uint32_t> charts = plain_charts_on(build, pages);
  // Charts of a view take colours from few others.
  std::ranges::stable_sort(charts, {}, [&](std::uint32_t c) { return index(build.set.charts[c].view); });
  for (std::size_t first = 0, end = 0; first < charts.size(); first = end) {
    for (std::size_t left = bytes; end < charts.size(); ++end) {
      const std::size_t needed = blend_bytes(build.set, charts[end]);
      if (needed > left && end > first) break;
      left -= std::min(left, needed);
    }
    const auto part = [&](std::size_t done, std::size_t views) {
      if (progress) progress(first * views + (end - first) * done, charts.size() * views);
    };
    invented.add(blend_batch(build, std::span(charts).subspan(first, end - first), part));
    if (end - first < charts.size()) release_freed_memory();  // of many small blocks
  }
  return invented;
}

}  // namespace gpvc::atlas
