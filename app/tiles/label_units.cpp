// The units that choose views for the faces of tiles, and find exposure and shifts of photos from what was chosen.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <numeric>

#include "app/checks/scene_fit.h"
#include "app/pipeline/bake_into.h"
#include "app/pipeline/steps.h"
#include "app/tiles/done.h"
#include "app/tiles/sound.h"
#include "app/tiles/tile_atlas.h"
#include "app/tiles/tile_work.h"
#include "app/tiles/units.h"

namespace gpvc::tiles {
namespace {

// What Stage::expose leaves.
struct PhotoRelations {
  std::vector<atlas::ColorRatio> ratios;
  std::vector<atlas::PhotoMatch> matches;
  std::vector<std::size_t> faces;  // per view, of the tile's faces
};
GPVC_MEMBERS(PhotoRelations, ratios, matches, faces)

// About `most` of the items, evenly.
template <typename Item>
std::vector<Item> thinned(std::vector<Item> items, std::size_t most) {
  const std::size_t stride = items.size() / std::max<std::size_t>(most, 1) + 1;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < items.size(); i += stride) items[kept++] = items[i];
  items.resize(kept);
  return items;
}

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
  const TileMesh tile = load_tile(folder_, job_, unit.level, unit.number);
  const labeling::FaceGraph graph = labeling::face_graph(tile.mesh);
  const auto photos = folder_.get<labeling::PhotoJudgement>(
      kJudgeUnit, "photos", [&](const labeling::PhotoJudgement& found) { return is_sound(found, job_.scene); });
  labeling::CandidateCollector collector(tile.mesh, settings_.costs);
  pipeline::CoverageStore coverage;
  for (TileSight& seen : load_sights(folder_, job_, unit.level, unit.number, tile.mesh)) {
    collector.add_statistics(seen.view, seen.statistics);
    coverage.add(std::make_shared<const pipeline::PackedCoverage>(std::move(seen.coverage)));
    seen = {};
  }
  collector.set_photos(pipeline::photo_of_view(job_.scene));
  collector.judge_faces(photos, &graph);
  results::Observer silent;  // what rules are about was noted when the job was made
  const std::vector<pipeline::ViewRule> rules =
      unit.level == 0 ? pipeline::rules_of_part(settings_.view_rules, tile.face)
                      : pipeline::rules_of_coarser(settings_.view_rules, job_.listed, tile.mesh, tile.vertex);
  labeling::Candidates candidates =
      collector.finish(&graph, pipeline::allowed_views(rules, tile.mesh, job_.scene.views.size(), silent));
  TileCosts costs{std::move(candidates.table), std::move(candidates.tags), {}};
  costs.coverage = coverage.of_partial_faces(costs.tags);
  put(unit, "costs", key, costs);
  const auto refused =
      std::ranges::count_if(candidates.refused, [&](FaceId face) { return tile.tile[index(face)] == unit.number; });
  if (refused > 0 && unit.level == 0)
    observer_.warning(fmt::format("{} faces are filled: the rules refuse all photos that see them",
                                  results::readable_count(static_cast<std::size_t>(refused))));
  std::vector<labeling::FaceTag> own;
  for (std::size_t f = 0; f < costs.tags.size(); ++f)
    if (tile.tile[f] == unit.number) own.push_back(costs.tags[f]);
  const auto counts = checks::count_tags(own);
  for (std::size_t i = 0; const char* name : {"seen", "partial", "filled", "background"})
    done_->figures[name] = counts[i++];
  observer_.end(fmt::format("{} candidates", results::readable_count(costs.table.views.size())));
}

void UnitRunner::choose(const Unit& unit, const io::WorkKey& key) {
  const TileMesh tile = load_tile(folder_, job_, unit.level, unit.number);
  const auto costs = load_costs(folder_, job_, unit.level, unit.number, tile.face.size());
  const labeling::FaceGraph graph = pipeline::weighed_graph(tile.mesh, settings_.edge_weights, observer_);
  observer_.begin({unit.name, "labels", true});
  const TileInfo& info = job_.tiles(unit.level)[unit.number];
  const std::vector<ViewId> fixed = labels_of(folder_, job_, tile, info.around, [&](std::uint32_t other) {
    return labels_before(job_, unit.level, unit.round, unit.number, other);
  });
  std::vector<ViewId> start;
  if (unit.round > 1) {
    start = fixed;
    const std::array own{unit.number};
    const std::vector<ViewId> before = labels_of(
        folder_, job_, tile, own, [&](std::uint32_t t) { return choose_unit(unit.level, unit.round - 1, t); });
    for (std::size_t f = 0; f < start.size(); ++f)
      if (tile.tile[f] == unit.number) start[f] = before[f];
  }
  const labeling::Selection selection =
      labeling::select_views(costs.table, graph, settings_.solver, observer_.reporter(), fixed, start);
  std::vector<ViewId> labels;
  for (std::size_t f = 0; f < tile.tile.size(); ++f)
    if (tile.tile[f] == unit.number) labels.push_back(selection.labels[f]);
  put(unit, "labels", key, labels);
  observer_.end(fmt::format("{} faces", results::readable_count(labels.size())));
}

