#include "atlas/baking/partial_sources.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <utility>

#include "atlas/baking/pages.h"
#include "atlas/leveling/color_correction.h"
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

/// Pixels of the coverage's box.
std::size_t box_pixels(const visibility::FaceCoverage& entry) { return pixel_index(0, entry.height, entry.width); }

/// Clearance over the coverage's box: pixels within margin_px (chessboard distance) of one where the face is hidden are
/// near an occluder, their neighbours beside it. Empty where none is.
std::vector<Sight> find_clearance(const visibility::CoverageTable& table, const visibility::FaceCoverage& entry,
                                  const std::optional<TexelTriangle>& outline, int margin_px) {
  if (margin_px <= 0 || !outline) return {};
  const auto for_pixels = [&](const auto& visit) {
    triangle_spans(*outline, 0.0, {0, 0, entry.width, entry.height}, [&](int y, int first, int last) {
      for (int x = first; x <= last; ++x) visit(x, y);
    });
  };
  std::vector<Sight> clearance;
  for_pixels([&](int x, int y) {
    if (table.sees(entry, entry.x0 + x, entry.y0 + y)) return;
    // Most faces are hidden nowhere, and the boxes of some are large.
    if (clearance.empty()) clearance.assign(box_pixels(entry), Sight::clear);
    clearance[pixel_index(x, y, entry.width)] = Sight::hidden;
  });
  if (clearance.empty()) return {};
  const auto for_around = [&](int x, int y, int distance, const auto& visit) {
    for (int my = std::max(0, y - distance); my <= std::min(entry.height - 1, y + distance); ++my)
      for (int mx = std::max(0, x - distance); mx <= std::min(entry.width - 1, x + distance); ++mx)
        visit(mx, my, clearance[pixel_index(mx, my, entry.width)]);
  };
  for_pixels([&](int x, int y) {
    if (clearance[pixel_index(x, y, entry.width)] != Sight::hidden) return;
    // On the way to any pixel that is seen lies a hidden one with such a neighbour, which marks it.
    bool inner = true;
    for_around(x, y, 1, [&](int, int, Sight sight) { inner &= sight == Sight::hidden; });
    if (inner) return;
    for_around(x, y, margin_px, [&](int mx, int my, Sight& sight) {
      const bool beside = std::abs(mx - x) <= 1 && std::abs(my - y) <= 1;
      sight = std::min(sight, beside ? Sight::beside_occluder : Sight::near_occluder);
    });
  });
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
  double least2 = 1e9;
  for (int y = py - 1; y <= py + 1; ++y)
    for (int x = px - 1; x <= px + 1; ++x) {
      const double dx = x + 0.5 - p.x, dy = y + 0.5 - p.y, distance2 = dx * dx + dy * dy;
      if (distance2 >= least2 || !in_face(x, y)) continue;
      least2 = distance2;
      nearest = {x, y};
    }
  return nearest;
}

/// Candidate views of a face that are looked at.
constexpr std::size_t kMostCandidates = 64;

/// Candidate views of a face: the label, then the others by cost.
std::vector<ViewId> ordered_candidates(const AtlasInput& input, std::uint32_t face) {
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
    if (result.size() < kMostCandidates) result.push_back(ViewId{view});
  return result;
}

/// Calls visit(texel, x, y) for the texels of a chart's partial_box(), in blocks of kStripRow x kStripRow.
template <typename Visit>
void for_blocks(const CellBox& box, const Visit& visit) {
  for (int by = box.y0; by < box.y1; by += kStripRow)
    for (int bx = box.x0; bx < box.x1; bx += kStripRow)
      for (int y = by; y < std::min(by + kStripRow, box.y1); ++y)
        for (int x = bx; x < std::min(bx + kStripRow, box.x1); ++x)
          visit(pixel_index(x - box.x0, y - box.y0, box.x1 - box.x0), x, y);
}

/// The order of a chart's texels in for_blocks().
std::array<std::uint32_t, 4> block_order(std::uint32_t texel, const CellBox& box) {
  const auto width = static_cast<std::uint32_t>(box.x1 - box.x0), edge = std::uint32_t{kStripRow};
  const std::uint32_t x = texel % width, y = texel / width;
  return {y / edge, x / edge, y, x};
}

