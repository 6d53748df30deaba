#include "atlas/baking/face_share.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "atlas/leveling/color_correction.h"

namespace gpvc::atlas {

namespace {

/// Interpolation may move a position in the photo by so much: an eighth of a coarse pixel, and half of what poses of sharp
/// photos are known to (kMostBend).
constexpr double kMostShiftPx = 0.25;

/// Sums stay in the range of ColorSum in whatever order views come: what they add has factors of kBlendedPart at most in
/// all, what the main view takes away has one of as much, and no colour is brighter than white, however it is exposed. Every view
/// is rounded by up to half a unit, for which there is room as long as no place is seen by more than 60 000.
constexpr double kMostSum = double{kBlendedPart} * 255 * double{kSumUnit};
static_assert(kMostSum + 60000 / 2 <= std::numeric_limits<ColorSum::value_type>::max());

/// Over a triangle whose longest edge is a pixel. Over a square of edge s bilinear interpolation errs by M s^2 / 8 at most if
/// M is the second derivative, over a triangle with edges of s, which lies in a circle of radius s / sqrt 3, linear
/// interpolation by M s^2 / 6.
double lens_error(const Camera& camera, int step) {
  return camera.distortion.is_identity() ? 0 : 4.0 / 3 * kLatticeErrorPx / (step * step);
}

}  // namespace

FaceShare::Weights FaceShare::Weights::clamped() const {
  const double at_b = std::max(b, 0.0), at_c = std::max(c, 0.0), sum = std::max(1.0, at_b + at_c);
  return {at_b / sum, at_c / sum};
}

FaceShare::FaceShare(const AtlasBuild& build, const Chart& chart, ViewId id, const CoarseRows& coarse, int step,
                     std::size_t faces)
    : build_(build),
      view_(build.input.scene.views[index(id)]),
      main_(build.input.scene.views[index(chart.view)]),
      given_(chart.given),
      number_(static_cast<std::uint32_t>(index(id))),
      main_number_(static_cast<std::uint32_t>(index(chart.view))),
      coarse_(coarse),
      lens_error_(lens_error(view_.camera, step)) {
  constexpr std::size_t kMost = 4096;  // which a core keeps close
  seen_.resize(std::bit_ceil(std::min(faces, kMost)));
}

const FaceShare::Corner& FaceShare::corner(std::uint32_t vertex) {
  Corner& corner = seen_[vertex & (seen_.size() - 1)];
  if (corner.vertex == vertex) return corner;
  const BlendWeights::Share share = build_.blending.share(vertex, number_, main_number_);
  corner = share.at ? place(vertex, share) : Corner{};
  corner.vertex = vertex;
  return corner;
}

FaceShare::Corner FaceShare::place(std::uint32_t vertex, const BlendWeights::Share& share) const {
  const WorldPoint& p = build_.input.mesh.positions[vertex];
  const Camera& camera = view_.camera;
  const CameraPoint c = camera_from_world(view_.pose, p);
  const double nearness = given_ ? 1 : 1 / camera_from_world(main_.pose, p).z;
  Corner corner;
  corner.is_placed = true;
  corner.frame = nearness * WorldPoint{camera.fx * c.x + camera.cx * c.z, camera.fy * c.y + camera.cy * c.z, c.z};
  if (share.at != nullptr) {
    corner.photo = {double{share.at->x}, double{share.at->y}};
    corner.is_shown = true;
  } else if (c.z > 0) {
    const auto q = photo_from_pixel(camera, pixel_from_camera(camera, c));
    corner.photo = q.value_or(PhotoPoint{});
    corner.is_shown = q.has_value();
  }
  if (c.z > 0) corner.at.gain = build_.correction.gain(ViewId{number_}, pixel_from_camera(camera, c));
  corner.at.factor = share.factor * corner.at.gain;
  corner.has_share = share.factor != 0;
  return corner;
}

/// How far, in pixels, a position in the photo is off at most if it is interpolated between the corners, which the photo
/// shows. Perspective moves it as in bend() with w for the depth: on an edge of length L from w to W by L |sqrt w - sqrt W| /
/// (sqrt w + sqrt W) <= L |w - W| / (4 min(w, W)), inside by 4/3 of that.
double FaceShare::interpolation_error() const {
  double longest2 = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const WorldPoint &p = corners_[i].frame, &q = corners_[(i + 1) % 3].frame;
    const double dx = p.x / p.z - q.x / q.z, dy = p.y / p.z - q.y / q.z;
    longest2 = std::max(longest2, dx * dx + dy * dy);
  }
  const auto [least, most] = std::minmax({corners_[0].frame.z, corners_[1].frame.z, corners_[2].frame.z});
  return longest2 * lens_error_ + std::sqrt(longest2) * (most - least) / (3 * least);
}

/// As many as a cell's edge has pixels of the coarse photo, in the mean over the face; 16 at most. \param texels of the face
int FaceShare::samples_along_cell(double texels) const {
  constexpr double kMost = 16;
  TexelTriangle frame;
  for (std::size_t i = 0; i < 3; ++i) {
    const WorldPoint& p = corners_[i].frame;
    if (!(p.z > 0)) return 1;
    frame[i] = {p.x / p.z, p.y / p.z};
  }
  const double edge = std::sqrt(std::abs(doubled_area(frame)) / 2 / texels) * kBlendStep / kCoarsePixel;
  return static_cast<int>(std::ceil(std::clamp(edge - 0.01, 1.0, kMost)));
}

