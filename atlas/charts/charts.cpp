#include "atlas/charts/charts.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <unordered_set>
#include <utility>

#include "atlas/charts/chart_cutting.h"
#include "atlas/charts/chart_merging.h"
#include "atlas/charts/chart_shape.h"
#include "atlas/charts/flat_chart.h"
#include "atlas/charts/texel_set.h"
#include "io/vector.h"

namespace gpvc::atlas {

namespace {

/// Edge, in world units, of a pixel projected onto the faces: the root of their area in the world over that in the
/// frame; zero if either is. `corners` are frame positions.
double pixel_size(const Mesh& mesh, std::span<const std::uint32_t> faces, std::span<const TexelTriangle> corners) {
  double world = 0, frame = 0;
  for (const auto face : faces) {
    const auto& t = mesh.faces[face];
    const WorldPoint& a = mesh.positions[t[0]];
    world += length(cross(mesh.positions[t[1]] - a, mesh.positions[t[2]] - a)) / 2;
    frame += std::abs(doubled_area(corners[face])) / 2;
  }
  return world > 0 && frame > 0 ? std::sqrt(world / frame) : 0;
}

/// Scale, at most 1, that makes texels of `texel_size` (world units; 0: no reduction) from pixels of `pixel_size`.
/// Rounded up to steps of an eighth of an octave, so that neighbouring parts can share charts.
double scale_for(double texel_size, double pixel_size) {
  constexpr double kSteps = 8;  // an octave
  if (!(texel_size > 0) || !(pixel_size > 0) || pixel_size >= texel_size) return 1;
  return std::min(1.0, std::exp2(std::ceil(kSteps * std::log2(pixel_size / texel_size)) / kSteps));
}

/// The seed and all faces connected with it through faces that `joins` accepts, breadth first. `joins` is asked anew
/// for each edge, so it must refuse faces that it has accepted.
template <typename Joins>
std::vector<std::uint32_t> flood(const FaceNeighbours& neighbours, std::uint32_t seed, const Joins& joins) {
  std::vector<std::uint32_t> faces{seed};
  for (std::size_t next = 0; next < faces.size(); ++next)
    for (const auto other : neighbours[faces[next]])
      if (joins(other)) faces.push_back(other);
  return faces;
}

class ChartMaker {
 public:
  ChartMaker(const AtlasInput& input, const AtlasOptions& options, const FaceNeighbours& neighbours,
             const CoverageIndex& coverage, double reduction)
      : input_(input),
        options_(options),
        coverage_(coverage),
        neighbours_(neighbours),
        reduction_(reduction),
        room_(options.page_size - 2 * options.padding),
        uses_(input.mesh.faces.size()),
        scales_(input.mesh.faces.size(), 1.0),
        taken_(input.mesh.faces.size(), 0),
        group_(input.mesh.faces.size(), 0) {
    result_.face_chart.resize(input.mesh.faces.size());
    result_.corners.resize(input.mesh.faces.size());
  }

  ChartSet make() {
    // Until a face is in a chart, its corners are positions in its view's frame times the face's scale.
    tbb::parallel_for(std::size_t{0}, uses_.size(),
                      [&](std::size_t face) { uses_[face] = use_of(face, result_.corners[face]); });
    choose_scales();
    add_plain();
    add_partial();
    for (const auto face : faces_of(ChartKind::flat)) add_flat(face);
    add_unseen();
    result_.placed = result_.charts.size();
    for (auto& part : connected_parts(faces_of(ChartKind::border)))
      add_projected(ChartKind::border, part_of(std::move(part)), 1, next_chart());
    return std::move(result_);
  }

 private:
  ChartKind use_of(std::size_t face, TexelTriangle& corners) const {
    std::array<double, 3> depths{};
    const ChartKind use = use_of_projection(face, corners, depths);
    if (!input_.border.empty() && input_.border[face]) {
      if (use == ChartKind::flat) corners = {};
      return ChartKind::border;
    }
    const bool projected = use == ChartKind::plain || use == ChartKind::partial;
    return projected && bend(corners, depths) > kMostBend ? ChartKind::flat : use;
  }

