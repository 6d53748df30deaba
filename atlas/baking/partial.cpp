#include "atlas/baking/partial.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "atlas/baking/smooth_fill.h"
#include "atlas/vector3.h"

namespace gpvc::atlas {

namespace {

/// World position of a texel (x, y) on its face's plane: base + (dx x + dy y + d1) / (wx x + wy y + w1), the
/// denominator positive on the face.
struct PlaneMap {
  WorldPoint base;
  Vector3 dx, dy, d1;
  double wx = 0, wy = 0, w1 = 1;
};

/// Texels of a projection lie where their ray meets the plane.
std::optional<PlaneMap> map_projected(const Mesh& mesh, std::uint32_t face, const Chart& chart, const View& view) {
  const auto& t = mesh.faces[face];
  const WorldPoint& p = mesh.positions[t[0]];
  const Vector3 normal = cross(mesh.positions[t[1]] - p, mesh.positions[t[2]] - p);
  const double k = dot(normal, p - view.pose.centre);
  if (k == 0 || !std::isfinite(k)) return std::nullopt;
  const PixelPoint origin = chart.frame_position(0, 0);
  const Vector3 r1 = ray_direction(view, origin);
  const Vector3 rx = ray_direction(view, chart.frame_position(1, 0)) - r1;
  const Vector3 ry = ray_direction(view, chart.frame_position(0, 1)) - r1;
  const double sign = k < 0 ? -1 : 1;
  PlaneMap map;
  map.base = view.pose.centre;
  map.dx = std::abs(k) * rx, map.dy = std::abs(k) * ry, map.d1 = std::abs(k) * r1;
  map.wx = sign * dot(normal, rx), map.wy = sign * dot(normal, ry), map.w1 = sign * dot(normal, r1);
  return map;
}

/// Texels of a flat face are affine in its plane.
std::optional<PlaneMap> map_flat(const Mesh& mesh, std::uint32_t face, const TexelTriangle& c) {
  const auto& t = mesh.faces[face];
  const double ux = c[1].x - c[0].x, uy = c[1].y - c[0].y, vx = c[2].x - c[0].x, vy = c[2].y - c[0].y;
  const double area = ux * vy - uy * vx;
  if (area == 0) return std::nullopt;
  const Vector3 ab = mesh.positions[t[1]] - mesh.positions[t[0]], ac = mesh.positions[t[2]] - mesh.positions[t[0]];
  PlaneMap map;
  map.base = mesh.positions[t[0]];
  map.dx = (vy / area) * ab - (uy / area) * ac;
  map.dy = (ux / area) * ac - (vx / area) * ab;
  map.d1 = (-c[0].x) * map.dx + (-c[0].y) * map.dy;
  return map;
}

std::array<double, 9> frame_from_texel(const PlaneMap& map, const View& view) {
  const Vector3 shift = map.base - view.pose.centre;
  const auto column = [&](const Vector3& d, double w) {
    const Vector3 p = rotate(view.pose.rotation, d + w * shift);
    const Camera& c = view.camera;
    return Vector3{c.fx * p.x + c.cx * p.z, c.fy * p.y + c.cy * p.z, p.z};
  };
  const Vector3 x = column(map.dx, map.wx), y = column(map.dy, map.wy), one = column(map.d1, map.w1);
  return {x.x, y.x, one.x, x.y, y.y, one.y, x.z, y.z, one.z};
}

std::optional<PixelPoint> frame_position(const TexelSource& source, double x, double y) {
  const auto& m = source.frame_from_texel;
  const double w = m[6] * x + m[7] * y + m[8];
  if (!(w > 0)) return std::nullopt;
  return PixelPoint{(m[0] * x + m[1] * y + m[2]) / w, (m[3] * x + m[4] * y + m[5]) / w};
}

std::optional<TexelTriangle> outline_from(const visibility::FaceCoverage& entry, const Mesh& mesh, const View& view) {
  TexelTriangle projected;
  for (std::size_t i = 0; i < 3; ++i) {
    const CameraPoint p = camera_from_world(view.pose, mesh.positions[mesh.faces[index(entry.face)][i]]);
    if (!(p.z > 0)) return std::nullopt;
    const PixelPoint q = pixel_from_camera(view.camera, p);
    projected[i] = {q.x - entry.x0, q.y - entry.y0};
  }
  return projected;
}

/// Pixels of the coverage's box within margin_px (chessboard distance) of one where the face is hidden: 1, and 2 for
/// its neighbours, which any resampling blends with it.
std::vector<std::uint8_t> hidden_margin(const visibility::CoverageTable& table, const visibility::FaceCoverage& entry,
                                        const std::optional<TexelTriangle>& outline, int margin_px) {
  if (margin_px <= 0 || !outline) return {};
  const std::size_t width = static_cast<std::size_t>(entry.width);
  std::vector<std::uint8_t> margin(width * static_cast<std::size_t>(entry.height), 0);
  bool any = false;
  triangle_spans(*outline, 0.0, {0, 0, entry.width, entry.height}, [&](int y, int first, int last) {
    for (int x = first; x <= last; ++x) {
      if (table.sees(entry, entry.x0 + x, entry.y0 + y)) continue;
      any = true;
      for (int my = std::max(0, y - margin_px); my <= std::min(entry.height - 1, y + margin_px); ++my)
        for (int mx = std::max(0, x - margin_px); mx <= std::min(entry.width - 1, x + margin_px); ++mx) {
          std::uint8_t& level = margin[static_cast<std::size_t>(my) * width + static_cast<std::size_t>(mx)];
          const bool beside = std::abs(mx - x) <= 1 && std::abs(my - y) <= 1;
          level = std::max<std::uint8_t>(level, beside ? 2 : 1);
        }
    }
  });
  if (!any) margin.clear();
  return margin;
}

bool contains(const TexelTriangle& t, double x, double y) {
  int left = 0, right = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const TexelPoint &a = t[i], &b = t[(i + 1) % 3];
    const double side = (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
    left += side > 0;
    right += side < 0;
  }
  return left == 3 || right == 3;  // a centre on the edge may be the neighbour's
}

/// The pixel whose visibility speaks for a place on the face: the one it lies in, or, where that pixel's centre lies
/// beyond the face's edge and so says nothing of the face, the nearest of its neighbours whose does not.
std::array<int, 2> deciding_pixel(const TexelSource& source, const PixelPoint& p) {
  const int px = static_cast<int>(std::floor(p.x)), py = static_cast<int>(std::floor(p.y));
  const visibility::FaceCoverage& c = *source.coverage;
  const auto in_face = [&](int x, int y) { return contains(*source.outline, x + 0.5 - c.x0, y + 0.5 - c.y0); };
  if (!source.outline || in_face(px, py)) return {px, py};
  std::array<int, 2> nearest{px, py};
  double least = 1e9;
  for (int y = py - 1; y <= py + 1; ++y)
    for (int x = px - 1; x <= px + 1; ++x) {
      const double away = std::hypot(x + 0.5 - p.x, y + 0.5 - p.y);
      if (away >= least || !in_face(x, y)) continue;
      least = away;
      nearest = {x, y};
    }
  return nearest;
}

enum class Shown { no, beside_occluder, near_occluder, clear };

Shown shown(const visibility::CoverageTable& table, const TexelSource& source, double x, double y) {
  const auto p = frame_position(source, x, y);
  if (!p) return Shown::no;
  if (!source.coverage) return Shown::clear;
  const visibility::FaceCoverage& c = *source.coverage;
  // Far outside the box before the cast, which must not overflow.
  if (!(p->x >= c.x0 - 1 && p->y >= c.y0 - 1 && p->x < c.x0 + c.width + 1 && p->y < c.y0 + c.height + 1))
    return Shown::no;
  const auto [px, py] = deciding_pixel(source, *p);
  if (px < c.x0 || py < c.y0 || px >= c.x0 + c.width || py >= c.y0 + c.height || !table.sees(c, px, py))
    return Shown::no;
  if (source.margin.empty()) return Shown::clear;
  const std::size_t i =
      static_cast<std::size_t>(py - c.y0) * static_cast<std::size_t>(c.width) + static_cast<std::size_t>(px - c.x0);
  constexpr Shown kLevels[] = {Shown::clear, Shown::near_occluder, Shown::beside_occluder};
  return kLevels[source.margin[i]];
}

/// Candidate views of a face, the label's first, then by cost.
std::vector<ViewId> ordered_candidates(const AtlasInput& input, std::uint32_t face) {
  constexpr std::size_t kMost = 64;
  std::vector<std::pair<float, std::uint32_t>> others;
  const ViewId label = input.labels[face];
  if (face < input.candidates.faces()) {
    for (std::size_t k = input.candidates.first[face]; k < input.candidates.first[face + 1]; ++k)
      if (ViewId{input.candidates.views[k]} != label)
        others.emplace_back(input.candidates.costs[k], input.candidates.views[k]);
  }
  std::sort(others.begin(), others.end());
  std::vector<ViewId> result{label};
  for (const auto& [cost, view] : others)
    if (result.size() < kMost) result.push_back(ViewId{view});
  return result;
}

void add_sources(PartialChart& part, const AtlasInput& input, const ChartSet& set, std::uint32_t face,
                 const CoverageIndex& coverage, int margin_px) {
  const Chart& chart = set.charts[part.chart];
  const auto map = chart.kind == ChartKind::flat
                       ? map_flat(input.mesh, face, set.corners[face])
                       : map_projected(input.mesh, face, chart, input.scene.views[index(chart.view)]);
  if (!map) return;
  for (const ViewId view : ordered_candidates(input, face)) {
    TexelSource source{view, coverage.find(FaceId{face}, view), {}, {}, {}};
    // A face some view sees whole needs no coverage there; a partial one without shows nothing.
    if (!source.coverage && !(input.tags[face] == labeling::FaceTag::seen && view == input.labels[face])) continue;
    source.frame_from_texel = frame_from_texel(*map, input.scene.views[index(view)]);
    if (source.coverage) {
      source.outline = outline_from(*source.coverage, input.mesh, input.scene.views[index(view)]);
      source.margin = hidden_margin(coverage.table(), *source.coverage, source.outline, margin_px);
    }
    part.sources.push_back(std::move(source));
  }
}

std::span<const TexelSource> sources_at(const PartialChart& part, std::size_t texel) {
  const std::uint32_t slot = part.face_slot[texel];
  return std::span(part.sources)
      .subspan(part.first_source[slot], part.first_source[slot + 1] - part.first_source[slot]);
}

void choose_best(PartialChart& part, const visibility::CoverageTable& table) {
  for (int y = part.raster.box.y0; y < part.raster.box.y1; ++y) {
    for (int x = part.raster.box.x0; x < part.raster.box.x1; ++x) {
      const std::size_t i = part.raster.at(x, y);
      if (part.raster.owner[i] == kNoOwner) continue;
      const auto sources = sources_at(part, i);
      Shown best = Shown::no;
      for (std::uint8_t k = 0; k < sources.size() && best != Shown::clear; ++k) {
        const Shown how = shown(table, sources[k], x + 0.5, y + 0.5);
        if (how <= best) continue;
        best = how;
        part.best[i] = k;
      }
    }
  }
}

/// Near another view's texels, this texel takes a part of that view: 1/3 beside the border, 1/6 one texel further, so
/// that the two sides meet in equal steps.
void choose_second(PartialChart& part, const visibility::CoverageTable& table) {
  constexpr int kReach = 2;
  const CellBox& box = part.raster.box;
  const auto view_at = [&](std::size_t i) {
    return part.best[i] == PartialChart::kNone ? kNoView : sources_at(part, i)[part.best[i]].view;
  };
  for (int y = box.y0; y < box.y1; ++y) {
    for (int x = box.x0; x < box.x1; ++x) {
      const std::size_t i = part.raster.at(x, y);
      const ViewId mine = view_at(i);
      if (mine == kNoView) continue;
      for (int d = 1; d <= kReach && part.second[i] == PartialChart::kNone; ++d) {
        for (int ny = std::max(box.y0, y - d); ny <= std::min(box.y1 - 1, y + d); ++ny) {
          for (int nx = std::max(box.x0, x - d); nx <= std::min(box.x1 - 1, x + d); ++nx) {
            const ViewId other = view_at(part.raster.at(nx, ny));
            if (other == kNoView || other == mine || part.second[i] != PartialChart::kNone) continue;
            const auto sources = sources_at(part, i);
            for (std::uint8_t k = 0; k < sources.size(); ++k) {
              if (sources[k].view != other || shown(table, sources[k], x + 0.5, y + 0.5) != Shown::clear) continue;
              part.second[i] = k;
              part.second_sixths[i] = d == 1 ? 2 : 1;
            }
          }
        }
      }
    }
  }
}

PartialChart start_chart(const AtlasInput& input, const ChartSet& set, std::uint32_t c, const CoverageIndex& coverage,
                         int margin_px) {
  const Chart& chart = set.charts[c];
  PartialChart part;
  part.chart = c;
  part.raster = rasterize(chart.faces, set.corners, {-1, -1, chart.width + 1, chart.height + 1});
  part.first_source.push_back(0);
  for (const auto face : chart.faces) {
    add_sources(part, input, set, face, coverage, margin_px);
    part.first_source.push_back(part.sources.size());
  }
  const std::size_t texels = part.raster.owner.size();
  part.face_slot.assign(texels, 0);
  for (std::size_t i = 0; i < texels; ++i)
    if (part.raster.owner[i] != kNoOwner)
      part.face_slot[i] = static_cast<std::uint32_t>(
          std::lower_bound(chart.faces.begin(), chart.faces.end(), part.raster.owner[i]) - chart.faces.begin());
  part.best.assign(texels, PartialChart::kNone);
  part.second.assign(texels, PartialChart::kNone);
  part.second_sixths.assign(texels, 0);
  choose_best(part, coverage.table());
  choose_second(part, coverage.table());
  // A byte a pixel of every source: too much to keep where many photos see large faces in parts.
  for (TexelSource& source : part.sources) source.margin = {};
  for (std::size_t i = 0; i < texels; ++i)
    for (const auto k : {part.best[i], part.second[i]})
      if (k != PartialChart::kNone) part.views.push_back(static_cast<std::uint32_t>(sources_at(part, i)[k].view));
  std::sort(part.views.begin(), part.views.end());
  part.views.erase(std::unique(part.views.begin(), part.views.end()), part.views.end());
  part.color.assign(texels, Color{});
  return part;
}

/// Pixels of a view that a texel spans, at most: the edge of its footprint.
int footprint_px(const TexelSource& source, int x, int y) {
  constexpr int kMost = 64;
  const auto a = frame_position(source, x, y), b = frame_position(source, x + 1, y),
             c = frame_position(source, x, y + 1);
  if (!a || !b || !c) return 1;
  const double edge = std::max(std::hypot(b->x - a->x, b->y - a->y), std::hypot(c->x - a->x, c->y - a->y));
  // A texel as fine as the photo takes one sample, though rounding puts its edge above a pixel.
  return static_cast<int>(std::ceil(std::clamp(edge - 0.01, 1.0, double{kMost})));
}

/// Colour of the view over a texel: one sample where texels are as fine as pixels, else the mean of those that show the
/// face.
std::optional<Color> sample_texel(const TexelSource& source, const visibility::CoverageTable& table, const View& view,
                                  ViewId id, const Image& photo, const ColorCorrection& correction, int x, int y) {
  const int taps = footprint_px(source, x, y);
  Color sum;
  int count = 0;
  for (int j = 0; j < taps; ++j) {
    for (int i = 0; i < taps; ++i) {
      const double tx = x + (i + 0.5) / taps, ty = y + (j + 0.5) / taps;
      if (taps > 1 && shown(table, source, tx, ty) == Shown::no) continue;
      const auto p = frame_position(source, tx, ty);
      const auto q = p ? photo_from_pixel(view.camera, *p) : std::nullopt;
      if (!q) continue;
      sum = sum + correction.expose(sample_bicubic(photo, q->x, q->y), id, *p);
      ++count;
    }
  }
  if (count == 0) return std::nullopt;
  return (1.0f / static_cast<float>(count)) * sum;
}

void take_texel(PartialChart& part, const ChartSet& set, const visibility::CoverageTable& table, const View& view,
                ViewId id, const Image& photo, const ColorCorrection& correction, const Color* strip, int x, int y) {
  const std::size_t i = part.raster.at(x, y);
  for (const bool first : {true, false}) {
    const std::uint8_t k = first ? part.best[i] : part.second[i];
    if (k == PartialChart::kNone || sources_at(part, i)[k].view != id) continue;
    auto color = sample_texel(sources_at(part, i)[k], table, view, id, photo, correction, x, y);
    if (!color) {
      part.best[i] = PartialChart::kNone;
      continue;
    }
    // Offsets and strips belong to the chart's own view; of other views the exposure alone is corrected.
    if (strip) {
      const std::uint32_t owner = part.raster.owner[i];
      *color = *color + correction.face_offset(owner, set.corners[owner], x + 0.5, y + 0.5) + *strip;
    }
    const float second_weight = static_cast<float>(part.second_sixths[i]) / 6;
    part.color[i] = part.color[i] + (first ? 1 - second_weight : second_weight) * *color;
  }
}

TexelState state_of(TexelReach reach) { return reach == TexelReach::ring ? TexelState::ring : TexelState::chart; }

void write_chart(const PartialChart& part, const ChartPlace& place, int padding, Page& page,
                 std::span<const std::uint8_t> known) {
  const CellBox& box = part.raster.box;
  for (int y = box.y0; y < box.y1; ++y) {
    for (int x = box.x0; x < box.x1; ++x) {
      const std::size_t i = part.raster.at(x, y);
      const TexelReach reach = part.raster.reach[i];
      if (reach == TexelReach::outside || !known[i] || (reach == TexelReach::ring && padding < 1)) continue;
      const auto texel = place.texel(x, y);
      page.put(texel.x, texel.y, part.color[i], state_of(reach));
    }
  }
}

/// Colours of the charts beside this one, along the edges they share, for texels without one of their own.
void seed_border(PartialChart& part, std::vector<std::uint8_t>& known, const AtlasInput& input, const ChartSet& set,
                 const FaceNeighbours& neighbours, std::span<const ChartPlace> places, std::span<const Page> pages) {
  const auto corner_of = [&](std::uint32_t face, std::uint32_t vertex) -> const TexelPoint* {
    for (std::size_t i = 0; i < 3; ++i)
      if (input.mesh.faces[face][i] == vertex) return &set.corners[face][i];
    return nullptr;
  };
  for (const auto face : set.charts[part.chart].faces) {
    for (std::size_t n = neighbours.first[face]; n < neighbours.first[face + 1]; ++n) {
      const std::uint32_t other = neighbours.faces[n];
      if (set.face_chart[other] == part.chart) continue;
      const ChartPlace& place = places[set.face_chart[other]];
      const Page& page = pages[place.page];
      for (std::size_t e = 0; e < 3; ++e) {
        const std::uint32_t a = input.mesh.faces[face][e], b = input.mesh.faces[face][(e + 1) % 3];
        const TexelPoint *there_a = corner_of(other, a), *there_b = corner_of(other, b);
        if (!there_a || !there_b) continue;
        const TexelPoint &here_a = set.corners[face][e], &here_b = set.corners[face][(e + 1) % 3];
        const int steps = 1 + static_cast<int>(std::ceil(std::hypot(here_b.x - here_a.x, here_b.y - here_a.y)));
        for (int s = 0; s <= steps; ++s) {
          const double t = double(s) / steps;
          const auto mix = [t](const TexelPoint& p, const TexelPoint& q) {
            return TexelPoint{p.x + t * (q.x - p.x), p.y + t * (q.y - p.y)};
          };
          const TexelPoint here = mix(here_a, here_b), there = place.point(mix(*there_a, *there_b));
          const int x = static_cast<int>(std::floor(here.x)), y = static_cast<int>(std::floor(here.y));
          const CellBox& box = part.raster.box;
          if (x < box.x0 || y < box.y0 || x >= box.x1 || y >= box.y1) continue;
          const int px = std::clamp(static_cast<int>(there.x), 0, page.image.width - 1);
          const int py = std::clamp(static_cast<int>(there.y), 0, page.image.height - 1);
          const std::size_t i = part.raster.at(x, y);
          if (known[i] || page.state[page.at(px, py)] == TexelState::empty) continue;
          part.color[i] = load(page.image.at(px, py));
          known[i] = 1;
        }
      }
    }
  }
}

}  // namespace

std::vector<PartialChart> choose_sources(const AtlasInput& input, const ChartSet& set, const CoverageIndex& coverage,
                                         int margin_px) {
  std::vector<std::uint32_t> charts;
  for (std::uint32_t c = 0; c < set.charts.size(); ++c)
    if (set.charts[c].kind == ChartKind::partial || set.charts[c].kind == ChartKind::flat) charts.push_back(c);
  std::vector<PartialChart> parts(charts.size());
  tbb::parallel_for(std::size_t{0}, charts.size(),
                    [&](std::size_t i) { parts[i] = start_chart(input, set, charts[i], coverage, margin_px); });
  return parts;
}

PointOrigin origin_at(const PartialChart& part, const TexelPoint& p) {
  const CellBox& box = part.raster.box;
  const int x = std::clamp(static_cast<int>(std::floor(p.x)), box.x0, box.x1 - 1),
            y = std::clamp(static_cast<int>(std::floor(p.y)), box.y0, box.y1 - 1);
  const std::size_t i = part.raster.at(x, y);
  if (part.best[i] == PartialChart::kNone) return {};
  const auto sources = sources_at(part, i);
  const auto place = [&](const TexelSource& source) {
    return frame_position(source, p.x, p.y).value_or(PixelPoint{-1, -1});  // behind: off the photo
  };
  PointOrigin origin;
  origin.first = sources[part.best[i]].view;
  origin.first_at = place(sources[part.best[i]]);
  if (part.second[i] == PartialChart::kNone) return origin;
  origin.second = sources[part.second[i]].view;
  origin.second_at = place(sources[part.second[i]]);
  origin.second_share = part.second_sixths[i] / 6.0;
  return origin;
}

void take_view(PartialChart& part, const ChartSet& set, const visibility::CoverageTable& table, const View& view,
               ViewId id, const Image& photo, const ColorCorrection& correction) {
  const CellBox& box = part.raster.box;
  const bool own = set.charts[part.chart].view == id;
  std::vector<StripSample> near;
  for (int y = box.y0; y < box.y1; y += kStripRow) {
    for (int x = box.x0; x < box.x1; x += kStripRow) {
      const CellBox block{x, y, std::min(x + kStripRow, box.x1), std::min(y + kStripRow, box.y1)};
      near.clear();
      if (const ChartStrip* strip = own ? correction.strip(part.chart) : nullptr) gather_strip(*strip, block, near);
      for (int ty = block.y0; ty < block.y1; ++ty) {
        std::array<Color, kStripRow> row{};
        if (!near.empty()) row = strip_offsets(near, x + 0.5, ty + 0.5);
        for (int tx = block.x0; tx < block.x1; ++tx)
          take_texel(part, set, table, view, id, photo, correction,
                     own ? &row[static_cast<std::size_t>(tx - x)] : nullptr, tx, ty);
      }
    }
  }
}

void finish_partial(std::span<PartialChart> parts, const AtlasInput& input, const ChartSet& set,
                    const FaceNeighbours& neighbours, std::span<const ChartPlace> places, int padding,
                    std::span<Page> pages) {
  std::vector<std::vector<std::uint8_t>> known(parts.size());
  tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t p) {
    known[p].resize(parts[p].best.size());
    for (std::size_t i = 0; i < known[p].size(); ++i) known[p][i] = parts[p].best[i] != PartialChart::kNone;
    const ChartPlace& place = places[parts[p].chart];
    write_chart(parts[p], place, padding, pages[place.page], known[p]);
  });
  // Charts that nothing around them shows yet wait for their neighbours, round after round.
  std::vector<std::size_t> open(parts.size());
  for (std::size_t p = 0; p < open.size(); ++p) open[p] = p;
  while (!open.empty()) {
    tbb::parallel_for(std::size_t{0}, open.size(), [&](std::size_t k) {
      seed_border(parts[open[k]], known[open[k]], input, set, neighbours, places, pages);
    });
    std::vector<char> filled(open.size(), 0);
    tbb::parallel_for(std::size_t{0}, open.size(), [&](std::size_t k) {
      PartialChart& part = parts[open[k]];
      auto& mine = known[open[k]];
      if (!smooth_fill(part.color, mine, part.raster.width(), part.raster.height())) return;
      const ChartPlace& place = places[part.chart];
      write_chart(part, place, padding, pages[place.page], mine);
      filled[k] = 1;
    });
    std::vector<std::size_t> left;
    for (std::size_t k = 0; k < open.size(); ++k)
      if (!filled[k]) left.push_back(open[k]);
    if (left.size() == open.size()) break;
    open = std::move(left);
  }
  if (open.empty()) return;
  const Color mean = mean_color(pages);
  for (const auto p : open) {
    std::fill(parts[p].color.begin(), parts[p].color.end(), mean);
    std::fill(known[p].begin(), known[p].end(), std::uint8_t{1});
    const ChartPlace& place = places[parts[p].chart];
    write_chart(parts[p], place, padding, pages[place.page], known[p]);
  }
}

}  // namespace gpvc::atlas
