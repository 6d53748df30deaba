#include "atlas/charts/charts.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <unordered_set>

#include "atlas/baking/coverage_index.h"
#include "atlas/baking/texel_set.h"
#include "atlas/charts/chart_merging.h"
#include "atlas/charts/chart_shape.h"
#include "atlas/charts/flat_chart.h"
#include "atlas/charts/texel_density.h"

namespace gpvc::atlas {

namespace {

enum class FaceUse : std::uint8_t { plain, partial, flat, unseen };

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
        group_(input.mesh.faces.size(), 0) {
    result_.face_chart.resize(input.mesh.faces.size());
    result_.corners.resize(input.mesh.faces.size());
  }

  ChartSet make() {
    project();
    choose_scales();
    add_plain();
    add_partial();
    add_flat();
    add_blocks();
    return std::move(result_);
  }

 private:
  void project();
  void choose_scales();
  FaceUse use_of(std::size_t face, TexelTriangle& corners) const;
  void add_plain();
  void add_partial();
  void add_flat();
  void add_blocks();
  void split(std::vector<std::uint32_t> faces, std::vector<FramePart>& parts);
  void add_merged(ChartKind kind, TexelSharing sharing, std::vector<FramePart> parts);
  void cut_ragged(FramePart part, std::vector<FramePart>& pieces) const;
  void add_projected(ChartKind kind, FramePart part, double reduction, std::uint32_t piece);
  std::vector<std::vector<std::uint32_t>> connected_parts(std::span<const std::uint32_t> faces);
  std::vector<std::uint32_t> grow_without_overlap(std::uint32_t seed, std::vector<char>& taken) const;

