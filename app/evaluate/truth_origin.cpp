// A model judged by what the photos show where its texture was taken from.
#include <algorithm>
#include <array>
#include <cmath>

#include "app/evaluate/truth_score.h"
#include "io/bilinear.h"
#include "io/vector.h"

namespace gpvc::evaluate {
namespace {

/// Adds a seen point's area to the sums that make_shares() divides. `unmodelled`: the share of objects that the mesh lacks.
void add_origin(OriginVerdict verdict, double unmodelled, double area, OriginShares& sums) {
  sums.seen_area += area;
  if (verdict == OriginVerdict::filled) return;
  sums.photo += area;
  sums.unmodelled += area * unmodelled;
  if (verdict == OriginVerdict::wrong) sums.wrong += area;
  if (verdict == OriginVerdict::edge) sums.edge += area;
}

/// The same for a point that no photo sees.
void add_hidden_origin(OriginVerdict verdict, double area, OriginShares& sums) {
  sums.hidden_area += area;
  if (verdict == OriginVerdict::filled) return;
  sums.hidden_photo += area;
  if (verdict == OriginVerdict::wrong) sums.ghost += area;
}

/// Turns sums of areas into shares.
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
  sums.unmodelled = photo > 0 ? sums.unmodelled / photo : 0;
  sums.unknown = seen > 0 ? sums.unknown / seen : 0;
}

struct Judged {
  std::vector<std::optional<atlas::PointOrigin>> origins;
  std::vector<OriginVerdict> verdicts;
  std::vector<WrongPoint> places;
  std::vector<float> unmodelled;  // the share of objects that the mesh lacks, in the photo that shows most of them
};

/// The share at a place of a photo's undistorted frame, blended as a texture is; 0 outside the photo.
float unmodelled_share(const Camera& camera, const Image& shares, const PixelPoint& at) {
  const auto q = photo_from_pixel(camera, at);
  if (!q || q->x < 0 || q->y < 0 || q->x > camera.width || q->y > camera.height) return 0;
  return static_cast<float>(bilinear(shares, q->x, q->y)[0] / 255);
}

Judged judge_origins(const TruthInput& input, const ShownPhotos& photos, const std::vector<FacePoint>& points,
                     const OriginOf& origin) {
  Judged result{std::vector<std::optional<atlas::PointOrigin>>(points.size()),
                std::vector<OriginVerdict>(points.size(), OriginVerdict::filled),
                std::vector<WrongPoint>(points.size()), std::vector<float>(points.size(), 0.0F)};
  for_each_point(points.size(), [&](std::size_t i) {
    result.origins[i] = origin(points[i].face, static_cast<double>(points[i].b), static_cast<double>(points[i].c));
  });
  for (const ViewId id : input.used) {
    const IdPicture picture = photos.surfaces(id);
    const View& shown = input.scene.views[index(id)];
    const Camera& camera = shown.camera;
    std::optional<Image> shares;
    if (input.truth.unmodelled) shares = read_unmodelled_picture(input.truth, shown.name, camera.width, camera.height);
    for_each_point(points.size(), [&](std::size_t i) {
      const std::optional<atlas::PointOrigin>& from = result.origins[i];
      if (!from) return;
      const std::uint32_t surface = input.truth.face_surface[points[i].face];
      for (const auto& [view, at] : {std::pair(from->first, from->first_at), {from->second, from->second_at}}) {
        if (view != id) continue;
        if (shares) result.unmodelled[i] = std::max(result.unmodelled[i], unmodelled_share(camera, *shares, at));
        WrongPoint place{points[i].face, id, {}, synth::kNoSurface};
        const OriginVerdict verdict = origin_verdict(camera, *picture, at, surface, place);
        if (verdict <= result.verdicts[i]) continue;
        result.verdicts[i] = verdict;
        result.places[i] = place;
      }
    });
  }
  return result;
}

}  // namespace

