// The units that choose views for the faces of tiles, and find the exposure of photos from what was chosen.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <numeric>

#include "app/pipeline/steps.h"
#include "app/tiles/tile_atlas.h"
#include "app/tiles/tile_work.h"
#include "app/tiles/unit_outcome.h"
#include "app/tiles/units.h"

namespace gpvc::tiles {
namespace {

using Writer = io::WorkStore::Writer;
using Reader = io::WorkStore::Reader;

// A tile's part of what the labels of all tiles come to: its faces, and the pairs whose lower face is one of them.
struct LabelFigures {
  double energy = 0;
  std::size_t pairs = 0, seams = 0;                // of faces with views; with different ones
  std::size_t pairs_across = 0, seams_across = 0;  // of these, between two tiles
};

LabelFigures label_figures(const TileAtlas& atlas, double smoothness) {
  const labeling::CostTable& table = atlas.costs.table;
  LabelFigures figures;
  for (std::size_t f = 0; f < atlas.labels.size(); ++f) {
    if (atlas.border[f] != 0 || atlas.labels[f] == kNoView) continue;
    const auto views = table.views_of(f);
    const auto found = std::ranges::lower_bound(views, static_cast<std::uint32_t>(index(atlas.labels[f])));
    if (found != views.end() && *found == index(atlas.labels[f]))
      figures.energy += double{table.costs_of(f)[static_cast<std::size_t>(found - views.begin())]};
  }
  for (std::size_t e = 0; e < atlas.graph.edges.size(); ++e) {
    const auto& [a, b] = atlas.graph.edges[e];
    const ViewId first = atlas.labels[a], second = atlas.labels[b];
    if (atlas.border[std::min(a, b)] != 0 || first == kNoView || second == kNoView) continue;
    const bool across = atlas.border[std::max(a, b)] != 0, seam = first != second;
    figures.pairs += 1;
    figures.seams += seam ? 1 : 0;
    figures.pairs_across += across ? 1 : 0;
    figures.seams_across += across && seam ? 1 : 0;
    if (seam) figures.energy += smoothness * (atlas.graph.weights.empty() ? 1 : double{atlas.graph.weights[e]});
  }
  return figures;
}

}  // namespace

void UnitRunner::cost(const Unit& unit, const io::WorkKey& key) {
  observer_.begin({unit.name});
  const TileMesh tile = load_tile(folder_, unit.level, unit.number);
  const labeling::FaceGraph graph = labeling::face_graph(tile.mesh);
  labeling::PhotoJudgement photos;
  folder_.read(kJudgeUnit, "photos", [&](Reader& in) { photos = read_judgement(in); });
  labeling::CandidateCollector collector(tile.mesh, settings_.costs);
  pipeline::CoverageStore coverage;
  for (SeenView& seen : load_seen(folder_, job_, unit.level, unit.number)) {
    if (!collector.add_statistics(seen.view, seen.statistics))
      throw InputError(folder_.path(), "unit " + unit.name, "what views see is of another mesh", {Cure::make_job});
    coverage.add(std::make_shared<const pipeline::PackedCoverage>(std::move(seen.coverage)));
    seen = {};
  }
  collector.set_photos(pipeline::photo_of_view(job_.scene));
  collector.judge_faces(photos, &graph);
  labeling::Candidates candidates = collector.finish(&graph);
  TileCosts costs{std::move(candidates.table), std::move(candidates.tags), {}};
  costs.coverage = coverage.of_partial_faces(costs.tags);
  keep(unit, "costs", key, [&](Writer& out) { write_costs(out, costs); });
  std::array<std::size_t, 3> tags{};
  for (std::size_t f = 0; f < costs.tags.size(); ++f)
    if (tile.tile[f] == unit.number) ++tags[static_cast<std::size_t>(costs.tags[f])];
  for (std::size_t i = 0; const char* name : {"seen", "partial", "filled"}) outcome_->done.figures[name] = tags[i++];
  observer_.end(fmt::format("{} candidates", results::readable_count(costs.table.views.size())));
}

void UnitRunner::choose(const Unit& unit, const io::WorkKey& key) {
  const TileMesh tile = load_tile(folder_, unit.level, unit.number);
  const TileCosts costs = load_costs(folder_, unit.level, unit.number);
  const labeling::FaceGraph graph = pipeline::weighed_graph(tile.mesh, settings_.edge_weights, observer_);
  observer_.begin({unit.name, "labels", true});
  const TileInfo& info = job_.tiles(unit.level)[unit.number];
  const std::vector<ViewId> fixed = labels_of(folder_, tile, info.around, [&](std::uint32_t other) {
    return labels_before(job_, unit.level, unit.round, unit.number, other);
  });
  std::vector<ViewId> start;
  if (unit.round > 1) {
    start = fixed;
    const std::array own{unit.number};
    const std::vector<ViewId> before =
        labels_of(folder_, tile, own, [&](std::uint32_t t) { return choose_unit(unit.level, unit.round - 1, t); });
    for (std::size_t f = 0; f < start.size(); ++f)
      if (tile.tile[f] == unit.number) start[f] = before[f];
  }
  const labeling::Selection selection =
      labeling::select_views(costs.table, graph, settings_.solver, observer_.reporter(), fixed, start);
  std::vector<ViewId> labels;
  for (std::size_t f = 0; f < tile.tile.size(); ++f)
    if (tile.tile[f] == unit.number) labels.push_back(selection.labels[f]);
  keep(unit, "labels", key, [&](Writer& out) { out.add_all(labels); });
  observer_.end(fmt::format("{} faces", results::readable_count(labels.size())));
}

void UnitRunner::expose(const Unit& unit, const io::WorkKey& key) {
  observer_.begin({unit.name});
  TileAtlas tile(folder_, job_, unit.level, unit.number);
  if (settings_.edge_weights != labeling::EdgeWeights::uniform)
    labeling::weigh_edges(tile.tile.mesh, settings_.edge_weights, tile.graph);
  const LabelFigures labels = label_figures(tile, settings_.solver.smoothness);
  auto& figures = outcome_->done.figures;
  figures["energy"] = labels.energy;
  figures["pairs"] = labels.pairs;
  figures["seams"] = labels.seams;
  figures["pairs_across"] = labels.pairs_across;
  figures["seams_across"] = labels.seams_across;
  std::vector<std::size_t> faces(job_.scene.views.size(), 0);
  for (std::size_t f = 0; f < tile.labels.size(); ++f)
    if (tile.border[f] == 0 && tile.labels[f] != kNoView) ++faces[index(tile.labels[f])];
  std::vector<atlas::SeamRatio> ratios;
  if (settings_.atlas.seams != atlas::SeamLeveling::none) {
    io::PhotoCache photos(job_.scene, downscale_);
    ratios = atlas::seam_ratios(tile.input(job_.scene, photos, {}));
    // Exposures of photos are known from far fewer, and those of all tiles are solved together.
    constexpr std::size_t kMost = 4000000;
    const std::size_t stride = ratios.size() * job_.tiles(0).size() / kMost + 1;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < ratios.size(); i += stride) ratios[kept++] = ratios[i];
    ratios.resize(kept);
  }
  keep(unit, "ratios", key, [&](Writer& out) {
    out.add_all(ratios);
    out.add_all(faces);
  });
  observer_.end(fmt::format("{} ratios across seams", results::readable_count(ratios.size())));
}