  ChartKind use_of_projection(std::size_t face, TexelTriangle& corners, std::array<double, 3>& depths) const {
    const ViewId label = input_.labels[face];
    if (!has_view(input_, face)) return ChartKind::unseen;
    const View& view = input_.scene.views[index(label)];
    const std::optional<ProjectedFace> projected = project_face(input_.mesh, static_cast<std::uint32_t>(face), view);
    if (!projected) return ChartKind::flat;
    // A partial face may reach far beyond the image, where its texels would be sized by a view that does not see
    // them. Beyond one image size in any direction the face gets a parametrization of its own.
    const double w = view.camera.width, h = view.camera.height;
    for (const TexelPoint& q : projected->corners)
      if (!(q.x >= -w && q.x <= 2 * w && q.y >= -h && q.y <= 2 * h)) return ChartKind::flat;
    corners = projected->corners;
    depths = projected->depths;
    if (input_.tags[face] != labeling::FaceTag::partial) return ChartKind::plain;
    return is_grazing(corners, input_.mesh, face) ? ChartKind::flat : ChartKind::partial;
  }

  /// Connected faces of one view get the same scale, so that they can share charts.
  void choose_scales() {
    std::vector<std::uint32_t> projected;
    for (std::uint32_t face = 0; face < uses_.size(); ++face)
      if (uses_[face] == ChartKind::plain || uses_[face] == ChartKind::partial) projected.push_back(face);
    if (options_.texel_size > 0 || reduction_ < 1) {
      for (const auto& part : connected_parts(projected)) {
        const double scale =
            reduction_ * scale_for(options_.texel_size, pixel_size(input_.mesh, part, result_.corners));
        for (const auto face : part) scales_[face] = scale;
      }
    }
    tbb::parallel_for(std::size_t{0}, projected.size(), [&](std::size_t i) {
      const std::uint32_t face = projected[i];
      for (auto& p : result_.corners[face]) p = {scales_[face] * p.x, scales_[face] * p.y};
      FrameBox box;
      box.add(result_.corners[face]);
      if (uses_[face] == ChartKind::partial && !fits(box)) uses_[face] = ChartKind::flat;
    });
  }

  bool may_share_chart(std::uint32_t face, std::uint32_t other) const {
    return input_.labels[face] == input_.labels[other] && tile_of(input_, face) == tile_of(input_, other);
  }

  /// Parts of `faces` that are connected and have one label and tile; faces ascend within a part, and parts by their first face.
  std::vector<std::vector<std::uint32_t>> connected_parts(std::span<const std::uint32_t> faces) {
    const std::uint32_t waiting = next_group_++, done = next_group_++;
    for (const auto face : faces) group_[face] = waiting;
    std::vector<std::vector<std::uint32_t>> parts;
    for (const auto seed : faces) {
      if (group_[seed] != waiting) continue;
      group_[seed] = done;
      parts.push_back(flood(neighbours_, seed, [&](std::uint32_t other) {
        if (group_[other] != waiting || !may_share_chart(other, seed)) return false;
        group_[other] = done;
        return true;
      }));
      std::sort(parts.back().begin(), parts.back().end());
    }
    return parts;
  }

  void add_plain() {
    std::vector<FramePart> parts;
    for (auto& part : connected_parts(faces_of(ChartKind::plain))) split(std::move(part), parts);
    // A texel of fully seen faces has the photo's colour whichever of them it belongs to.
    add_merged(ChartKind::plain, TexelSharing::allowed, std::move(parts));
  }

  /// Halves a set of faces that exceeds a page across its longer axis, by face centroids, until each connected part
  /// fits. A single face that does not fit is reduced later.
  void split(std::vector<std::uint32_t> faces, std::vector<FramePart>& parts) {
    FramePart part = part_of(std::move(faces));
    if (fits(part.box) || part.faces.size() == 1) return parts.push_back(std::move(part));
    const LongAxis axis(part.box);
    const auto& corners = result_.corners;
    const auto begin = part.faces.begin(), end = part.faces.end();
    auto half =
        std::stable_partition(begin, end, [&](std::uint32_t face) { return axis.in_first_half(corners[face]); });
    if (half == begin || half == end) {
      std::stable_sort(begin, end, [&](auto a, auto b) { return axis.place(corners[a]) < axis.place(corners[b]); });
      half = begin + static_cast<std::ptrdiff_t>(part.faces.size() / 2);
    }
    std::sort(begin, half);
    std::sort(half, end);
    for (const auto side : {std::span(begin, half), std::span(half, end)})
      for (auto& connected : connected_parts(side)) split(std::move(connected), parts);
  }

