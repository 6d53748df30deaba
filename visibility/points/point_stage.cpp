// PointStage: single points and faces of a mesh in a view.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "io/closest_point.h"
#include "io/validate.h"
#include "visibility/classify/front_faces.h"
#include "visibility/points.h"
#include "visibility/points/face_tree.h"
#include "visibility/points/sight_region.h"
#include "visibility/raster/exact.h"

namespace gpvc::visibility {
namespace {

struct Contender {
  FaceId face;
  RasterFace raster;
};

/// True if a face that covers the position is in front of another one there.
bool is_before(const Contender& a, const FacePoint& at_a, const Contender& b, const FacePoint& at_b) {
  const int order = compare_depth_exactly(at_a, at_b);
  return order < 0 || (order == 0 && precedes_at_equal_depth(a.raster.facing, a.face, b.raster.facing, b.face));
}

bool hides(const Contender& other, const Contender& sampled, double x, double y) {
  const FacePoint at = face_point(other.raster, x, y);
  return covers_exactly(at) && is_before(other, at, sampled, face_point(sampled.raster, x, y));
}

/// The samples of a face that others hide: a flag per pixel of the box around its spans.
class HiddenSamples {
 public:
  HiddenSamples(const Contender& sampled, const std::vector<Span>& spans) : sampled_(sampled), spans_(spans) {
    box_ = {std::numeric_limits<std::int32_t>::max(), spans.front().y, 0, spans.back().y + 1};
    for (const Span& span : spans) {
      box_.x0 = std::min(box_.x0, span.x0);
      box_.x1 = std::max(box_.x1, span.x1);
    }
    flags_.assign(place(box_.x0, box_.y1), false);
  }

  bool at(std::int32_t x, std::int32_t y) const { return flags_[place(x, y)]; }

  /// The faces are convex and the difference of both 1 / z is linear: what both ends of a run agree on holds between them.
  void hide_behind(const Contender& other) {
    const PixelBox bounds = pixel_bounds(other.raster, box_);
    if (bounds.empty()) return;
    collect_spans(other.raster, SpanWalker(other.raster, bounds), true, covered_);
    auto span = spans_.begin();
    for (const Span& run : covered_) {
      while (span != spans_.end() && span->y < run.y) ++span;
      for (auto of_row = span; of_row != spans_.end() && of_row->y == run.y; ++of_row)
        hide_run({run.y, std::max(run.x0, of_row->x0), std::min(run.x1, of_row->x1)}, other);
    }
  }

 private:
  std::size_t place(std::int32_t x, std::int32_t y) const {
    return static_cast<std::size_t>(y - box_.y0) * static_cast<std::size_t>(box_.x1 - box_.x0) +
           static_cast<std::size_t>(x - box_.x0);
  }

  void hide_run(const Span& run, const Contender& other) {
    if (run.x0 >= run.x1) return;
    const auto hidden_at = [&](std::int32_t x) {
      return is_before(other, face_point(other.raster, x + 0.5, run.y + 0.5), sampled_,
                       face_point(sampled_.raster, x + 0.5, run.y + 0.5));
    };
    const bool first = hidden_at(run.x0), last = run.x1 - run.x0 > 1 ? hidden_at(run.x1 - 1) : first;
    for (std::int32_t x = run.x0; x < run.x1; ++x)
      if (first == last ? first : hidden_at(x)) flags_[place(x, run.y)] = true;
  }

  const Contender& sampled_;
  const std::vector<Span>& spans_;
  PixelBox box_;
  std::vector<bool> flags_;
  std::vector<Span> covered_;
};

}  // namespace

struct PointStage::State {
  const Mesh& mesh;
  FaceTree tree;