  FrameBox box_of(std::span<const std::uint32_t> faces) const {
    FrameBox box;
    for (const auto face : faces) box.add(result_.corners[face]);
    return box;
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
  std::vector<FaceUse> uses_;
  std::vector<double> scales_;        ///< per face, texels a frame pixel
  std::vector<std::uint32_t> group_;  ///< marks of the sets being flooded
  std::uint32_t next_group_ = 1;
  ChartSet result_;
};

/// Until charts are made, corners hold positions in the texels of the whole frame at the face's scale.
void ChartMaker::project() {
  tbb::parallel_for(std::size_t{0}, uses_.size(),
                    [&](std::size_t face) { uses_[face] = use_of(face, result_.corners[face]); });
}

FaceUse ChartMaker::use_of(std::size_t face, TexelTriangle& corners) const {
  const ViewId label = input_.labels[face];
  if (label == kNoView || input_.tags[face] == labeling::FaceTag::unseen) return FaceUse::unseen;
  const View& view = input_.scene.views[index(label)];
  const FaceUse wanted = input_.tags[face] == labeling::FaceTag::partial ? FaceUse::partial : FaceUse::plain;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& position = input_.mesh.positions[input_.mesh.faces[face][i]];
    const CameraPoint p = camera_from_world(view.pose, position);
    if (!(p.z > 0)) return FaceUse::flat;
    const PixelPoint q = pixel_from_camera(view.camera, p);
    // A partial face may reach far beyond the image; texels there would be sized by a view that does not see them. One
    // image size each way is allowed before the face gets a parametrization of its own.
    const double w = view.camera.width, h = view.camera.height;
    if (!(q.x >= -w && q.x <= 2 * w && q.y >= -h && q.y <= 2 * h)) return FaceUse::flat;
    corners[i] = {q.x, q.y};
  }
  if (wanted == FaceUse::plain) return wanted;
  return is_grazing(corners, input_.mesh, face) ? FaceUse::flat : FaceUse::partial;
}

/// Connected faces of one view share a scale, so that they can share charts.
void ChartMaker::choose_scales() {
  std::vector<std::uint32_t> projected;
  for (std::uint32_t face = 0; face < uses_.size(); ++face)
    if (uses_[face] == FaceUse::plain || uses_[face] == FaceUse::partial) projected.push_back(face);
  if (options_.texel_size > 0 || reduction_ < 1) {
    for (const auto& part : connected_parts(projected)) {
      const double scale = reduction_ * scale_for(options_.texel_size, pixel_size(input_.mesh, part, result_.corners));
      for (const auto face : part) scales_[face] = scale;
    }
  }
  tbb::parallel_for(std::size_t{0}, projected.size(), [&](std::size_t i) {
    const std::uint32_t face = projected[i];
    for (auto& p : result_.corners[face]) p = {scales_[face] * p.x, scales_[face] * p.y};
    FrameBox box;
    box.add(result_.corners[face]);
    if (uses_[face] == FaceUse::partial && !fits(box)) uses_[face] = FaceUse::flat;
  });
}

/// Floods `faces` into connected parts, each in ascending order, parts by their first face.
std::vector<std::vector<std::uint32_t>> ChartMaker::connected_parts(std::span<const std::uint32_t> faces) {
  const std::uint32_t waiting = next_group_++, done = next_group_++;
  for (const auto face : faces) group_[face] = waiting;
  std::vector<std::vector<std::uint32_t>> parts;
  for (const auto seed : faces) {
    if (group_[seed] != waiting) continue;
    std::vector<std::uint32_t> part{seed};
    group_[seed] = done;
    for (std::size_t next = 0; next < part.size(); ++next) {
      const std::uint32_t face = part[next];
      for (std::size_t k = neighbours_.first[face]; k < neighbours_.first[face + 1]; ++k) {
        const std::uint32_t other = neighbours_.faces[k];
        if (group_[other] != waiting || input_.labels[other] != input_.labels[face]) continue;
        group_[other] = done;
        part.push_back(other);
      }
    }
    std::sort(part.begin(), part.end());
    parts.push_back(std::move(part));
  }
  return parts;
}

void ChartMaker::add_plain() {
  std::vector<std::uint32_t> faces;
  for (std::uint32_t face = 0; face < uses_.size(); ++face)
    if (uses_[face] == FaceUse::plain) faces.push_back(face);
  std::vector<FramePart> parts;
  for (auto& part : connected_parts(faces)) split(std::move(part), parts);
  // Texels of fully visible faces are the photo's, whichever face reads them.
  add_merged(ChartKind::plain, TexelSharing::allowed, std::move(parts));
}

/// Halves a set that exceeds a page across its longer axis by face centroids, until each connected part fits; a single
/// face that does not is left to be reduced.
void ChartMaker::split(std::vector<std::uint32_t> faces, std::vector<FramePart>& parts) {
  const FrameBox box = box_of(faces);
  if (fits(box) || faces.size() == 1) {
    const std::uint32_t first = faces.front();
    parts.push_back({input_.labels[first], scales_[first], std::move(faces), box});
    return;
  }
  const bool along_x = box.x1 - box.x0 >= box.y1 - box.y0;
  const auto centroid = [&](std::uint32_t face) {
    const TexelTriangle& t = result_.corners[face];
    return along_x ? t[0].x + t[1].x + t[2].x : t[0].y + t[1].y + t[2].y;
  };
  const double middle = 1.5 * (along_x ? box.x0 + box.x1 : box.y0 + box.y1);
  auto half =
      std::stable_partition(faces.begin(), faces.end(), [&](std::uint32_t face) { return centroid(face) < middle; });
  if (half == faces.begin() || half == faces.end()) {
    std::stable_sort(faces.begin(), faces.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return centroid(a) < centroid(b); });
    half = faces.begin() + static_cast<std::ptrdiff_t>(faces.size() / 2);
  }
  std::vector<std::uint32_t> low(faces.begin(), half), high(half, faces.end());
  for (auto* side : {&low, &high}) {
    std::sort(side->begin(), side->end());
    for (auto& part : connected_parts(*side)) split(std::move(part), parts);
  }
}

void ChartMaker::add_merged(ChartKind kind, TexelSharing sharing, std::vector<FramePart> parts) {
  const auto fit = [this](const FrameBox& box) { return fits(box); };
  const int closeness = block_margin(options_.padding) + block_edge(options_.padding) / 4;
  for (auto& part : merge_close_parts(std::move(parts), result_.corners, closeness, sharing, fit)) {
    const auto piece = static_cast<std::uint32_t>(result_.charts.size());
    if (!fits(part.box)) {
      // A single face larger than a page. One texel of slack covers the rounding of the box to whole texels on both
      // sides.
      const FrameBox& box = part.box;
      const double reduction = (room_ - 1) / std::max(box.x1 - box.x0, box.y1 - box.y0);
      add_projected(kind, std::move(part), reduction, piece);
      continue;
    }
    std::vector<FramePart> pieces;
    cut_ragged(std::move(part), pieces);
    for (auto& cut : pieces) add_projected(kind, std::move(cut), 1, piece);
  }
}