void UnitRunner::level(const Unit& unit, const io::WorkKey& key) {
  observer_.begin({unit.name});
  std::vector<atlas::SeamRatio> ratios;
  std::vector<std::size_t> faces(job_.scene.views.size(), 0);
  for (std::size_t t = 0; t < job_.tiles(0).size(); ++t)
    folder_.read(expose_unit(t), "ratios", [&](Reader& in) {
      const std::vector<atlas::SeamRatio> more = in.get_all<atlas::SeamRatio>();
      ratios.insert(ratios.end(), more.begin(), more.end());
      const std::vector<std::size_t> counts = in.get_all<std::size_t>();
      if (counts.size() != faces.size()) in.refuse();
      for (std::size_t v = 0; v < counts.size(); ++v) faces[v] += counts[v];
    });
  std::vector<atlas::ViewExposure> exposure;
  if (settings_.atlas.seams != atlas::SeamLeveling::none)
    exposure = atlas::fit_exposure(job_.scene, std::move(ratios), faces);
  keep(unit, "exposure", key, [&](Writer& out) {
    out.add(exposure.size());
    for (const atlas::ViewExposure& each : exposure) {
      out.add(each.gain);
      for (const double value : {each.centre_x, each.centre_y, each.inverse_radius2, each.k1, each.k2}) out.add(value);
    }
  });
  observer_.end(fmt::format("{} photos", exposure.size()));
}

}  // namespace gpvc::tiles