  std::array<WorldPoint, 3> corners(FaceId face) const {
    const auto [a, b, c] = mesh.faces[index(face)];
    return {mesh.positions[a], mesh.positions[b], mesh.positions[c]};
  }
  Contender contender(FaceId face, const View& view) const {
    const auto [a, b, c] = corners(face);
    const auto in_view = [&](const WorldPoint& p) { return project(view.camera, view.pose, p); };
    return {face, raster_face(in_view(a), in_view(b), in_view(c), projection_rounding(view.camera))};
  }
  /// Faces but those left out that may cover something of the region, none of them edge-on.
  template <class Region>
  std::vector<Contender> contenders(const Region& region, const View& view, const std::vector<FaceId>& left_out) const {
    std::vector<FaceId> near;
    tree.visit([&](const Box& box) { return region.misses(box); },
               [&](FaceId face) {
                 if (!region.misses(corners(face)) && std::ranges::find(left_out, face) == left_out.end())
                   near.push_back(face);
               });
    std::vector<Contender> all;
    for (const FaceId face : near)
      if (Contender one = contender(face, view); one.raster.facing != Facing::edge_on) all.push_back(one);
    return all;
  }
};

PointStage::PointStage(const Mesh& mesh) {
  validate_faces(mesh);
  state_.reset(new State{mesh, FaceTree(mesh)});
}
PointStage::~PointStage() = default;
PointStage::PointStage(PointStage&&) noexcept = default;

std::optional<SurfacePoint> PointStage::nearest(const WorldPoint& place) const {
  const auto found = state_->tree.nearest(place);
  if (!found) return std::nullopt;
  SurfacePoint point{found->at, {found->face}, std::sqrt(found->squared)};
  // The nearest point of a face is computed in some twenty steps, each off by half a unit in the last place of the coordinates.
  const double largest = std::max({std::abs(point.at.x), std::abs(point.at.y), std::abs(point.at.z)});
  const double reach = 16 * std::numeric_limits<double>::epsilon() * largest;
  const auto beside = [&](double low, double high, double at) { return at < low - reach || at > high + reach; };
  std::vector<FaceId> more;
  state_->tree.visit(
      [&](const Box& box) {
        return beside(box.low.x, box.high.x, point.at.x) || beside(box.low.y, box.high.y, point.at.y) ||
               beside(box.low.z, box.high.z, point.at.z);
      },
      [&](FaceId face) {
        const auto [a, b, c] = state_->corners(face);
        if (face != found->face && length(closest_on_face(point.at, a, b, c) - point.at) <= reach) more.push_back(face);
      });
  std::ranges::sort(more);
  point.faces.insert(point.faces.end(), more.begin(), more.end());
  return point;
}

SurfacePoint PointStage::middle(FaceId face) const {
  const auto [a, b, c] = state_->corners(face);
  return {(a + b + c) * (1.0 / 3), {face}, 0};
}

PointSight PointStage::look(const SurfacePoint& point, const View& view, const io::PhotoExclusion* excluded) const {
  PointSight sight;
  sight.face = point.faces.front();
  const ProjectedVertex at = project(view.camera, view.pose, point.at);
  const auto found = [&](Sight what) {
    sight.sight = what;
    return sight;
  };
  if (!(at.z > 0)) return found(Sight::behind);
  const PixelPoint p{at.u / at.z, at.v / at.z};
  sight.frame = p;
  sight.photo = photo_from_pixel(view.camera, p);
  if (!is_in_frame(view.camera, p)) return found(Sight::outside_frame);
  if (!shows(view.camera, nullptr, p)) return found(Sight::outside_photo);
  if (!shows(view.camera, excluded, p)) return found(Sight::masked);
  std::optional<Contender> front;
  bool edge_on = true;
  for (const FaceId face : point.faces) {
    const Contender own = state_->contender(face, view);
    if (own.raster.facing != Facing::edge_on) edge_on = false;
    if (own.raster.facing != Facing::front) continue;
    front = own;
    break;
  }
  if (!front) return found(edge_on ? Sight::edge_on : Sight::back);
  sight.face = front->face;
  const FacePoint own = face_point(front->raster, p.x, p.y);
  const std::vector<Contender> others = state_->contenders(SightLine(view.pose.centre, point.at), view, point.faces);
  const Contender* nearest = nullptr;
  for (const Contender& other : others) {
    const FacePoint there = face_point(other.raster, p.x, p.y);
    if (!covers_exactly(there) || !is_before(other, there, *front, own)) continue;
    if (nearest == nullptr || is_before(other, there, *nearest, face_point(nearest->raster, p.x, p.y)))
      nearest = &other;
  }
  if (nearest == nullptr) return found(Sight::seen);
  sight.hidden_by = nearest->face;
  return found(Sight::hidden);
}

FaceSight PointStage::classify(FaceId face, const View& view, const io::PhotoExclusion* excluded) const {
  const std::array<WorldPoint, 3> corners = state_->corners(face);
  Mesh alone;
  alone.positions.assign(corners.begin(), corners.end());
  alone.faces = {{0, 1, 2}};
  ProjectedMesh projected;
  project_vertices(alone, view.camera, view.pose, projected);
  const PhotoMask unused;
  const PreparedView prepared(alone, view.camera, ViewId{}, unused, projected, {});
  FaceBlock block;
  if (!find_samples(prepared, FaceId{0}, SpanSearch::exact, block.front)) return {};
  const Contender sampled{face, block.front.raster};
  const std::vector<Contender> others = state_->contenders(SightPyramid(view.pose.centre, corners), view, {face});
  FaceSight sight;
  if (block.front.spans.empty()) {
    const SubpixelPositions at = subpixel_positions(prepared, FaceId{0});
    std::uint32_t visible = 0;
    for (std::size_t k = 0; k < kSubpixelSamples; ++k) {
      const PixelPoint p{at.x[k], at.y[k]};
      visible += is_in_frame(view.camera, p) && shows(view.camera, excluded, p) &&
                 std::ranges::none_of(others, [&](const Contender& other) { return hides(other, sampled, p.x, p.y); });
    }
    sight.visible = visible;
    sight.found = block.cover_subpixel(prepared, FaceId{0}, block.front.inside, visible);
  } else {
    HiddenSamples hidden(sampled, block.front.spans);
    for (const Contender& other : others) hidden.hide_behind(other);
    sight.found = block.cover(prepared, [&](std::int32_t x, std::int32_t y) {
      const bool sees = !hidden.at(x, y) && shows(view.camera, excluded, {x + 0.5, y + 0.5});
      sight.visible += sees ? 1 : 0;
      return sees;
    });
  }
  sight.visible_share = sight.found == FaceClass::full   ? 1
                        : block.coverage.entries.empty() ? 0
                                                         : block.coverage.entries.front().visible_share;
  return sight;
}

}  // namespace gpvc::visibility
