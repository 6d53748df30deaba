#include "atlas/baking/partial_sources.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "io/freed_memory.h"

namespace gpvc::atlas {

namespace {

std::optional<TexelTriangle> outline_in(const visibility::FaceCoverage& entry, const Mesh& mesh, const View& view) {
  TexelTriangle projected;
  for (std::size_t i = 0; i < 3; ++i) {
    const CameraPoint p = camera_from_world(view.pose, mesh.positions[mesh.faces[index(entry.face)][i]]);
    if (!(p.z > 0)) return std::nullopt;
    const PixelPoint q = pixel_from_camera(view.camera, p);
    projected[i] = {q.x - entry.x0, q.y - entry.y0};
  }
  return projected;
}

/// Clearance over the coverage's box: pixels within margin_px (chessboard distance) of one where the face is hidden are
/// near an occluder, their neighbours beside it.
std::vector<Sight> find_clearance(const visibility::CoverageTable& table, const visibility::FaceCoverage& entry,
                                  const std::optional<TexelTriangle>& outline, int margin_px) {
  if (margin_px <= 0 || !outline) return {};
  std::vector<Sight> clearance(pixel_index(0, entry.height, entry.width), Sight::clear);
  const auto mark_around = [&](int x, int y) {
    for (int my = std::max(0, y - margin_px); my <= std::min(entry.height - 1, y + margin_px); ++my)
      for (int mx = std::max(0, x - margin_px); mx <= std::min(entry.width - 1, x + margin_px); ++mx) {
        Sight& sight = clearance[pixel_index(mx, my, entry.width)];
        const bool beside = std::abs(mx - x) <= 1 && std::abs(my - y) <= 1;
        sight = std::min(sight, beside ? Sight::beside_occluder : Sight::near_occluder);
      }
  };
  bool any = false;
  triangle_spans(*outline, 0.0, {0, 0, entry.width, entry.height}, [&](int y, int first, int last) {
    for (int x = first; x <= last; ++x) {
      if (table.sees(entry, entry.x0 + x, entry.y0 + y)) continue;
      any = true;
      mark_around(x, y);
    }
  });
  if (!any) clearance.clear();
  return clearance;
}

/// True strictly inside: a pixel centre on the edge may belong to the neighbour.
bool contains(const TexelTriangle& t, double x, double y) {
  int left = 0, right = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const TexelPoint &a = t[i], &b = t[(i + 1) % 3];
    const double side = (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
    left += side > 0;
    right += side < 0;
  }
  return left == 3 || right == 3;
}

/// The pixel whose coverage decides for a place on the face. Coverage is known at pixel centres inside the face: where
/// the centre of the place's own pixel lies outside, the nearest neighbouring pixel whose centre lies inside decides.
std::array<int, 2> deciding_pixel(const TexelSource& source, const PixelPoint& p) {
  const int px = static_cast<int>(std::floor(p.x)), py = static_cast<int>(std::floor(p.y));
  const visibility::FaceCoverage& c = *source.coverage;
  const auto in_face = [&](int x, int y) { return contains(*source.outline, x + 0.5 - c.x0, y + 0.5 - c.y0); };
  if (!source.outline || in_face(px, py)) return {px, py};
  std::array<int, 2> nearest{px, py};
  double least = 1e9;
  for (int y = py - 1; y <= py + 1; ++y)
    for (int x = px - 1; x <= px + 1; ++x) {
      const double distance = std::hypot(x + 0.5 - p.x, y + 0.5 - p.y);
      if (distance >= least || !in_face(x, y)) continue;
      least = distance;
      nearest = {x, y};
    }
  return nearest;
}

/// Candidate views of a face: the label, then the others by cost.
std::vector<ViewId> ordered_candidates(const AtlasInput& input, std::uint32_t face) {
  constexpr std::size_t kMost = 64;
  std::vector<std::pair<float, std::uint32_t>> others;
  const ViewId label = input.labels[face];
  if (face < input.candidates.faces()) {
    const auto views = input.candidates.views_of(face);
    const auto costs = input.candidates.costs_of(face);
    for (std::size_t k = 0; k < views.size(); ++k)
      if (ViewId{views[k]} != label) others.emplace_back(costs[k], views[k]);
  }
  std::sort(others.begin(), others.end());
  std::vector<ViewId> result{label};
  for (const auto& [cost, view] : others)
    if (result.size() < kMost) result.push_back(ViewId{view});
  return result;
}

/// Makes one partial chart and chooses the sources of its texels.
class SourceChooser {
 public:
  SourceChooser(const AtlasInput& input, const ChartSet& set, const CoverageIndex& coverage, int margin_px)
      : input_(input), set_(set), coverage_(coverage), table_(coverage.table()), margin_px_(margin_px) {}