/// Makes one partial chart and chooses the sources of its texels.
class SourceChooser {
 public:
  SourceChooser(const AtlasInput& input, const AtlasOptions& options, const ChartSet& set,
                const CoverageIndex& coverage)
      : input_(input), options_(options), set_(set), coverage_(coverage), table_(coverage.table()) {}

  PartialChart choose(std::uint32_t chart) {
    start(chart);
    for_owned_texels([&](std::size_t i, int x, int y) { choose_best(i, x, y); });
    for_owned_texels([&](std::size_t i, int x, int y) { choose_second(i, x, y); });
    return finish(chart);
  }

 private:
  static constexpr std::uint8_t kNone = 255;
  /// The choice for a texel.
  struct Choice {
    std::uint8_t best = kNone;    ///< of its owner's sources
    std::uint8_t second = kNone;  ///< blended in close to texels of another view
    std::uint8_t blend = 0;       ///< weight of the second source, in steps of 1 / kBlendSteps
  };

  void start(std::uint32_t c) {
    const Chart& chart = set_.charts[c];
    raster_ = rasterize(chart.faces, set_.corners, partial_box(chart));
    for (const auto face : chart.faces) {
      add_sources(face);
      sources_.first.push_back(sources_.items.size());
    }
    const std::vector<std::uint32_t>& owner = raster_.owner;
    face_slot_.assign(owner.size(), 0);
    for (std::size_t i = 0; i < owner.size(); ++i)
      if (owner[i] != kNoOwner)
        face_slot_[i] =
            static_cast<std::uint32_t>(std::ranges::lower_bound(chart.faces, owner[i]) - chart.faces.begin());
    choice_.assign(owner.size(), {});
  }

  void add_sources(std::uint32_t face) {
    const auto map = plane_map(input_.mesh, input_.scene, set_, face);
    if (!map) return;
    for (const ViewId id : ordered_candidates(input_, face)) {
      TexelSource source{face, id, coverage_.find(FaceId{face}, id), {}, {}, {}};
      // Without coverage a view shows either the whole face, if the face is tagged so, or nothing of it.
      if (!source.coverage && !(input_.tags[face] == labeling::FaceTag::seen && id == input_.labels[face])) continue;
      const View& view = input_.scene.views[index(id)];
      source.frame_from_texel = frame_from_texel(*map, view);
      if (source.coverage) {
        source.outline = outline_in(*source.coverage, input_.mesh, view);
        source.clearance = find_clearance(table_, *source.coverage, source.outline, options_.margin_px);
      }
      sources_.items.push_back(std::move(source));
    }
  }

  template <typename Visit>
  void for_owned_texels(const Visit& visit) const {
    const CellBox& box = raster_.box;
    for (int y = box.y0; y < box.y1; ++y)
      for (int x = box.x0; x < box.x1; ++x)
        if (const std::size_t i = raster_.at(x, y); raster_.owner[i] != kNoOwner) visit(i, x, y);
  }

  std::span<const TexelSource> sources_at(std::size_t texel) const { return sources_[face_slot_[texel]]; }

  /// The first source, in order of preference, of those with the best sight of the texel's centre.
  void choose_best(std::size_t i, int x, int y) {
    const auto sources = sources_at(i);
    Sight best = Sight::hidden;
    for (std::uint8_t k = 0; k < sources.size() && best != Sight::clear; ++k) {
      const Sight sight = sight_at(sources[k], table_, x + 0.5, y + 0.5);
      if (sight <= best) continue;
      best = sight;
      choice_[i].best = k;
    }
  }

  /// Close to texels of another view that shows this texel clearly, a part of that view is blended in: 1/3 beside the
  /// border and 1/6 one texel further, so that the colours of the two sides meet in equal steps.
  void choose_second(std::size_t i, int x, int y) {
    Choice& choice = choice_[i];
    if (choice.best == kNone) return;
    for (int distance = 1; distance <= 2 && choice.second == kNone; ++distance) {
      choice.second = second_source(i, x, y, distance);
      if (choice.second != kNone) choice.blend = distance == 1 ? 2 : 1;
    }
  }

