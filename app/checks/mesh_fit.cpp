#include "app/checks/mesh_fit.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <set>

#include "app/checks/fit_verdict.h"
#include "app/results/observer.h"
#include "io/vector.h"

namespace gpvc::checks {
namespace {

constexpr int kSide = 9, kPatch = kSide * kSide;         ///< of a patch, in pixels
constexpr int kReach = 24, kPositions = 2 * kReach + 1;  ///< along the line of sight, in pixels
constexpr int kOnMesh = 1;                               ///< pixels from the mesh that count as on it

using Values = std::array<float, kPatch>;

/// The position of a patch in a photo and its steps to the right and down.
struct Spot {
  PhotoPoint middle, right, down;
};

float luma(const Image& image, double x, double y) {
  const double u = std::clamp(x - 0.5, 0.0, image.width - 1.001), v = std::clamp(y - 0.5, 0.0, image.height - 1.001);
  const int x0 = static_cast<int>(u), y0 = static_cast<int>(v);
  const auto fx = static_cast<float>(u - x0), fy = static_cast<float>(v - y0);
  const std::uint8_t *above = image.at(x0, y0), *below = above + image.width;
  const auto row = [fx](const std::uint8_t* p) {
    return static_cast<float>(p[0]) * (1 - fx) + static_cast<float>(p[1]) * fx;
  };
  return row(above) * (1 - fy) + row(below) * fy;
}

/// Fills `values` with the patch's luma, scaled to mean 0 and norm 1, and returns its standard deviation.
float take(const Image& image, const Spot& spot, Values& values) {
  constexpr int r = kSide / 2;
  std::size_t i = 0;
  float mean = 0, norm = 0;
  for (int y = -r; y <= r; ++y)
    for (int x = -r; x <= r; ++x)
      mean += values[i++] = luma(image, spot.middle.x + x * spot.right.x + y * spot.down.x,
                                 spot.middle.y + x * spot.right.y + y * spot.down.y);
  mean /= kPatch;
  for (float& value : values) {
    value -= mean;
    norm += value * value;
  }
  const float scale = norm > 0 ? 1 / std::sqrt(norm) : 0;
  for (float& value : values) value *= scale;
  return std::sqrt(norm / kPatch);
}

float correlation(const Values& a, const Values& b) {
  float sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

/// Correlation of neighbours in a row of the patch: near 0 for noise.
float smoothness(const Values& values) {
  float sum = 0;
  for (std::size_t i = 0; i + 1 < values.size(); ++i)
    if (i % kSide != kSide - 1) sum += values[i] * values[i + 1];
  return sum;
}

std::optional<PhotoPoint> small_from_world(const View& view, int factor, const WorldPoint& p) {
  const std::optional<PhotoPoint> photo = photo_from_world(view, p);
  if (!photo) return {};
  return PhotoPoint{photo->x / factor, photo->y / factor};
}

/// A patch of a face's plane, some pixels wide in view a. Scaled about a's centre it slides along a's lines of sight and
/// stays on the same pixels of a.
struct Patch {
  WorldPoint centre;               ///< of view a
  std::array<WorldPoint, 3> rays;  ///< from there to the middle, a step to the right, a step down

  WorldPoint middle() const { return centre + rays[0]; }

  /// Nothing where it leaves the photo.
  std::optional<Spot> spot(const View& view, const SmallPhoto& photo, double scale) const {
    std::array<PhotoPoint, 3> at;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto p = small_from_world(view, photo.factor, centre + scale * rays[i]);
      if (!p) return {};
      at[i] = *p;
    }
    const Spot s{at[0], {at[1].x - at[0].x, at[1].y - at[0].y}, {at[2].x - at[0].x, at[2].y - at[0].y}};
    constexpr double half = kSide / 2.0;
    const double dx = half * (std::abs(s.right.x) + std::abs(s.down.x));
    const double dy = half * (std::abs(s.right.y) + std::abs(s.down.y));
    const bool inside = s.middle.x >= dx && s.middle.y >= dy && s.middle.x + dx <= photo.image.width &&
                        s.middle.y + dy <= photo.image.height;
    return inside ? std::optional(s) : std::nullopt;
  }
};

/// Nothing where view a sees the face at a grazing angle (less than 12 degrees).
std::optional<Patch> patch_of(const Mesh& mesh, FaceId face, const View& a, int factor) {
  constexpr double kLeastSine = 0.2;
  const Triangle& t = mesh.faces[index(face)];
  const WorldPoint &p = mesh.positions[t[0]], &q = mesh.positions[t[1]], &r = mesh.positions[t[2]];
  const WorldPoint normal = unit(cross(q - p, r - p)), to_middle = (p + q + r) * (1.0 / 3) - a.pose.centre;
  const CameraPoint c = to_camera_axes(a.pose, to_middle);
  if (c.z <= 0) return {};
  const PixelPoint at = pixel_from_camera(a.camera, c);
  const std::array<PixelPoint, 3> pixels{at, PixelPoint{at.x + factor, at.y}, PixelPoint{at.x, at.y + factor}};
  Patch patch{a.pose.centre, {}};
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const WorldPoint ray = ray_of(a, pixels[i]);
    const double slope = dot(normal, ray), depth = dot(normal, to_middle) / slope;
    if (!(std::abs(slope) > kLeastSine * length(ray)) || !(depth > 0)) return {};
    patch.rays[i] = depth * ray;
  }
  return patch;
}

/// A place in pixels, with what view a shows of it.
struct Textured {
  Place place;
  Patch patch;
  double pixels_per_disparity = 0;  ///< motion in view b as 1 / scale grows from 1
  Values values{};
};

/// Nothing where photos cannot tell positions along the line of sight apart: what view a shows is noise, or looks the same
/// some pixels on, as carpets and tiles do, or b sees it from too near a's direction.
std::optional<Textured> textured(const Mesh& mesh, const Scene& scene, std::span<const SmallPhoto> photos,
                                 const Place& place) {
  // Rounding and compression leave a standard deviation of about one grey level on even surfaces. Neighbours correlate by
  // 1 / 2 where noise has as much variance as what is photographed.
  constexpr float kLeastDeviation = 2, kLeastSmoothness = 0.5f, kMostAlike = 0.8f;
  constexpr double kTiny = 1e-4;
  const View &a = scene.views[index(place.a)], &b = scene.views[index(place.b)];
  const SmallPhoto &in_a = photos[index(place.a)], &in_b = photos[index(place.b)];
  const std::optional<Patch> patch = patch_of(mesh, place.face, a, in_a.factor);
  if (!patch) return {};
  const std::optional<Spot> spot = patch->spot(a, in_a, 1);
  if (!spot) return {};
  const auto here = small_from_world(b, in_b.factor, patch->middle());
  const auto next = small_from_world(b, in_b.factor, patch->centre + (1 / (1 + kTiny)) * patch->rays[0]);
  // What b looks at passes through here in a.
  const auto passing = small_from_world(a, in_a.factor, patch->middle() + kTiny * (b.pose.centre - patch->middle()));
  if (!here || !next || !passing) return {};
  Textured result{place, *patch, std::hypot(next->x - here->x, next->y - here->y) / kTiny, {}};
  // The farthest positions are at most at half and twice the mesh's distance.
  if (!(result.pixels_per_disparity > 2 * kReach)) return {};
  if (take(in_a.image, *spot, result.values) < kLeastDeviation || smoothness(result.values) < kLeastSmoothness)
    return {};
  const double dx = passing->x - spot->middle.x, dy = passing->y - spot->middle.y, norm = std::hypot(dx, dy);
  // As far as positions are tried, in steps below half a patch.
  for (int distance = 3; distance <= kReach; distance += 3)
    for (const double step : {-distance / norm, distance / norm}) {
      Spot beside = *spot;
      beside.middle.x += step * dx;
      beside.middle.y += step * dy;
      Values values;
      take(in_a.image, beside, values);
      if (!(correlation(values, result.values) < kMostAlike)) return {};
    }
  return result;
}

/// The best of all positions.
struct Best {
  float correlation = -1;
  int offset = 0;  ///< from the mesh, in pixels

