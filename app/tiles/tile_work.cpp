#include "app/tiles/tile_work.h"

#include <fmt/format.h>

#include <algorithm>

#include "app/pipeline/agreement_bytes.h"
#include "app/tiles/plan.h"

namespace gpvc::tiles {
namespace {

using Writer = io::WorkStore::Writer;
using Reader = io::WorkStore::Reader;

// Field by field: the struct has padding, whose bytes would differ from run to run.
void write_coverage(Writer& out, const visibility::CoverageTable& table) {
  out.add(table.entries.size());
  for (const visibility::FaceCoverage& entry : table.entries) {
    out.add(entry.face);
    out.add(entry.view);
    for (const std::int32_t value : {entry.x0, entry.y0, entry.width, entry.height}) out.add(value);
    out.add(entry.visible);
    out.add(entry.visible_share);
    out.add(entry.first_word);
  }
  out.add_all(table.words);
}

visibility::CoverageTable read_coverage(Reader& in) {
  visibility::CoverageTable table;
  for (auto count = in.get<std::size_t>(); count > 0; --count) {
    visibility::FaceCoverage entry;
    entry.face = in.get<FaceId>();
    entry.view = in.get<ViewId>();
    for (std::int32_t* value : {&entry.x0, &entry.y0, &entry.width, &entry.height}) *value = in.get<std::int32_t>();
    entry.visible = in.get<std::uint32_t>();
    entry.visible_share = in.get<float>();
    entry.first_word = in.get<std::size_t>();
    table.entries.push_back(entry);
  }
  table.words = in.get_all<std::uint64_t>();
  return table;
}

}  // namespace

std::string tile_file(std::uint32_t tile) { return fmt::format("tile-{}", tile); }

TileMesh load_tile(const JobFolder& folder, int level, std::uint32_t tile) {
  TileMesh mesh;
  const auto fill = [&](Reader& in) { mesh = read_tile(in); };
  if (level == 0)
    folder.read_mesh_file(tile_file(tile), fill);
  else
    folder.read(ring_unit(level, tile), "tile", fill);
  return mesh;
}

CoarseTile load_own(const JobFolder& folder, int level, std::uint32_t tile) {
  if (level == 0) return {load_tile(folder, 0, tile), 0};
  CoarseTile coarse;
  folder.read(simplify_unit(level, tile), "tile", [&](Reader& in) {
    coarse.error = in.get<double>();
    coarse.tile = read_tile(in);
  });
  return coarse;
}

void write_coarse(Writer& out, const CoarseTile& tile) {
  out.add(tile.error);
  write(out, tile.tile);
}

void write_seen(Writer& out, std::span<const SeenView> views) {
  out.add(views.size());
  for (const SeenView& seen : views) {
    out.add(seen.view);
    out.add_all(seen.statistics);
    out.add_all(seen.coverage.bytes);
  }
}

std::vector<SeenView> load_seen(const JobFolder& folder, const Job& job, int level, std::uint32_t tile) {
  std::vector<SeenView> all;
  for (std::size_t g = 0; g < job.groups.size(); ++g) {
    const auto frames = [&](ViewId view) { return std::ranges::binary_search(job.tiles(level)[tile].views, view); };
    if (!std::ranges::any_of(job.groups[g], frames)) continue;
    std::vector<SeenView> group;
    folder.read(see_unit(level, g), tile_file(tile), [&](Reader& in) {
      for (auto count = in.get<std::size_t>(); count > 0; --count) {
        SeenView seen{in.get<ViewId>(), {}, {}};
        seen.statistics = in.get_all<std::byte>();
        seen.coverage = {seen.view, in.get_all<std::uint8_t>()};
        group.push_back(std::move(seen));
      }
    });
    std::ranges::move(group, std::back_inserter(all));
  }
  std::ranges::sort(all, {}, &SeenView::view);
  return all;
}

void write_costs(Writer& out, const TileCosts& costs) {
  out.add_all(costs.table.first);
  out.add_all(costs.table.views);
  out.add_all(costs.table.costs);
  out.add_all(costs.tags);
  write_coverage(out, costs.coverage);
}

TileCosts load_costs(const JobFolder& folder, int level, std::uint32_t tile) {
  TileCosts costs;
  folder.read(cost_unit(level, tile), "costs", [&](Reader& in) {
    costs.table.first = in.get_all<std::size_t>();
    costs.table.views = in.get_all<std::uint32_t>();
    costs.table.costs = in.get_all<float>();
    costs.tags = in.get_all<labeling::FaceTag>();
    costs.coverage = read_coverage(in);
  });
  return costs;
}

void write_judgement(Writer& out, const labeling::PhotoJudgement& photos) {
  pipeline::write_agreement(out, photos.agreement);
  out.add_all(photos.log2_gain);
}

labeling::PhotoJudgement read_judgement(Reader& in) {
  labeling::PhotoJudgement photos{pipeline::read_agreement(in), {}};
  photos.log2_gain = in.get_all<double>();
  return photos;
}

std::vector<ViewId> load_labels(const JobFolder& folder, const std::string& unit) {
  std::vector<ViewId> labels;
  folder.read(unit, "labels", [&](Reader& in) { labels = in.get_all<ViewId>(); });
  return labels;
}

}  // namespace gpvc::tiles