  PartialChart choose(std::uint32_t chart) {
    start(chart);
    for_owned_texels([&](std::size_t i, int x, int y) { choose_best(i, x, y); });
    for_owned_texels([&](std::size_t i, int x, int y) { choose_second(i, x, y); });
    finish();
    return std::move(part_);
  }

 private:
  void start(std::uint32_t c) {
    const Chart& chart = set_.charts[c];
    part_.chart = c;
    part_.raster = rasterize(chart.faces, set_.corners, partial_box(chart));
    for (const auto face : chart.faces) {
      add_sources(face);
      part_.sources.first.push_back(part_.sources.items.size());
    }
    const std::vector<std::uint32_t>& owner = part_.raster.owner;
    part_.face_slot.assign(owner.size(), 0);
    for (std::size_t i = 0; i < owner.size(); ++i)
      if (owner[i] != kNoOwner)
        part_.face_slot[i] =
            static_cast<std::uint32_t>(std::ranges::lower_bound(chart.faces, owner[i]) - chart.faces.begin());
    part_.best.assign(owner.size(), PartialChart::kNone);
    part_.second.assign(owner.size(), PartialChart::kNone);
    part_.blend.assign(owner.size(), 0);
    part_.color.assign(owner.size(), Color{});
  }

  void add_sources(std::uint32_t face) {
    const auto map = plane_map(input_.mesh, input_.scene, set_, face);
    if (!map) return;
    for (const ViewId id : ordered_candidates(input_, face)) {
      TexelSource source{id, coverage_.find(FaceId{face}, id), {}, {}, {}};
      // Without coverage a view shows either the whole face, if the face is tagged so, or nothing of it.
      if (!source.coverage && !(input_.tags[face] == labeling::FaceTag::seen && id == input_.labels[face])) continue;
      const View& view = input_.scene.views[index(id)];
      source.frame_from_texel = frame_from_texel(*map, view);
      if (source.coverage) {
        source.outline = outline_in(*source.coverage, input_.mesh, view);
        source.clearance = find_clearance(table_, *source.coverage, source.outline, margin_px_);
      }
      part_.sources.items.push_back(std::move(source));
    }
  }

  template <typename Visit>
  void for_owned_texels(const Visit& visit) const {
    const CellBox& box = part_.raster.box;
    for (int y = box.y0; y < box.y1; ++y)
      for (int x = box.x0; x < box.x1; ++x)
        if (const std::size_t i = part_.raster.at(x, y); part_.raster.owner[i] != kNoOwner) visit(i, x, y);
  }

  /// The first source, in order of preference, of those with the best sight of the texel's centre.
  void choose_best(std::size_t i, int x, int y) {
    const auto sources = part_.sources_at(i);
    Sight best = Sight::hidden;
    for (std::uint8_t k = 0; k < sources.size() && best != Sight::clear; ++k) {
      const Sight sight = sight_at(sources[k], table_, x + 0.5, y + 0.5);
      if (sight <= best) continue;
      best = sight;
      part_.best[i] = k;
    }
  }

  /// Close to texels of another view that shows this texel clearly, a part of that view is blended in: 1/3 beside the
  /// border and 1/6 one texel further, so that the colours of the two sides meet in equal steps.
  void choose_second(std::size_t i, int x, int y) {
    if (part_.best[i] == PartialChart::kNone) return;
    for (int distance = 1; distance <= 2 && part_.second[i] == PartialChart::kNone; ++distance) {
      part_.second[i] = second_source(i, x, y, distance);
      if (part_.second[i] != PartialChart::kNone) part_.blend[i] = distance == 1 ? 2 : 1;
    }
  }