/// Large charts that leave much of their box empty leave holes on pages that small ones are too few to fill: halves
/// across the longer axis pack better, and cost a margin on both sides of the cut.
void ChartMaker::cut_ragged(FramePart part, std::vector<FramePart>& pieces) const {
  // Chosen on two real scenes: pages 0.67 and 0.65 full without cuts, 0.82 and 0.77 with these; half and twice the
  // length and shares of 0.5 and 0.66 all did worse on one of them.
  constexpr double kLong = 250, kRagged = 0.55;
  const double width = part.box.x1 - part.box.x0, height = part.box.y1 - part.box.y0;
  double area = 0;
  for (const auto face : part.faces) area += texel_area(result_.corners[face]);
  if (std::max(width, height) <= kLong || area > kRagged * width * height || part.faces.size() < 2)
    return pieces.push_back(std::move(part));
  const bool along_x = width >= height;
  const double middle = 1.5 * (along_x ? part.box.x0 + part.box.x1 : part.box.y0 + part.box.y1);
  std::array<FramePart, 2> halves{FramePart{part.view, part.scale, {}, {}}, FramePart{part.view, part.scale, {}, {}}};
  for (const auto face : part.faces) {
    const TexelTriangle& t = result_.corners[face];
    const double centroid = along_x ? t[0].x + t[1].x + t[2].x : t[0].y + t[1].y + t[2].y;
    FramePart& half = halves[centroid < middle ? 0 : 1];
    half.faces.push_back(face);
    half.box.add(t);
  }
  if (halves[0].faces.empty() || halves[1].faces.empty()) return pieces.push_back(std::move(part));
  for (auto& half : halves) cut_ragged(std::move(half), pieces);
}

void ChartMaker::add_projected(ChartKind kind, FramePart part, double reduction, std::uint32_t piece) {
  Chart chart;
  chart.kind = kind;
  chart.view = part.view;
  chart.piece = piece;
  chart.scale = part.scale * reduction;
  // Texels of the whole frame at the chart's scale: without a further reduction the chart keeps its place in their
  // grid, so that what was found out about texel centres holds.
  double x0 = std::floor(part.box.x0), y0 = std::floor(part.box.y0);
  if (reduction != 1) x0 = part.box.x0 * reduction, y0 = part.box.y0 * reduction;
  chart.origin_x = x0 / chart.scale, chart.origin_y = y0 / chart.scale;
  const auto texels = [&](double high, double low) {
    return std::clamp(static_cast<int>(std::ceil(high * reduction - low)), 1, room_);
  };
  chart.width = texels(part.box.x1, x0), chart.height = texels(part.box.y1, y0);
  for (const auto face : part.faces) {
    result_.face_chart[face] = static_cast<std::uint32_t>(result_.charts.size());
    for (auto& p : result_.corners[face]) p = {p.x * reduction - x0, p.y * reduction - y0};
  }
  chart.faces = std::move(part.faces);
  result_.charts.push_back(std::move(chart));
}

/// Partial faces hide behind others, so two of one component can project onto the same place. A part grows over
/// neighbours as long as no texel centre is covered twice.
void ChartMaker::add_partial() {
  std::vector<char> taken(uses_.size(), 0);
  std::vector<FramePart> parts;
  for (std::uint32_t face = 0; face < uses_.size(); ++face) {
    if (uses_[face] != FaceUse::partial || taken[face]) continue;
    auto faces = grow_without_overlap(face, taken);
    std::sort(faces.begin(), faces.end());
    const FrameBox box = box_of(faces);
    parts.push_back({input_.labels[face], scales_[face], std::move(faces), box});
  }
  add_merged(ChartKind::partial, TexelSharing::forbidden, std::move(parts));
}

std::vector<std::uint32_t> ChartMaker::grow_without_overlap(std::uint32_t seed, std::vector<char>& taken) const {
  TexelSet covered;
  std::unordered_set<std::uint32_t> refused;
  FrameBox box;
  const auto try_add = [&](std::uint32_t face) {
    FrameBox grown = box;
    grown.add(result_.corners[face]);
    if (!fits(grown)) return false;
    bool free = true;
    covered_spans(result_.corners[face],
                  [&](int y, int first, int last) { free = free && !covered.meets(y, first, last); });
    if (!free) return false;
    covered_spans(result_.corners[face], [&](int y, int first, int last) { covered.add(y, first, last); });
    box = grown;
    return true;
  };
  std::vector<std::uint32_t> faces{seed};
  taken[seed] = 1;
  try_add(seed);
  for (std::size_t next = 0; next < faces.size(); ++next) {
    for (std::size_t k = neighbours_.first[faces[next]]; k < neighbours_.first[faces[next] + 1]; ++k) {
      const std::uint32_t other = neighbours_.faces[k];
      if (taken[other] || uses_[other] != FaceUse::partial || refused.contains(other) ||
          input_.labels[other] != input_.labels[seed])
        continue;
      if (try_add(other)) {
        taken[other] = 1;
        faces.push_back(other);
      } else {
        refused.insert(other);
      }
    }
  }
  return faces;
}

