#include "app/evaluate/truth_origin.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace gpvc::evaluate {

OriginVerdict origin_verdict(const Camera& camera, std::span<const std::uint32_t> surfaces, const PixelPoint& at,
                             std::uint32_t own, WrongPoint& place) {
  const auto q = photo_from_pixel(camera, at);
  // Half a pixel beyond the border still reads the border's pixels, as the atlas does.
  if (!q || q->x < -0.5 || q->y < -0.5 || q->x > camera.width + 0.5 || q->y > camera.height + 0.5)
    return OriginVerdict::wrong;
  const auto shown = [&](int x, int y) {
    const auto column = static_cast<std::size_t>(std::clamp(x, 0, camera.width - 1)),
               row = static_cast<std::size_t>(std::clamp(y, 0, camera.height - 1));
    return surfaces[row * static_cast<std::size_t>(camera.width) + column];
  };
  place.at = *q;
  place.surface = shown(static_cast<int>(std::floor(q->x)), static_cast<int>(std::floor(q->y)));
  const int x = static_cast<int>(std::floor(q->x - 0.5)), y = static_cast<int>(std::floor(q->y - 0.5));
  const std::array<std::uint32_t, 4> around{shown(x, y), shown(x + 1, y), shown(x, y + 1), shown(x + 1, y + 1)};
  const auto mine = std::count(around.begin(), around.end(), own);
  if (mine == 4) return OriginVerdict::right;
  return mine > 0 || place.surface == synth::kMixedSurfaces ? OriginVerdict::edge : OriginVerdict::wrong;
}

void add_origin(OriginVerdict verdict, double area, OriginShares& sums) {
  sums.seen_area += area;
  if (verdict == OriginVerdict::filled) return;
  sums.photo += area;
  if (verdict == OriginVerdict::wrong) sums.wrong += area;
  if (verdict == OriginVerdict::edge) sums.edge += area;
}

void add_hidden_origin(OriginVerdict verdict, double area, OriginShares& sums) {
  sums.hidden_area += area;
  if (verdict == OriginVerdict::filled) return;
  sums.hidden_photo += area;
  if (verdict == OriginVerdict::wrong) sums.ghost += area;
}

void make_shares(OriginShares& sums) {
  const double known = sums.seen_area, seen = known + sums.unknown, photo = sums.photo, wrong = sums.wrong;
  const double all = known + sums.hidden_area, from_photos = photo + sums.hidden_photo;
  sums.foreign = from_photos > 0 ? (wrong + sums.ghost) / from_photos : 0;
  sums.faithful = all > 0 ? (photo - wrong + sums.hidden_area - sums.ghost) / all : 0;
  if (sums.hidden_area > 0) {
    sums.hidden_photo /= sums.hidden_area;
    sums.ghost /= sums.hidden_area;
  }
  sums.right = known > 0 ? (photo - wrong) / known : 0;
  sums.photo = known > 0 ? photo / known : 0;
  sums.wrong = photo > 0 ? wrong / photo : 0;
  sums.edge = photo > 0 ? sums.edge / photo : 0;
  sums.unknown = seen > 0 ? sums.unknown / seen : 0;
}

OriginOf origins_of_labels(const Mesh& mesh, const Scene& scene, std::vector<std::int32_t> labels,
                           std::vector<std::uint8_t> tags) {
  return [&mesh, &scene, labels = std::move(labels), tags = std::move(tags)](
             std::uint32_t face, double b, double c) -> std::optional<atlas::PointOrigin> {
    if (tags[face] == static_cast<std::uint8_t>(labeling::FaceTag::unseen)) return atlas::PointOrigin{};
    if (tags[face] != static_cast<std::uint8_t>(labeling::FaceTag::seen) || labels[face] < 0 ||
        static_cast<std::size_t>(labels[face]) >= scene.views.size())
      return std::nullopt;
    const View& view = scene.views[static_cast<std::size_t>(labels[face])];
    const std::array<double, 3> weights{1 - b - c, b, c};
    atlas::PointOrigin origin;
    origin.first = ViewId{static_cast<std::uint32_t>(labels[face])};
    for (std::size_t i = 0; i < 3; ++i) {
      const CameraPoint corner = camera_from_world(view.pose, mesh.positions[mesh.faces[face][i]]);
      if (!(corner.z > 0)) return std::nullopt;
      const PixelPoint p = pixel_from_camera(view.camera, corner);
      origin.first_at.x += weights[i] * p.x;
      origin.first_at.y += weights[i] * p.y;
    }
    return origin;
  };
}

std::string origin_table(const OriginScore& score) {
  std::string table = fmt::format("\n{:<24}{:^44}{:^30}{:^21}\n{:<24}{:>10}{:>10}{:>12}{:>12}{:>15}{:>15}{:>12}{:>9}\n",
                                  "by the photos' pixels", "of the area seen", "of the area hidden", "of both", "",
                                  "a photo's", "right", "wrong", "edge", "a photo's", "ghost", "foreign", "faithful");
  const auto line = [&](const char* name, const OriginShares& s) {
    table +=
        fmt::format("{:<24}{:>8.3f} %{:>8.3f} %{:>10.4f} %{:>10.3f} %{:>13.3f} %{:>13.4f} %{:>10.4f} %{:>7.3f} %\n",
                    name, 100 * s.photo, 100 * s.right, 100 * s.wrong, 100 * s.edge, 100 * s.hidden_photo,
                    100 * s.ghost, 100 * s.foreign, 100 * s.faithful);
  };
  line("all", score.all);
  line("seen whole by a view", score.full);
  line("seen only in parts", score.partial);
  line("seen by none", score.none);
  if (score.all.unknown > 0)
    table += fmt::format("of {:.2f} % of the area seen it is not known which photos it comes from\n",
                         100 * score.all.unknown);
  return table;
}

Json shares_json(const TruthShares& s) {
  return {{"area", s.area},
          {"seen_area", s.seen_area},
          {"textured", s.textured},
          {"wrong", s.wrong},
          {"strange", s.strange},
          {"untold", s.untold},
          {"right", s.textured * (1 - s.wrong)}};
}

Json shares_json(const OriginShares& s) {
  return {{"seen_area", s.seen_area},
          {"photo", s.photo},
          {"filled", 1 - s.photo},
          {"right", s.right},
          {"wrong", s.wrong},
          {"edge", s.edge},
          {"unknown", s.unknown},
          {"hidden_area", s.hidden_area},
          {"hidden_photo", s.hidden_photo},
          {"ghost", s.ghost},
          {"foreign", s.foreign},
          {"faithful", s.faithful}};
}

}  // namespace gpvc::evaluate