  void offer(float value, int at) {
    if (value > correlation) *this = {value, at};
  }
};

struct Found {
  bool whole = false;  ///< all positions lie in the photo
  Best own, by_chance;
};

Found find(const Textured& place, const Values& elsewhere, const View& b, const SmallPhoto& photo) {
  Found found;
  Values values;
  for (int k = -kReach; k <= kReach; ++k) {
    const std::optional<Spot> spot = place.patch.spot(b, photo, 1 / (1 + k / place.pixels_per_disparity));
    if (!spot) return {};
    take(photo.image, *spot, values);
    found.own.offer(correlation(place.values, values), k);
    found.by_chance.offer(correlation(elsewhere, values), k);
  }
  found.whole = true;
  return found;
}

/// Share of the places that pass for found by chance.
constexpr double kByChance = 0.05;

/// Any of the views, and of those apart from it by 3 degrees and more, up to the angle of a least cosine, the nearest.
std::optional<Place> seen_by_two(const Mesh& mesh, const Scene& scene, std::uint32_t face,
                                 std::span<const std::uint32_t> views, double least_cosine) {
  constexpr double kLeastAngle = 0.05;
  if (views.size() < 2) return {};
  const WorldPoint& p = mesh.positions[mesh.faces[face][0]];
  const auto towards = [&](std::uint32_t view) { return unit(scene.views[view].pose.centre - p); };
  const std::uint32_t a = views[(face * 0x9E3779B1u >> 8) % views.size()];
  const WorldPoint to_a = towards(a);
  const double most = std::cos(kLeastAngle);
  double nearest = least_cosine;
  std::optional<Place> place;
  for (const std::uint32_t b : views) {
    const double cosine = dot(to_a, towards(b));
    if (cosine > most || cosine <= nearest) continue;
    nearest = cosine;
    place = {FaceId{face}, ViewId{a}, ViewId{b}};
  }
  return place;
}

}  // namespace