  void add_merged(ChartKind kind, TexelSharing sharing, std::vector<FramePart> parts) {
    const MergeRule rule{block_margin(options_.padding) + block_edge(options_.padding) / 4, sharing,
                         [this](const FrameBox& box) { return fits(box); }};
    for (auto& part : merge_close_parts(std::move(parts), result_.corners, rule)) {
      const std::uint32_t piece = next_chart();
      if (!fits(part.box)) {
        // A single face larger than a page. One texel of slack covers the rounding of the box to whole texels on both
        // sides.
        const FrameBox& box = part.box;
        const double reduction = (room_ - 1) / std::max(box.x1 - box.x0, box.y1 - box.y0);
        add_projected(kind, std::move(part), reduction, piece);
        continue;
      }
      for (auto& cut : cut_ragged(std::move(part), result_.corners)) add_projected(kind, std::move(cut), 1, piece);
    }
  }

  void add_projected(ChartKind kind, FramePart part, double reduction, std::uint32_t piece) {
    Chart chart;
    chart.kind = kind;
    chart.view = part.view;
    chart.piece = piece;
    chart.scale = part.scale * reduction;
    // Without a further reduction the texels stay on the grid of the scaled frame, for which it is known that no texel
    // centre lies in two partial faces.
    const double x0 = reduction == 1 ? std::floor(part.box.x0) : part.box.x0 * reduction;
    const double y0 = reduction == 1 ? std::floor(part.box.y0) : part.box.y0 * reduction;
    chart.origin_x = x0 / chart.scale;
    chart.origin_y = y0 / chart.scale;
    const auto texels = [&](double high, double low) {
      return std::clamp(static_cast<int>(std::ceil(high * reduction - low)), 1, room_);
    };
    chart.width = texels(part.box.x1, x0);
    chart.height = texels(part.box.y1, y0);
    for (const auto face : part.faces)
      for (auto& p : result_.corners[face]) p = {p.x * reduction - x0, p.y * reduction - y0};
    chart.faces = std::move(part.faces);
    finish(std::move(chart));
  }

  void finish(Chart chart) {
    chart.tile = tile_of(input_, chart.faces[0]);
    for (const auto face : chart.faces) result_.face_chart[face] = next_chart();
    result_.charts.push_back(std::move(chart));
  }

  /// Two partially seen faces of one connected component can project onto the same place, one behind the other. A part
  /// therefore grows over neighbours only as long as no texel centre is covered twice.
  void add_partial() {
    std::vector<FramePart> parts;
    for (const auto face : faces_of(ChartKind::partial)) {
      if (taken_[face]) continue;
      auto faces = grow_without_overlap(face);
      std::sort(faces.begin(), faces.end());
      parts.push_back(part_of(std::move(faces)));
    }
    add_merged(ChartKind::partial, TexelSharing::forbidden, std::move(parts));
  }

  std::vector<std::uint32_t> grow_without_overlap(std::uint32_t seed) {
    TexelSet covered;
    std::unordered_set<std::uint32_t> refused;
    FrameBox box;
    const auto try_add = [&](std::uint32_t face) {
      const TexelTriangle& corners = result_.corners[face];
      FrameBox grown = box;
      grown.add(corners);
      if (!fits(grown)) return false;
      bool free = true;
      covered_spans(corners, [&](int y, int first, int last) { free = free && !covered.meets(y, first, last); });
      if (!free) return false;
      covered_spans(corners, [&](int y, int first, int last) { covered.add(y, first, last); });
      box = grown;
      return true;
    };
    taken_[seed] = 1;
    try_add(seed);
    return flood(neighbours_, seed, [&](std::uint32_t other) {
      if (taken_[other] || uses_[other] != ChartKind::partial || refused.contains(other) ||
          !may_share_chart(other, seed))
        return false;
      if (try_add(other))
        taken_[other] = 1;
      else
        refused.insert(other);
      return taken_[other] != 0;
    });
  }

  void add_flat(std::uint32_t face) {
    const FlatFace flat = flatten(input_.mesh, face, input_.scene, input_.labels[face], coverage_,
                                  {room_, options_.texel_size, reduction_});
    Chart chart;
    chart.kind = ChartKind::flat;
    chart.view = input_.labels[face];
    chart.faces = {face};
    chart.piece = next_chart();
    chart.width = flat.width;
    chart.height = flat.height;
    result_.corners[face] = flat.corners;
    finish(std::move(chart));
  }