bool FaceShare::prepare(std::uint32_t face) {
  const Triangle& vertices = build_.input.mesh.faces[face];
  if (std::ranges::none_of(vertices, [&](std::uint32_t vertex) { return corner(vertex).has_share; })) return false;
  const TexelTriangle& t = build_.set.corners[face];
  const double area = doubled_area(t);
  if (area == 0) return false;
  for (std::size_t i = 0; i < 3; ++i) {
    corners_[i] = corner(vertices[i]);
    // The view has no share at this corner, but one between it and the others.
    if (!corners_[i].is_placed) corners_[i] = place(vertices[i], {});
  }
  per_x_ = {(t[2].y - t[0].y) / area, (t[0].y - t[1].y) / area};
  per_y_ = {(t[0].x - t[2].x) / area, (t[1].x - t[0].x) / area};
  begin_ = {-(t[0].x * per_x_.b + t[0].y * per_y_.b), -(t[0].x * per_x_.c + t[0].y * per_y_.c)};
  stretch_ = 1;
  is_affine_ = false;
  samples_ = given_ ? samples_along_cell(std::abs(area) / 2) : 1;
  if (shows_pole(view_.camera.distortion.model) || !std::ranges::all_of(corners_, &Corner::is_shown)) return true;
  // Of a triangle whose edges are n times shorter both errors are n^2 times smaller. In one that is similar to the face fits a
  // row whose length is a n-th of that of the face's longest.
  const double pieces = std::ceil(std::sqrt(interpolation_error() / kMostShiftPx));
  is_affine_ = pieces <= 1;
  const double longest_row = std::abs(area) / (std::max({t[0].y, t[1].y, t[2].y}) - std::min({t[0].y, t[1].y, t[2].y}));
  stretch_ = static_cast<std::size_t>(std::clamp(longest_row / (kBlendStep * pieces), 1.0, 1e6));
  return true;
}

std::optional<PhotoPoint> FaceShare::position(const Weights& at) const {
  const auto& [first, second, third] = corners_;
  if (is_affine_)
    return PhotoPoint{first.photo.x + at.b * (second.photo.x - first.photo.x) + at.c * (third.photo.x - first.photo.x),
                      first.photo.y + at.b * (second.photo.y - first.photo.y) + at.c * (third.photo.y - first.photo.y)};
  const WorldPoint p = first.frame + at.b * (second.frame - first.frame) + at.c * (third.frame - first.frame);
  if (!(p.z > 0)) return std::nullopt;
  return photo_from_pixel(view_.camera, {p.x / p.z, p.y / p.z});
}

CellFactor FaceShare::factor(const Weights& at) const {
  const auto between = [&](Color CellFactor::*part) {
    const Color &first = corners_[0].at.*part, &second = corners_[1].at.*part, &third = corners_[2].at.*part;
    return first + static_cast<float>(at.b) * (second - first) + static_cast<float>(at.c) * (third - first);
  };
  const float share = 1 / static_cast<float>(samples_ * samples_);
  return {share * between(&CellFactor::factor), between(&CellFactor::gain)};
}

void FaceShare::add_row(double x, double y, std::span<ColorSum> sums) const {
  const auto shift = [&](int i) { return ((i + 0.5) / samples_ - 0.5) * kBlendStep; };
  for (int j = 0; j < samples_; ++j)
    for (int i = 0; i < samples_; ++i) add_samples(x + shift(i), y + shift(j), sums);
}

void FaceShare::add_samples(double x, double y, std::span<ColorSum> sums) const {
  const Weights first{begin_.b + x * per_x_.b + y * per_y_.b, begin_.c + x * per_x_.c + y * per_y_.c};
  const auto weights = [&](std::size_t i) {
    const double shift = static_cast<double>(i) * kBlendStep;
    return Weights{first.b + shift * per_x_.b, first.c + shift * per_x_.c};
  };
  std::size_t i = 0, end = sums.size();
  const auto add_beyond = [&](std::size_t cell) {
    const Weights at = weights(cell).clamped();
    if (const auto q = position(at)) coarse_.add_row(*q, {}, factor(at), {{}, {}}, sums.subspan(cell, 1));
  };
  for (; i < end && !weights(i).is_inside(); ++i) add_beyond(i);
  for (; i < end && !weights(end - 1).is_inside(); --end) add_beyond(end - 1);
  if (i == end) return;
  const CellFactor next_cell = factor({kBlendStep * per_x_.b, kBlendStep * per_x_.c}), here = factor({});
  const CellFactor change{next_cell.factor - here.factor, next_cell.gain - here.gain};
  std::optional<PhotoPoint> q = position(weights(i));
  while (i < end) {
    const std::size_t next = is_affine_ ? end : std::min(end, i + stretch_), last = std::min(next, end - 1);
    const std::optional<PhotoPoint> to = last > i ? position(weights(last)) : q;
    if (q && to) {
      const double share = 1 / std::max(1.0, static_cast<double>(last - i));
      const PhotoPoint step{(to->x - q->x) * share, (to->y - q->y) * share};
      coarse_.add_row(*q, step, factor(weights(i)), change, sums.subspan(i, next - i));
    }
    i = next;
    q = to;
  }
}

}  // namespace gpvc::atlas