  /// The source for the view of the first texel within `distance` (row by row) whose view is another one and shows the
  /// texel (x, y) clearly; kNone if there is none.
  std::uint8_t second_source(std::size_t i, int x, int y, int distance) const {
    const CellBox& box = raster_.box;
    const auto sources = sources_at(i);
    const ViewId own = view_at(i);
    for (int ny = std::max(box.y0, y - distance); ny <= std::min(box.y1 - 1, y + distance); ++ny)
      for (int nx = std::max(box.x0, x - distance); nx <= std::min(box.x1 - 1, x + distance); ++nx) {
        const ViewId other = view_at(raster_.at(nx, ny));
        if (other == kNoView || other == own) continue;
        const auto found = std::ranges::find(sources, other, &TexelSource::view);
        if (found != sources.end() && sight_at(*found, table_, x + 0.5, y + 0.5) == Sight::clear)
          return static_cast<std::uint8_t>(found - sources.begin());
      }
    return kNone;
  }

  ViewId view_at(std::size_t i) const {
    return choice_[i].best == kNone ? kNoView : sources_at(i)[choice_[i].best].view;
  }

  PartialChart finish(std::uint32_t chart) {
    PartialChart part;
    part.chart = chart;
    part.known.assign(choice_.size(), false);
    for (std::size_t i = 0; i < choice_.size(); ++i) {
      if (!is_baked(raster_.reach[i], options_.padding)) continue;
      part.known[i] = choice_[i].best != kNone;
      part.is_open |= choice_[i].best == kNone;
      if (choice_[i].second != kNone) part.blended.push_back({static_cast<std::uint32_t>(i), raster_.reach[i], {}});
    }
    keep_used_sources(part);
    part.shares = group_items<TexelShares>(part.views.size(), [&](const auto& add) { add_shares(part, add); });
    return part;
  }

  /// Calls use(texel, place in sources_.items, weight) for what each source gives to texels on the page.
  template <typename Use>
  void for_shares(const PartialChart& part, const Use& use) const {
    for_blocks(raster_.box, [&](std::size_t i, int, int) {
      if (!part.known[i]) return;
      const std::size_t first = sources_.first[face_slot_[i]];
      const Choice& choice = choice_[i];
      use(i, first + choice.best, static_cast<std::uint8_t>(PartialChart::kBlendSteps - choice.blend));
      if (choice.second != kNone) use(i, first + choice.second, choice.blend);
    });
  }

  /// Moves the sources that give something, and notes their views.
  void keep_used_sources(PartialChart& part) {
    constexpr std::uint32_t kUsed = 0;
    place_.assign(sources_.items.size(), kNoOwner);
    for_shares(part, [&](std::size_t, std::size_t source, std::uint8_t) { place_[source] = kUsed; });
    for (std::size_t s = 0; s < place_.size(); ++s) {
      if (place_[s] != kUsed) continue;
      place_[s] = static_cast<std::uint32_t>(part.sources.size());
      part.views.push_back(static_cast<std::uint32_t>(sources_.items[s].view));
      // A byte for each pixel of every source is too much to keep where many photos see large faces in parts.
      free_memory(sources_.items[s].clearance);
      part.sources.push_back(std::move(sources_.items[s]));
    }
    std::ranges::sort(part.views);
    part.views.erase(std::unique(part.views.begin(), part.views.end()), part.views.end());
  }

  template <typename Add>
  void add_shares(const PartialChart& part, const Add& add) const {
    std::vector<TexelShares> begun(part.views.size());
    const auto width = static_cast<std::uint32_t>(raster_.width());
    for_shares(part, [&](std::size_t i, std::size_t source, std::uint8_t weight) {
      const auto view = static_cast<std::uint32_t>(part.sources[place_[source]].view);
      const auto group = static_cast<std::size_t>(std::ranges::lower_bound(part.views, view) - part.views.begin());
      TexelShares& last = begun[group];
      TexelShares next{static_cast<std::uint32_t>(i), place_[source], weight, raster_.reach[i], 1};
      const bool begins_block = next.texel % width % kStripRow == 0;
      if (last.count > 0 && !begins_block && next.texel == last.texel + last.count && next.source == last.source &&
          next.weight == last.weight && next.reach == last.reach) {
        ++last.count;
        return;
      }
      if (last.count > 0) add(group, last);
      last = next;
    });
    for (std::size_t group = 0; group < begun.size(); ++group) add(group, begun[group]);
  }

