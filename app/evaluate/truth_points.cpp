#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "app/evaluate/truth_score.h"
#include "app/results/observer.h"
#include "io/box.h"
#include "io/vector.h"

namespace gpvc::evaluate {
namespace {

constexpr std::size_t kAimedPoints = 1200000;
constexpr int kMostOfAFace = 64;
constexpr int kOwnReach_px = 2;

/// In proportion to area, at least one a face, spread by Roberts' two-dimensional golden ratio sequence.
std::vector<FacePoint> sample_faces(const Mesh& mesh) {
  double total = 0;
  std::vector<double> face_area(mesh.faces.size());
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    face_area[f] = length(twice_area_normal(mesh, f)) / 2;
    total += face_area[f];
  }
  const double cell = total / static_cast<double>(kAimedPoints);
  std::vector<FacePoint> points;
  for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) {
    if (!(face_area[f] > 0)) continue;
    const int count = std::clamp(static_cast<int>(std::lround(face_area[f] / cell)), 1, kMostOfAFace);
    const double start_u = synth::synth_chance(f, 1, 71), start_v = synth::synth_chance(f, 2, 71);
    for (int n = 0; n < count; ++n) {
      double u = start_u + n * 0.75487766624669276, v = start_v + n * 0.56984029099805327;
      u -= std::floor(u);
      v -= std::floor(v);
      if (u + v > 1) {
        u = 1 - u;
        v = 1 - v;
      }
      points.push_back({f, static_cast<float>(u), static_cast<float>(v), face_area[f] / count});
    }
  }
  return points;
}

/// The true mesh relative to an origin near its middle, for rays in floats.
synth::SynthScene traced_scene(const Mesh& mesh, WorldPoint& origin) {
  const auto [low, high] = box_of(mesh);
  // Whole metres, and none for coordinates of less than 100 m: subtracting them rounds nothing.
  const auto middle = [](double a, double b) {
    const double m = (a + b) / 2;
    return std::abs(m) < 100 ? 0.0 : std::floor(m);
  };
  origin = {middle(low.x, high.x), middle(low.y, high.y), middle(low.z, high.z)};
  synth::SynthScene scene;
  scene.mesh.faces = mesh.faces;
  scene.mesh.positions.reserve(mesh.positions.size());
  for (const WorldPoint& p : mesh.positions) scene.mesh.positions.push_back(p - origin);
  return scene;
}

/// Where used photos show each point.
struct Sightings {
  std::size_t words = 0;             ///< of 64 views, per point
  std::vector<std::uint64_t> clear;  ///< per point, a bit for each used view that shows it clear of other surfaces
  std::vector<OwnColors> own;
  std::vector<std::uint8_t> hits;  ///< per point: 1 if some used photo shows it, or its surface right beside it

  bool is_clear(std::size_t point, std::size_t view) const {
    return (clear[point * words + view / 64] >> (view % 64)) & 1u;
  }
  bool clear_anywhere(std::size_t point) const {
    const auto first = clear.begin() + static_cast<std::ptrdiff_t>(point * words);
    return std::any_of(first, first + static_cast<std::ptrdiff_t>(words), [](std::uint64_t w) { return w != 0; });
  }
  void move(std::size_t from, std::size_t to) {
    own[to] = own[from];
    for (std::size_t w = 0; w < words; ++w) clear[to * words + w] = clear[from * words + w];
  }
};

Sightings find_sightings(const TruthInput& input, const ShownPhotos& photos, const std::vector<FacePoint>& points,
                         const Progress& progress) {
  const Truth& truth = input.truth;
  WorldPoint origin;
  const synth::SynthScene traced = traced_scene(truth.mesh, origin);
  const synth::SynthRenderer renderer(traced);
  Sightings found;
  found.words = (input.used.size() + 63) / 64;
  found.clear.assign(points.size() * found.words, 0);
  found.own.resize(points.size());
  found.hits.assign(points.size(), 0);
  for (std::size_t n = 0; n < input.used.size(); ++n) {
    progress(n, input.used.size());
    const ShownPhoto photo = photos.photo(input.used[n]);
    Pose pose = photo.view.pose;
    pose.centre = pose.centre - origin;
    for_each_point(points.size(), [&](std::size_t i) {
      const std::uint32_t face = points[i].face, surface = truth.face_surface[face];
      const WorldPoint p = position_of(truth.mesh, points[i]);
      if (dot(twice_area_normal(truth.mesh, face), photo.view.pose.centre - p) <= 0) return;
      const auto at = photo.project(p);
      if (!at) return;
      const ShownPhoto::Window around = photo.window(*at, surface);
      if (around.any) found.hits[i] = 1;
      if ((!around.alone && found.hits[i] != 0) || !renderer.sees(pose, p - origin, face)) return;
      found.hits[i] = 1;
      if (!around.alone) return;
      found.clear[i * found.words + n / 64] |= std::uint64_t{1} << (n % 64);
      photo.around(*at, kOwnReach_px, [&](int x, int y) {
        if (photo.surface(x, y) == surface) found.own[i].add(photo.color(x, y));
      });
    });
  }
  return found;
}

