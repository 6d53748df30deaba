#include "app/evaluate/agreement_picture.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "io/bilinear.h"
#include "io/images.h"
#include "io/vector.h"
#include "visibility/item_buffer.h"

namespace gpvc::evaluate {
namespace {

constexpr int kWidth = 560, kGap = 8;
constexpr std::uint8_t kGrey = 128, kWhite = 255;

// A photo reduced so that its pixels are about those of the picture.
struct Reduced {
  Image image;
  int factor = 1;

  std::optional<Rgb> at(const View& view, const PixelPoint& p) const {
    const auto photo = photo_from_pixel(view.camera, p);
    if (!photo || photo->x < 0 || photo->y < 0 || photo->x > view.camera.width || photo->y > view.camera.height)
      return std::nullopt;
    return bilinear(image, photo->x / factor, photo->y / factor);
  }
};

Reduced reduced(io::PhotoSource& photos, ViewId view) {
  const auto photo = photos.photo(view);
  const int factor = std::max(1, photo->width / kWidth);
  return {io::reduce_image(*photo, factor), factor};
}

// The view's undistorted frame at the picture's size.
View small_frame(const View& view) {
  View frame = view;
  Camera& c = frame.camera;
  const double scale = static_cast<double>(kWidth) / c.width;
  c.width = kWidth;
  c.height = std::max(1, static_cast<int>(std::lround(scale * c.height)));
  for (double* length : {&c.fx, &c.fy, &c.cx, &c.cy}) *length *= scale;
  c.distortion = {};
  return frame;
}

// Where the line of sight through a pixel meets the face's plane.
std::optional<WorldPoint> point_on(const Mesh& mesh, FaceId face, const View& frame, const PixelPoint& p) {
  const Triangle& t = mesh.faces[index(face)];
  const WorldPoint &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
  const WorldPoint normal = cross(b - a, c - a), ray = ray_of(frame, p);
  const double depth = dot(normal, a - frame.pose.centre) / dot(normal, ray);
  if (!(depth > 0) || !std::isfinite(depth)) return std::nullopt;
  return frame.pose.centre + depth * ray;
}

void put(Image& image, int x, int y, const Rgb& color) {
  for (std::size_t i = 0; i < 3; ++i)
    image.at(x, y)[i] = static_cast<std::uint8_t>(std::clamp(std::lround(color[i]), 0L, 255L));
}

}  // namespace

std::vector<PairOfViews> least_agreeing(const labeling::Candidates& candidates, std::size_t most) {
  std::vector<labeling::ViewAgreement> judged;
  for (const labeling::ViewAgreement& each : candidates.agreement)
    if (each.judged) judged.push_back(each);
  std::ranges::stable_sort(judged, {}, &labeling::ViewAgreement::correlation);
  if (judged.size() > most) judged.resize(most);
  std::vector<PairOfViews> pairs;
  for (const labeling::ViewAgreement& each : judged) {
    const auto view = static_cast<std::uint32_t>(each.view);
    std::map<std::uint32_t, std::size_t> shared;
    for (std::size_t f = 0; f < candidates.table.faces(); ++f) {
      const auto views = candidates.table.views_of(f);
      if (!std::ranges::binary_search(views, view)) continue;
      for (const std::uint32_t other : views)
        if (other != view) ++shared[other];
    }
    const auto best = std::ranges::max_element(shared, {}, [](const auto& entry) { return entry.second; });
    if (best != shared.end()) pairs.push_back({each.view, ViewId{best->first}});
  }
  return pairs;
}

Image agreement_picture(const checks::Input& input, const labeling::CostTable& candidates,
                        std::span<const PairOfViews> pairs, io::PhotoSource& photos) {
  Image picture{2 * kWidth + kGap, 0, 3, {}};
  for (const PairOfViews& pair : pairs) {
    const View &view = input.scene.views[index(pair.view)], &other = input.scene.views[index(pair.other)];
    const View frame = small_frame(view);
    const Reduced own = reduced(photos, pair.view), others = reduced(photos, pair.other);
    const visibility::Ivm ivm = visibility::draw_item_buffer(input.mesh, frame.camera, frame.pose);
    const int top = picture.height;
    picture.height += frame.camera.height + kGap;
    picture.pixels.resize(3 * pixel_index(0, picture.height, picture.width), kWhite);
    const double to_photo = static_cast<double>(view.camera.width) / kWidth;
    tbb::parallel_for(0, frame.camera.height, [&](int y) {
      for (int x = 0; x < kWidth; ++x) {
        const PixelPoint p{x + 0.5, y + 0.5};
        constexpr Rgb kNothing{kGrey, kGrey, kGrey};
        put(picture, x, top + y, own.at(view, {p.x * to_photo, p.y * to_photo}).value_or(kNothing));
        Rgb shown = kNothing;
        const FaceId face = ivm.at(x, y);
        if (face != kNoFace &&
            std::ranges::binary_search(candidates.views_of(index(face)), static_cast<std::uint32_t>(pair.other))) {
          if (const auto point = point_on(input.mesh, face, frame, p))
            if (const auto at = pixel_from_world(other, *point)) shown = others.at(other, *at).value_or(kNothing);
        }
        put(picture, kWidth + kGap + x, top + y, shown);
      }
    });
  }
  return picture;
}

}  // namespace gpvc::evaluate