  const AtlasInput& input_;
  const AtlasOptions& options_;
  const ChartSet& set_;
  const CoverageIndex& coverage_;
  const visibility::CoverageTable& table_;
  ChartRaster raster_;
  Grouped<TexelSource> sources_;          ///< per face of the chart, best first
  std::vector<std::uint32_t> face_slot_;  ///< per texel: the place of its owner in the chart's list of faces
  std::vector<Choice> choice_;            ///< per texel
  std::vector<std::uint32_t> place_;      ///< per source: in the PartialChart, kNoOwner if it gives nothing
};

}  // namespace

std::span<const TexelShares> PartialChart::shares_of(ViewId view) const {
  const auto found = std::ranges::lower_bound(views, static_cast<std::uint32_t>(view));
  if (found == views.end() || *found != static_cast<std::uint32_t>(view)) return {};
  return shares[static_cast<std::size_t>(found - views.begin())];
}

std::size_t PartialChart::bytes() const {
  return sizeof(PartialChart) + sources.capacity() * sizeof(TexelSource) + views.capacity() * sizeof(std::uint32_t) +
         shares.items.capacity() * sizeof(TexelShares) + shares.first.capacity() * sizeof(std::size_t) +
         blended.capacity() * sizeof(BlendedTexel) + known.capacity() / 8;
}

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

std::size_t choosing_bytes(const Chart& chart, const CoverageIndex& coverage, int margin_px) {
  // For each texel of the box a raster, a face and a choice, of 12 bytes together, and for few of them a share of its own. For
  // each face of the chart the sources of some eight views.
  constexpr std::size_t kTexel = 12 + sizeof(TexelShares) / 3, kSources = 8 * sizeof(TexelSource);
  const CellBox box = partial_box(chart);
  std::size_t bytes = kTexel * pixel_index(0, box.y1 - box.y0, box.x1 - box.x0) + kSources * chart.faces.size();
  if (margin_px <= 0) return bytes;
  // Clearances, as if the face were hidden somewhere in every view; no more are made than candidates are looked at.
  for (const std::uint32_t face : chart.faces) {
    std::size_t all = 0, largest = 0;
    coverage.for_views(FaceId{face}, [&](const visibility::FaceCoverage& entry) {
      const std::size_t clearance = sizeof(Sight) * box_pixels(entry);
      all += clearance;
      largest = std::max(largest, clearance);
    });
    bytes += std::min(all, kMostCandidates * largest);
  }
  return bytes;
}

std::vector<PartialChart> choose_sources(const AtlasInput& input, const AtlasOptions& options, const ChartSet& set,
                                         const CoverageIndex& coverage, std::span<const std::uint32_t> charts) {
  std::vector<PartialChart> parts(charts.size());
  tbb::parallel_for(std::size_t{0}, charts.size(),
                    [&](std::size_t i) { parts[i] = SourceChooser(input, options, set, coverage).choose(charts[i]); });
  return parts;
}

PointOrigin origin_at(const PartialChart& part, const Chart& chart, const TexelPoint& p) {
  const CellBox box = partial_box(chart);
  const int x = std::clamp(static_cast<int>(std::floor(p.x)), box.x0, box.x1 - 1);
  const int y = std::clamp(static_cast<int>(std::floor(p.y)), box.y0, box.y1 - 1);
  const auto texel = static_cast<std::uint32_t>(pixel_index(x - box.x0, y - box.y0, box.x1 - box.x0));
  PointOrigin origin;
  if (!part.known[texel]) return origin;
  const auto order = [&](const TexelShares& share) { return block_order(share.texel, box); };
  for (std::size_t v = 0; v < part.views.size(); ++v) {
    const auto shares = part.shares[v];
    const auto after = std::ranges::upper_bound(shares, block_order(texel, box), {}, order);
    if (after == shares.begin()) continue;
    const auto share = std::prev(after);
    if (texel < share->texel || texel - share->texel >= share->count) continue;
    const TexelSource& source = part.sources[share->source];
    // Behind the camera: outside the photo.
    const PixelPoint place = source.frame_from_texel(p.x, p.y).value_or(PixelPoint{-1, -1});
    // The second view has less than half.
    if (2 * share->weight > PartialChart::kBlendSteps) {
      origin.first = source.view;
      origin.first_at = place;
    } else {
      origin.second = source.view;
      origin.second_at = place;
      origin.second_share = double(share->weight) / PartialChart::kBlendSteps;
    }
  }
  return origin;
}

}  // namespace gpvc::atlas
