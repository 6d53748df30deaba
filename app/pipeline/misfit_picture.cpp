#include "app/pipeline/misfit_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "io/vector.h"
#include "visibility/item_buffer.h"

namespace gpvc::pipeline {
namespace {

using Rgb8 = std::array<std::uint8_t, 3>;

/// Grey, and half of it white.
Image pale(const Image& picture) {
  Image result = picture;
  for (std::size_t i = 0; i < result.pixels.size(); i += 3) {
    const int sum = result.pixels[i] + result.pixels[i + 1] + result.pixels[i + 2];
    std::fill_n(&result.pixels[i], 3, static_cast<std::uint8_t>(128 + sum / 6));
  }
  return result;
}

Rgb8 color_of(float misfit_px) {
  constexpr float kRed = 2;  // px
  const float level = std::clamp(misfit_px / kRed, 0.0f, 1.0f);
  const auto channel = [](float share) { return static_cast<std::uint8_t>(220 * std::clamp(share, 0.0f, 1.0f)); };
  return {channel(2 * level), channel(2 - 2 * level), 0};
}

WorldPoint middle_of(const Mesh& mesh, FaceId face) {
  const Triangle& t = mesh.faces[index(face)];
  return 1.0 / 3 * (mesh.positions[t[0]] + mesh.positions[t[1]] + mesh.positions[t[2]]);
}

/// Where the middle of a face is in the picture; nullopt if another part of the mesh hides it. The pixel may also show a face beside
/// this one, as faces are smaller than pixels: that is no nearer than by a fiftieth, and what hides a face nearly always is.
std::optional<PixelPoint> place_of(const Mesh& mesh, const visibility::Ivm& ivm, const View& view, FaceId face) {
  constexpr double kHardlyNearer = 0.98;
  const WorldPoint middle = middle_of(mesh, face);
  const auto at = pixel_from_world(view, middle);
  if (!at || !(at->x >= 0 && at->y >= 0 && at->x < ivm.width && at->y < ivm.height)) return std::nullopt;
  const FaceId seen = ivm.at(static_cast<int>(at->x), static_cast<int>(at->y));
  if (seen == kNoFace) return at;
  const double depth = camera_from_world(view.pose, middle).z;
  return camera_from_world(view.pose, middle_of(mesh, seen)).z < kHardlyNearer * depth ? std::nullopt : at;
}

void draw_dot(Image& picture, const PixelPoint& at, const Rgb8& color) {
  constexpr double kRadius = 3;
  const int x0 = static_cast<int>(at.x - kRadius), y0 = static_cast<int>(at.y - kRadius);
  for (int y = std::max(y0, 0); y < std::min(picture.height, y0 + 8); ++y)
    for (int x = std::max(x0, 0); x < std::min(picture.width, x0 + 8); ++x)
      if (std::hypot(x + 0.5 - at.x, y + 0.5 - at.y) <= kRadius) std::ranges::copy(color, picture.at(x, y));
}

}  // namespace

Image misfit_picture(const Mesh& mesh, const Image& preview, const Viewpoint& from,
                     std::span<const atlas::CutMisfit::Place> places) {
  Image picture = pale(preview);
  const visibility::Ivm ivm = visibility::draw_item_buffer(mesh, from.camera, from.pose);
  View view;
  view.camera = from.camera;
  view.pose = from.pose;
  // The worst ones last, over the others.
  std::vector<atlas::CutMisfit::Place> ordered(places.begin(), places.end());
  std::ranges::stable_sort(ordered, {}, &atlas::CutMisfit::Place::px);
  for (const atlas::CutMisfit::Place& place : ordered)
    if (const auto at = place_of(mesh, ivm, view, place.face)) draw_dot(picture, *at, color_of(place.px));
  return picture;
}

}  // namespace gpvc::pipeline