void ChartMaker::add_flat() {
  for (std::uint32_t face = 0; face < uses_.size(); ++face) {
    if (uses_[face] != FaceUse::flat) continue;
    const FlatFace flat = flatten(input_.mesh, face, input_.scene, input_.labels[face], coverage_,
                                  {room_, options_.texel_size, reduction_});
    Chart chart;
    chart.kind = ChartKind::flat;
    chart.view = input_.labels[face];
    chart.faces = {face};
    chart.piece = static_cast<std::uint32_t>(result_.charts.size());
    chart.width = flat.width, chart.height = flat.height;
    result_.corners[face] = flat.corners;
    result_.face_chart[face] = static_cast<std::uint32_t>(result_.charts.size());
    result_.charts.push_back(std::move(chart));
  }
}

/// Blocks of unseen faces, neighbours near each other so that coarser mip levels mix like with like.
void ChartMaker::add_blocks() {
  // Small charts fill gaps, large ones waste less padding; with a margin of 2 a square of 30 takes whole blocks of the
  // page.
  constexpr int kLargestEdge = 30;
  const int edge = std::min(kLargestEdge, room_ / kBlock);
  std::vector<std::uint32_t> order;
  std::vector<char> met(uses_.size(), 0);
  for (std::uint32_t seed = 0; seed < uses_.size(); ++seed) {
    if (uses_[seed] != FaceUse::unseen || met[seed]) continue;
    met[seed] = 1;
    std::size_t next = order.size();
    for (order.push_back(seed); next < order.size(); ++next) {
      for (std::size_t k = neighbours_.first[order[next]]; k < neighbours_.first[order[next] + 1]; ++k) {
        const std::uint32_t other = neighbours_.faces[k];
        if (uses_[other] != FaceUse::unseen || met[other]) continue;
        met[other] = 1;
        order.push_back(other);
      }
    }
  }
  result_.filled_faces = order.size();
  const std::size_t capacity = static_cast<std::size_t>(edge) * static_cast<std::size_t>(edge);
  for (std::size_t first = 0; first < order.size(); first += capacity) {
    Chart chart;
    chart.kind = ChartKind::blocks;
    chart.piece = static_cast<std::uint32_t>(result_.charts.size());
    chart.faces.assign(order.begin() + static_cast<std::ptrdiff_t>(first),
                       order.begin() + static_cast<std::ptrdiff_t>(std::min(order.size(), first + capacity)));
    const int count = static_cast<int>(chart.faces.size());
    const int columns = std::min(edge, static_cast<int>(std::ceil(std::sqrt(static_cast<double>(count)))));
    chart.width = kBlock * columns, chart.height = kBlock * ((count + columns - 1) / columns);
    for (int k = 0; k < count; ++k) {
      const std::uint32_t face = chart.faces[static_cast<std::size_t>(k)];
      const double x = kBlock * (k % columns) + 0.5, y = kBlock * (k / columns) + 0.5;
      result_.corners[face] = {TexelPoint{x, y}, TexelPoint{x + 1, y}, TexelPoint{x, y + 1}};
      result_.face_chart[face] = static_cast<std::uint32_t>(result_.charts.size());
    }
    result_.charts.push_back(std::move(chart));
  }
}

}  // namespace

FaceNeighbours face_neighbours(const labeling::FaceGraph& graph, std::size_t faces) {
  FaceNeighbours result;
  result.first.assign(faces + 1, 0);
  for (const auto& edge : graph.edges)
    for (const auto face : edge) ++result.first[face + 1];
  std::partial_sum(result.first.begin(), result.first.end(), result.first.begin());
  result.faces.resize(result.first.back());
  std::vector<std::size_t> next(result.first.begin(), result.first.end() - 1);
  for (const auto& edge : graph.edges) {
    result.faces[next[edge[0]]++] = edge[1];
    result.faces[next[edge[1]]++] = edge[0];
  }
  return result;
}

ChartSet make_charts(const AtlasInput& input, const AtlasOptions& options, const FaceNeighbours& neighbours,
                     const CoverageIndex& coverage, double reduction) {
  return ChartMaker(input, options, neighbours, coverage, reduction).make();
}

}  // namespace gpvc::atlas