/// Keeps the points, and what is known of them, that some photo shows clear of other surfaces; returns those that none
/// shows. The rest lie within pixels of an outline in every photo.
std::vector<FacePoint> split_seen_and_hidden_samples(std::vector<FacePoint>& points, Sightings& sightings) {
  std::vector<FacePoint> hidden;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (sightings.clear_anywhere(i)) {
      sightings.move(i, kept);
      points[kept++] = points[i];
    } else if (sightings.hits[i] == 0) {
      hidden.push_back(points[i]);
    }
  }
  points.resize(kept);
  sightings.own.resize(kept);
  sightings.clear.resize(kept * sightings.words);
  sightings.hits = {};
  return hidden;
}

/// Levelling may have brought a texel to any of the photos' gains.
std::vector<float> possible_gains(const Truth& truth) {
  if (!(truth.most_gain > 1)) return {1.0F};
  constexpr int kSteps = 8;
  std::vector<float> gains;
  for (int n = 0; n <= kSteps; ++n)
    gains.push_back(static_cast<float>(1 / (truth.least_gain + (truth.most_gain - truth.least_gain) * n / kSteps)));
  return gains;
}

/// Per seen point: of the used photos that show another surface in its place, the share whose colour there is one of the
/// point's own.
std::vector<float> estimate_undetectable(const TruthInput& input, const ShownPhotos& photos, const TruthPoints& points,
                                         const Sightings& sightings, const Progress& progress) {
  const std::size_t count = points.seen.size();
  std::vector<std::uint16_t> hiding(count, 0), alike(count, 0);
  for (std::size_t n = 0; n < input.used.size(); ++n) {
    progress(n, input.used.size());
    const ShownPhoto photo = photos.photo(input.used[n]);
    for_each_point(count, [&](std::size_t i) {
      if (sightings.is_clear(i, n)) return;
      const auto at = photo.project(position_of(input.truth.mesh, points.seen[i]));
      if (!at) return;
      const int x = static_cast<int>(at->x), y = static_cast<int>(at->y);
      const std::uint32_t shown = photo.surface(x, y);
      if (shown == synth::kMixedSurfaces || shown == input.truth.face_surface[points.seen[i].face]) return;
      ++hiding[i];
      if (points.own_distance(i, photo.color(x, y)) <= kColorTolerance) ++alike[i];
    });
  }
  std::vector<float> shares(count);
  for (std::size_t i = 0; i < count; ++i)
    shares[i] = hiding[i] == 0 ? 0.0F : static_cast<float>(alike[i]) / static_cast<float>(hiding[i]);
  return shares;
}

}  // namespace

void OwnColors::add(const Pixel& p) {
  for (std::size_t i = 0; i < 3; ++i) {
    least[i] = std::min(least[i], p[i]);
    most[i] = std::max(most[i], p[i]);
    sum[i] += p[i];
  }
  ++count;
}

double OwnColors::distance(const Pixel& p) const {
  float far = 0;
  for (std::size_t i = 0; i < 3; ++i) far = std::max({far, least[i] - p[i], p[i] - most[i]});
  return static_cast<double>(far);
}

double TruthPoints::own_distance(std::size_t point, const Pixel& texel) const {
  double smallest = std::numeric_limits<double>::infinity();
  for (const float g : gains)
    smallest = std::min(smallest, own[point].distance({texel[0] * g, texel[1] * g, texel[2] * g}));
  return smallest;
}

WorldPoint twice_area_normal(const Mesh& mesh, std::size_t face) {
  const Triangle& t = mesh.faces[face];
  return cross(mesh.positions[t[1]] - mesh.positions[t[0]], mesh.positions[t[2]] - mesh.positions[t[0]]);
}

WorldPoint position_of(const Mesh& mesh, const FacePoint& point) {
  const Triangle& t = mesh.faces[point.face];
  const WorldPoint &p = mesh.positions[t[0]], u = mesh.positions[t[1]] - p, v = mesh.positions[t[2]] - p;
  const double b = point.b, c = point.c;
  return {p.x + b * u.x + c * v.x, p.y + b * u.y + c * v.y, p.z + b * u.z + c * v.z};
}

TruthScorer::TruthScorer(const TruthInput& input, const Progress& progress)
    : input_(input), photos_(input.truth, input.scene, input.photos) {
  if (input.mesh.faces.size() != input.truth.mesh.faces.size())
    throw InputError(input.truth.dir, "",
                     fmt::format("the truth is about {} faces, but the mesh has {}", input.truth.mesh.faces.size(),
                                 input.mesh.faces.size()));
  const std::size_t views = input.used.size();
  points_.best = best_classes(input.mesh, input.scene, input.used, results::part_of(progress, 0, 3 * views));
  points_.gains = possible_gains(input.truth);
  points_.seen = sample_faces(input.mesh);
  Sightings sightings = find_sightings(input, photos_, points_.seen, results::part_of(progress, views, 3 * views));
  points_.hidden = split_seen_and_hidden_samples(points_.seen, sightings);
  points_.own = std::move(sightings.own);
  points_.undetectable =
      estimate_undetectable(input, photos_, points_, sightings, results::part_of(progress, 2 * views, 3 * views));
}

}  // namespace gpvc::evaluate