  /// The source for the view of the first texel within `distance` (row by row) whose view is another one and shows the
  /// texel (x, y) clearly; kNone if there is none.
  std::uint8_t second_source(std::size_t i, int x, int y, int distance) const {
    const CellBox& box = part_.raster.box;
    const auto sources = part_.sources_at(i);
    const ViewId own = view_at(i);
    for (int ny = std::max(box.y0, y - distance); ny <= std::min(box.y1 - 1, y + distance); ++ny)
      for (int nx = std::max(box.x0, x - distance); nx <= std::min(box.x1 - 1, x + distance); ++nx) {
        const ViewId other = view_at(part_.raster.at(nx, ny));
        if (other == kNoView || other == own) continue;
        const auto found = std::ranges::find(sources, other, &TexelSource::view);
        if (found != sources.end() && sight_at(*found, table_, x + 0.5, y + 0.5) == Sight::clear)
          return static_cast<std::uint8_t>(found - sources.begin());
      }
    return PartialChart::kNone;
  }

  ViewId view_at(std::size_t i) const {
    return part_.best[i] == PartialChart::kNone ? kNoView : part_.sources_at(i)[part_.best[i]].view;
  }

  void finish() {
    // A byte for each pixel of every source is too much to keep where many photos see large faces in parts.
    for (TexelSource& source : part_.sources.items) free_memory(source.clearance);
    std::vector<std::uint32_t>& views = part_.views;
    for (std::size_t i = 0; i < part_.best.size(); ++i)
      for (const auto k : {part_.best[i], part_.second[i]})
        if (k != PartialChart::kNone) views.push_back(static_cast<std::uint32_t>(part_.sources_at(i)[k].view));
    std::sort(views.begin(), views.end());
    views.erase(std::unique(views.begin(), views.end()), views.end());
  }

  const AtlasInput& input_;
  const ChartSet& set_;
  const CoverageIndex& coverage_;
  const visibility::CoverageTable& table_;
  int margin_px_;
  PartialChart part_;
};

}  // namespace

Sight sight_at(const TexelSource& source, const visibility::CoverageTable& table, double x, double y) {
  const auto p = source.frame_from_texel(x, y);
  if (!p) return Sight::hidden;
  if (!source.coverage) return Sight::clear;
  const visibility::FaceCoverage& c = *source.coverage;
  // Positions far outside the box would overflow the conversion to whole pixels.
  if (!(p->x >= c.x0 - 1 && p->y >= c.y0 - 1 && p->x < c.x0 + c.width + 1 && p->y < c.y0 + c.height + 1))
    return Sight::hidden;
  const auto [px, py] = deciding_pixel(source, *p);
  if (!table.sees(c, px, py)) return Sight::hidden;
  if (source.clearance.empty()) return Sight::clear;
  return source.clearance[pixel_index(px - c.x0, py - c.y0, c.width)];
}

std::vector<std::uint32_t> partial_charts(const ChartSet& set) {
  std::vector<std::uint32_t> charts;
  for (std::uint32_t c = 0; c < set.charts.size(); ++c)
    if (set.charts[c].kind == ChartKind::partial || set.charts[c].kind == ChartKind::flat) charts.push_back(c);
  return charts;
}

CellBox partial_box(const Chart& chart) { return {-1, -1, chart.width + 1, chart.height + 1}; }

std::vector<PartialChart> choose_sources(const AtlasInput& input, const ChartSet& set, const CoverageIndex& coverage,
                                         int margin_px, std::span<const std::uint32_t> charts) {
  std::vector<PartialChart> parts(charts.size());
  tbb::parallel_for(std::size_t{0}, charts.size(), [&](std::size_t i) {
    parts[i] = SourceChooser(input, set, coverage, margin_px).choose(charts[i]);
  });
  return parts;
}

PointOrigin origin_at(const PartialChart& part, const TexelPoint& p) {
  const CellBox& box = part.raster.box;
  const int x = std::clamp(static_cast<int>(std::floor(p.x)), box.x0, box.x1 - 1);
  const int y = std::clamp(static_cast<int>(std::floor(p.y)), box.y0, box.y1 - 1);
  const std::size_t i = part.raster.at(x, y);
  if (part.best[i] == PartialChart::kNone) return {};
  const auto sources = part.sources_at(i);
  const auto place = [&](const TexelSource& source) {
    return source.frame_from_texel(p.x, p.y).value_or(PixelPoint{-1, -1});  // behind the camera: outside the photo
  };
  PointOrigin origin;
  origin.first = sources[part.best[i]].view;
  origin.first_at = place(sources[part.best[i]]);
  if (part.second[i] != PartialChart::kNone) {
    origin.second = sources[part.second[i]].view;
    origin.second_at = place(sources[part.second[i]]);
    origin.second_share = double(part.blend[i]) / PartialChart::kBlendSteps;
  }
  return origin;
}

}  // namespace gpvc::atlas