std::string photo_fit_text(const MeshFit& fit) {
  if (fit.verdict == MeshFit::Verdict::unknown)
    return fmt::format("photos agree about a surface at {} of {} places with texture, which are too few to tell",
                       results::readable_count(fit.found), results::readable_count(fit.places));
  return fmt::format(
      "at {} of {} textured places the photos agree about a surface, {:.0f} % (+- {:.1f}) of these lie on the mesh",
      results::readable_count(fit.found), results::readable_count(fit.places), 100 * fit.share, 100 * fit.error);
}

std::string tie_point_fit_text(const MeshFit& fit) {
  if (fit.verdict == MeshFit::Verdict::unknown)
    return fmt::format("the scene's {} tie points on the mesh are too few to tell",
                       results::readable_count(fit.places));
  return fmt::format("of {} of the scene's tie points {:.0f} % (+- {:.1f}) lie on the mesh",
                     results::readable_count(fit.places), 100 * fit.share, 100 * fit.error);
}

SmallPhoto small_photo(const Image& photo) {
  const int factor = reduction(photo.width, photo.height);
  SmallPhoto small{factor, {photo.width / factor, photo.height / factor, 1, {}}};
  Image& image = small.image;
  image.pixels.resize(pixel_index(0, image.height, image.width));
  const int area = 256 * factor * factor;
  const auto channels = static_cast<std::size_t>(photo.channels);
  std::vector<std::uint16_t> columns(static_cast<std::size_t>(image.width * factor) * channels);
  for (int y = 0; y < image.height; ++y) {
    std::ranges::fill(columns, std::uint16_t{0});
    for (int j = 0; j < factor; ++j) {
      const std::uint8_t* in = photo.at(0, y * factor + j);
      for (std::size_t i = 0; i < columns.size(); ++i) columns[i] = static_cast<std::uint16_t>(columns[i] + in[i]);
    }
    const std::uint16_t* in = columns.data();
    for (int x = 0; x < image.width; ++x) {
      std::array<int, 3> sum{};
      for (int i = 0; i < factor; ++i, in += channels)
        for (std::size_t c = 0; c < 3; ++c) sum[c] += in[c];
      *image.at(x, y) = static_cast<std::uint8_t>((77 * sum[0] + 150 * sum[1] + 29 * sum[2] + area / 2) / area);
    }
  }
  return small;
}

SmallPhoto turned_over(SmallPhoto photo) {
  std::ranges::reverse(photo.image.pixels);
  return photo;
}

SmallPhoto mirrored(SmallPhoto photo) {
  Image& image = photo.image;
  for (int y = 0; y < image.height; ++y) std::reverse(image.at(0, y), image.at(0, y) + image.width);
  return photo;
}

bool is_compared(std::size_t number, std::size_t views) {
  constexpr std::size_t kBeside = 4, kRuns = 24;
  return views <= kBeside * kRuns || number % ((views + kRuns - 1) / kRuns) < kBeside;
}