OriginVerdict origin_verdict(const Camera& camera, std::span<const std::uint32_t> surfaces, const PixelPoint& at,
                             std::uint32_t own, WrongPoint& place) {
  const auto q = photo_from_pixel(camera, at);
  // Half a pixel beyond the border still reads the border's pixels, as the atlas does.
  if (!q || q->x < -0.5 || q->y < -0.5 || q->x > camera.width + 0.5 || q->y > camera.height + 0.5)
    return OriginVerdict::wrong;
  const auto shown = [&](int x, int y) {
    return surfaces[pixel_index(std::clamp(x, 0, camera.width - 1), std::clamp(y, 0, camera.height - 1), camera.width)];
  };
  place.at = *q;
  place.surface = shown(static_cast<int>(std::floor(q->x)), static_cast<int>(std::floor(q->y)));
  const int x = static_cast<int>(std::floor(q->x - 0.5)), y = static_cast<int>(std::floor(q->y - 0.5));
  const std::array<std::uint32_t, 4> around{shown(x, y), shown(x + 1, y), shown(x, y + 1), shown(x + 1, y + 1)};
  const auto mine = std::count(around.begin(), around.end(), own);
  if (mine == 4) return OriginVerdict::right;
  return mine > 0 || place.surface == synth::kMixedSurfaces ? OriginVerdict::edge : OriginVerdict::wrong;
}

OriginScore TruthScorer::score(const OriginOf& origin) const {
  OriginScore score;
  score.right_area.assign(input_.mesh.faces.size(), 0.0F);
  score.faithful_area.assign(input_.mesh.faces.size(), 0.0F);
  const auto shares_of = [&](std::uint32_t face) {
    const visibility::FaceClass best = points_.best[face];
    OriginShares* kind = best == visibility::FaceClass::full      ? &score.full
                         : best == visibility::FaceClass::partial ? &score.partial
                                                                  : &score.none;
    return std::array{&score.all, kind};
  };
  const Judged seen = judge_origins(input_, photos_, points_.seen, origin);
  for (std::size_t i = 0; i < points_.seen.size(); ++i) {
    const auto& [face, b, c, area] = points_.seen[i];
    for (OriginShares* shares : shares_of(face)) {
      if (!seen.origins[i])
        shares->unknown += area;
      else
        add_origin(seen.verdicts[i], static_cast<double>(seen.unmodelled[i]), area, *shares);
    }
    if (!seen.origins[i]) continue;
    if (seen.verdicts[i] == OriginVerdict::wrong) score.wrong.push_back(seen.places[i]);
    if (seen.verdicts[i] != OriginVerdict::right && seen.verdicts[i] != OriginVerdict::edge) continue;
    score.right_area[face] += static_cast<float>(area);
    score.faithful_area[face] += static_cast<float>(area);
  }
  const Judged hidden = judge_origins(input_, photos_, points_.hidden, origin);
  for (std::size_t i = 0; i < points_.hidden.size(); ++i) {
    if (!hidden.origins[i]) continue;
    const auto& [face, b, c, area] = points_.hidden[i];
    for (OriginShares* shares : shares_of(face)) add_hidden_origin(hidden.verdicts[i], area, *shares);
    if (hidden.verdicts[i] != OriginVerdict::wrong) score.faithful_area[face] += static_cast<float>(area);
  }
  for (OriginShares* shares : {&score.all, &score.full, &score.partial, &score.none}) make_shares(*shares);
  return score;
}

OriginOf origins_of_labels(const Mesh& mesh, const Scene& scene, std::vector<std::int32_t> labels,
                           std::vector<std::uint8_t> tags) {
  return [&mesh, &scene, labels = std::move(labels), tags = std::move(tags)](
             std::uint32_t face, double b, double c) -> std::optional<atlas::PointOrigin> {
    if (!labeling::has_candidates(labeling::FaceTag{tags[face]})) return atlas::PointOrigin{};
    if (tags[face] != static_cast<std::uint8_t>(labeling::FaceTag::seen) || labels[face] < 0 ||
        static_cast<std::size_t>(labels[face]) >= scene.views.size())
      return std::nullopt;
    const View& view = scene.views[static_cast<std::size_t>(labels[face])];
    const Triangle& corners = mesh.faces[face];
    const WorldPoint& a = mesh.positions[corners[0]];
    const CameraPoint p =
        camera_from_world(view.pose, a + b * (mesh.positions[corners[1]] - a) + c * (mesh.positions[corners[2]] - a));
    if (!(p.z > 0)) return std::nullopt;
    atlas::PointOrigin origin;
    origin.first = ViewId{static_cast<std::uint32_t>(labels[face])};
    origin.first_at = pixel_from_camera(view.camera, p);
    return origin;
  };
}

}  // namespace gpvc::evaluate