void UnitRunner::expose(const Unit& unit, const io::WorkKey& key) {
  observer_.begin({unit.name});
  TileAtlas tile(folder_, job_, unit.level, unit.number);
  if (settings_.edge_weights != labeling::EdgeWeights::uniform)
    labeling::weigh_edges(tile.tile.mesh, settings_.edge_weights, tile.graph);
  const LabelFigures labels = label_figures(tile, settings_.solver.smoothness);
  auto& figures = done_->figures;
  figures["energy"] = labels.energy;
  figures["pairs"] = labels.pairs;
  figures["seams"] = labels.seams;
  figures["pairs_across"] = labels.pairs_across;
  figures["seams_across"] = labels.seams_across;
  std::vector<std::size_t> faces(job_.scene.views.size(), 0);
  for (std::size_t f = 0; f < tile.labels.size(); ++f)
    if (tile.border[f] == 0 && tile.labels[f] != kNoView) ++faces[index(tile.labels[f])];
  std::vector<atlas::ColorRatio> ratios;
  std::vector<atlas::PhotoMatch> matches;
  io::PhotoCache decoded(job_.scene, 0, &photos_.hashes());
  const pipeline::Input tile_input{job_.scene, tile.tile.mesh, job_.tiles(0)[unit.number].views, job_.mesh_file};
  io::CoarsePhotos photos =
      pipeline::with_coarse_photos({tile_input, settings_, decoded, observer_},
                                   pipeline::workload(tile_input, settings_), 0, folder_.unit(unit.name));
  const atlas::AtlasInput input = tile.input(job_.scene, photos);
  // Exposures and shifts of photos are known from far fewer, and those of all tiles are solved together.
  if (settings_.atlas.seams != atlas::SeamLeveling::none)
    ratios = thinned(atlas::color_ratios(input), 4000000 / job_.tiles(0).size());
  if (settings_.atlas.align != atlas::PhotoAlignment::none)
    matches = thinned(atlas::match_photos(input), 2000000 / job_.tiles(0).size());
  const std::size_t kept_ratios = ratios.size();
  put(unit, "relations", key, PhotoRelations{std::move(ratios), std::move(matches), std::move(faces)});
  observer_.end(fmt::format("{} ratios between photos", results::readable_count(kept_ratios)));
}

void UnitRunner::level(const Unit& unit, const io::WorkKey& key) {
  observer_.begin({unit.name});
  std::vector<atlas::ColorRatio> ratios;
  std::vector<atlas::PhotoMatch> matches;
  std::vector<std::size_t> faces(job_.scene.views.size(), 0);
  for (std::size_t t = 0; t < job_.tiles(0).size(); ++t) {
    if (job_.tiles(0)[t].faces == 0) continue;
    const auto more = folder_.get<PhotoRelations>(expose_unit(t), "relations", [&](const PhotoRelations& found) {
      return found.faces.size() == faces.size() &&
             std::ranges::all_of(found.ratios,
                                 [&](const atlas::ColorRatio& ratio) { return is_sound(ratio, job_.scene); }) &&
             std::ranges::all_of(found.matches,
                                 [&](const atlas::PhotoMatch& match) { return atlas::is_sound(match, job_.scene); });
    });
    ratios.insert(ratios.end(), more.ratios.begin(), more.ratios.end());
    matches.insert(matches.end(), more.matches.begin(), more.matches.end());
    for (std::size_t v = 0; v < faces.size(); ++v) faces[v] += more.faces[v];
  }
  std::vector<atlas::ViewExposure> exposure;
  if (settings_.atlas.seams != atlas::SeamLeveling::none)
    exposure = atlas::fit_exposure(job_.scene, std::move(ratios), faces);
  put(unit, "exposure", key, exposure);
  const atlas::AlignmentFit alignment = atlas::fit_alignment(job_.scene, matches);
  pipeline::report_alignment(alignment.statistics, observer_);
  put(unit, "alignment", key, alignment.fields);
  observer_.end(fmt::format("{} photos", exposure.size()));
}

}  // namespace gpvc::tiles