std::vector<Place> choose_places(const Mesh& mesh, const Scene& scene, const labeling::CostTable& candidates,
                                 std::span<const SmallPhoto> photos, std::span<const ViewId> left_out) {
  constexpr std::size_t kMost = 3072;
  // Of 30 degrees: from farther apart the same surface looks different, and a mesh's own errors are many pixels.
  constexpr double kLeastCosine = 0.866;
  std::vector<std::uint8_t> usable(photos.size());
  for (std::size_t v = 0; v < photos.size(); ++v) usable[v] = photos[v].image.pixels.empty() ? 0 : 1;
  for (const ViewId view : left_out) usable[index(view)] = 0;
  // Steps of the golden ratio of the faces spread any number of them evenly. All faces are stepped on where step and number
  // have no factor in common.
  const std::size_t faces = candidates.faces();
  std::size_t step = static_cast<std::size_t>(0.6180339887 * static_cast<double>(faces));
  while (std::gcd(step, faces) > 1) ++step;
  std::vector<Place> places;
  std::vector<std::uint32_t> views;
  for (std::size_t n = 0, face = 0; n < faces && places.size() < kMost; ++n, face = (face + step) % faces) {
    views.clear();
    for (const std::uint32_t view : candidates.views_of(face))
      if (usable[view] != 0) views.push_back(view);
    if (const auto place = seen_by_two(mesh, scene, static_cast<std::uint32_t>(face), views, kLeastCosine))
      places.push_back(*place);
  }
  std::ranges::sort(places, {}, [](const Place& place) { return index(place.face); });
  return places;
}

std::vector<Place> framed_places(const Mesh& mesh, const Scene& scene, std::span<const SmallPhoto> photos) {
  std::vector<Place> places;
  std::vector<std::uint32_t> views;
  // Faces in one patch of a photo are one witness: a mesh that shrank to a point on the ground would have thousands.
  std::set<std::array<std::size_t, 3>> taken;
  const auto is_new = [&](const Place& place) {
    const auto at = small_from_world(scene.views[index(place.a)], photos[index(place.a)].factor,
                                     mesh.positions[mesh.faces[index(place.face)][0]]);
    const auto cell = [](double pixel) { return static_cast<std::size_t>(pixel) / kSide; };
    return taken.insert({index(place.a), cell(at->x), cell(at->y)}).second;
  };
  for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) {
    const Triangle& t = mesh.faces[f];
    const WorldPoint& p = mesh.positions[t[0]];
    const WorldPoint normal = cross(mesh.positions[t[1]] - p, mesh.positions[t[2]] - p);
    views.clear();
    for (std::uint32_t v = 0; v < photos.size(); ++v) {
      const Image& image = photos[v].image;
      if (image.pixels.empty() || dot(normal, scene.views[v].pose.centre - p) <= 0) continue;
      const auto at = small_from_world(scene.views[v], photos[v].factor, p);
      if (at && at->x > 0 && at->y > 0 && at->x < image.width && at->y < image.height) views.push_back(v);
    }
    if (const auto place = seen_by_two(mesh, scene, f, views, -1); place && is_new(*place)) places.push_back(*place);
  }
  return places;
}

MeshFit measure_fit(const Mesh& mesh, const Scene& scene, std::span<const SmallPhoto> photos,
                    std::span<const Place> places) {
  std::vector<std::optional<Textured>> candidates(places.size());
  tbb::parallel_for(std::size_t{0}, places.size(),
                    [&](std::size_t i) { candidates[i] = textured(mesh, scene, photos, places[i]); });
  std::erase(candidates, std::nullopt);
  const std::size_t count = candidates.size();
  std::vector<Found> found(count);
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
    const Textured& place = *candidates[i];
    const std::size_t b = index(place.place.b);
    found[i] = find(place, candidates[(i + count / 2) % count]->values, scene.views[b], photos[b]);
  });
  std::erase_if(found, [](const Found& each) { return !each.whole; });
  if (found.empty()) return {};
  std::vector<float> chance;
  for (const Found& each : found) chance.push_back(each.by_chance.correlation);
  const auto limit = chance.begin() + static_cast<std::ptrdiff_t>((1 - kByChance) * static_cast<double>(chance.size()));
  std::ranges::nth_element(chance, limit);
  // Chance finds a surface at any position.
  constexpr double kByChanceOn = kByChance * (2 * kOnMesh + 1) / kPositions, kByChanceOff = kByChance - kByChanceOn;
  FitGroups groups{};
  for (std::size_t i = 0; i < found.size(); ++i) {
    SurfaceCounts& group = groups[i % kFitGroups];
    group.places += 1;
    group.on_mesh -= kByChanceOn;
    group.off_mesh -= kByChanceOff;
    if (found[i].own.correlation <= *limit) continue;
    group.found += 1;
    (std::abs(found[i].own.offset) <= kOnMesh ? group.on_mesh : group.off_mesh) += 1;
  }
  return judge(groups);
}

}  // namespace gpvc::checks