  /// Unseen faces, neighbours close to each other so that coarse mip levels mix similar colours.
  std::vector<std::uint32_t> unseen_in_order() {
    std::vector<std::uint32_t> order;
    for (const auto seed : faces_of(ChartKind::unseen)) {
      if (taken_[seed]) continue;
      taken_[seed] = 1;
      const auto connected = flood(neighbours_, seed, [&](std::uint32_t other) {
        return uses_[other] == ChartKind::unseen && !std::exchange(taken_[other], char{1});
      });
      order.insert(order.end(), connected.begin(), connected.end());
    }
    std::ranges::stable_sort(order, {}, [&](std::uint32_t face) { return tile_of(input_, face); });
    return order;
  }

  void add_unseen() {
    // Small charts fill gaps, large ones waste less padding. With a margin of 2 texels, a square of 30 takes whole
    // blocks of the page.
    constexpr int kLargestEdge = 30;
    const int edge = std::min(kLargestEdge, room_ / kUnseenTexels);  // faces
    const std::size_t capacity = static_cast<std::size_t>(edge) * static_cast<std::size_t>(edge);
    const std::vector<std::uint32_t> order = unseen_in_order();
    result_.unseen_faces = order.size();
    for (std::size_t first = 0, end = 0; first < order.size(); first = end) {
      const std::uint32_t tile = tile_of(input_, order[first]);
      while (end < order.size() && end - first < capacity && tile_of(input_, order[end]) == tile) ++end;
      Chart chart;
      chart.kind = ChartKind::unseen;
      chart.piece = next_chart();
      const auto faces = std::span(order).subspan(first, end - first);
      chart.faces.assign(faces.begin(), faces.end());
      const int count = static_cast<int>(faces.size());
      const int columns = std::min(edge, static_cast<int>(std::ceil(std::sqrt(static_cast<double>(count)))));
      chart.width = kUnseenTexels * columns;
      chart.height = kUnseenTexels * ((count + columns - 1) / columns);
      for (int k = 0; k < count; ++k) {
        const double x = kUnseenTexels * (k % columns) + 0.5, y = kUnseenTexels * (k / columns) + 0.5;
        result_.corners[faces[static_cast<std::size_t>(k)]] = {TexelPoint{x, y}, TexelPoint{x + 1, y},
                                                               TexelPoint{x, y + 1}};
      }
      finish(std::move(chart));
    }
  }

  std::vector<std::uint32_t> faces_of(ChartKind use) const {
    std::vector<std::uint32_t> faces;
    for (std::uint32_t face = 0; face < uses_.size(); ++face)
      if (uses_[face] == use) faces.push_back(face);
    return faces;
  }
  std::uint32_t next_chart() const { return static_cast<std::uint32_t>(result_.charts.size()); }
  /// \pre the faces have one view and scale
  FramePart part_of(std::vector<std::uint32_t> faces) const {
    FrameBox box;
    for (const auto face : faces) box.add(result_.corners[face]);
    return {input_.labels[faces[0]], scales_[faces[0]], tile_of(input_, faces[0]), std::move(faces), box};
  }
  bool fits(const FrameBox& box) const {
    return box.x1 - box.x0 < room_ && box.y1 - box.y0 < room_ && box.width() <= room_ && box.height() <= room_;
  }

  const AtlasInput& input_;
  const AtlasOptions& options_;
  const CoverageIndex& coverage_;
  const FaceNeighbours& neighbours_;
  double reduction_;
  int room_;  ///< texels of a page's edge left for a chart
  std::vector<ChartKind> uses_;
  std::vector<double> scales_;  ///< per face, texels a frame pixel
  std::vector<char> taken_;     ///< per face, 1 if it is in a part of partial faces or in the order of unseen ones
  std::vector<std::uint32_t> group_;  ///< per face, which flood of connected_parts has marked it last
  std::uint32_t next_group_ = 1;
  ChartSet result_;
};

}  // namespace

ChartSet make_charts(const AtlasInput& input, const AtlasOptions& options, const FaceNeighbours& neighbours,
                     const CoverageIndex& coverage, double reduction) {
  return ChartMaker(input, options, neighbours, coverage, reduction).make();
}

std::optional<std::array<std::uint32_t, 2>> shared_edge(const Triangle& a, const Triangle& b) {
  const auto in_b = [&](std::uint32_t v) { return std::find(b.begin(), b.end(), v) != b.end(); };
  for (std::size_t e = 0; e < 3; ++e) {
    const std::uint32_t u = a[e], v = a[(e + 1) % 3];
    if (u != v && in_b(u) && in_b(v)) return std::array{u, v};
  }
  return std::nullopt;
}

}  // namespace gpvc::atlas
