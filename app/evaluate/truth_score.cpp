#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "app/evaluate/truth.h"
#include "app/evaluate/truth_origin.h"
#include "io/bilinear.h"
#include "io/vector.h"

namespace gpvc::evaluate {
namespace {

constexpr std::size_t kAimedSamples = 1200000;
constexpr int kMostOfAFace = 64;
constexpr int kOwnReach_px = 2, kOtherReach_px = 3;

struct Sample {
  std::uint32_t face = 0;
  float b = 0, c = 0;  // barycentric: p = A + b (B - A) + c (C - A)
};

using Pixel = std::array<float, 3>;
using IdPicture = std::shared_ptr<const std::vector<std::uint32_t>>;
// Decoding an id picture costs a tenth of a second for 6 megapixels, and every model asks for all of them.
constexpr std::size_t kKeptBytes = std::size_t{1} << 30;

// What photos show of a sample, at a gain of 1.
struct OwnColors {
  Pixel least{1e9F, 1e9F, 1e9F}, most{-1e9F, -1e9F, -1e9F};
  void add(const Pixel& p) {
    for (std::size_t i = 0; i < 3; ++i) {
      least[i] = std::min(least[i], p[i]);
      most[i] = std::max(most[i], p[i]);
    }
  }
  // How far outside, in the channel where it is farthest.
  double distance(const Pixel& p) const {
    float far = 0;
    for (std::size_t i = 0; i < 3; ++i) far = std::max({far, least[i] - p[i], p[i] - most[i]});
    return static_cast<double>(far);
  }
};

double distance(const Pixel& a, const Pixel& b) {
  return static_cast<double>(std::max({std::abs(a[0] - b[0]), std::abs(a[1] - b[1]), std::abs(a[2] - b[2])}));
}

WorldPoint twice_area_normal(const Mesh& mesh, std::size_t face) {
  const Triangle& t = mesh.faces[face];
  return cross(mesh.positions[t[1]] - mesh.positions[t[0]], mesh.positions[t[2]] - mesh.positions[t[0]]);
}

WorldPoint point_of(const Mesh& mesh, const Sample& s) {
  const Triangle& t = mesh.faces[s.face];
  const WorldPoint &p = mesh.positions[t[0]], u = mesh.positions[t[1]] - p, v = mesh.positions[t[2]] - p;
  const double b = s.b, c = s.c;
  return {p.x + b * u.x + c * v.x, p.y + b * u.y + c * v.y, p.z + b * u.z + c * v.z};
}

// A photo with what it shows, and a window into both.
struct Shown {
  const View& view;
  std::shared_ptr<const Image> photo;
  IdPicture surfaces;
  synth::Exposure exposure;

  std::optional<PhotoPoint> project(const WorldPoint& p) const {
    const CameraPoint c = camera_from_world(view.pose, p);
    if (c.z <= 0) return std::nullopt;
    const auto at = photo_from_pixel(view.camera, pixel_from_camera(view.camera, c));
    if (!at || !(at->x >= 0) || !(at->y >= 0) || at->x >= photo->width || at->y >= photo->height) return std::nullopt;
    return at;
  }
  std::uint32_t surface(int x, int y) const {
    return (
        *surfaces)[static_cast<std::size_t>(y) * static_cast<std::size_t>(photo->width) + static_cast<std::size_t>(x)];
  }
  Pixel color(int x, int y) const {
    const double dx = (x + 0.5) / photo->width * 2 - 1, dy = (y + 0.5) / photo->height * 2 - 1;
    // As the synthetic camera has it: by the distance in pixels, 1 in the corner.
    const double w = photo->width, h = photo->height;
    const auto scale = static_cast<float>(1 / exposure.at((dx * dx * w * w + dy * dy * h * h) / (w * w + h * h)));
    const std::uint8_t* p = photo->at(x, y);
    return {scale * static_cast<float>(p[0]), scale * static_cast<float>(p[1]), scale * static_cast<float>(p[2])};
  }
  // The pixels within `reach` of `at`, as far as there are.
  template <class Visit>
  void around(const PhotoPoint& at, int reach, const Visit& visit) const {
    const int cx = static_cast<int>(at.x), cy = static_cast<int>(at.y);
    for (int y = std::max(0, cy - reach); y <= std::min(photo->height - 1, cy + reach); ++y)
      for (int x = std::max(0, cx - reach); x <= std::min(photo->width - 1, cx + reach); ++x) visit(x, y);
  }
  struct Window {
    bool alone = true;  ///< the 4 x 4 pixels around a place are all there and show that surface alone
    bool any = false;   ///< one of them shows it, or several surfaces
  };
  Window window(const PhotoPoint& at, std::uint32_t of) const {
    const int x0 = static_cast<int>(std::floor(at.x - 0.5)) - 1, y0 = static_cast<int>(std::floor(at.y - 0.5)) - 1;
    Window found;
    for (int y = y0; y < y0 + 4; ++y)
      for (int x = x0; x < x0 + 4; ++x) {
        const bool there = x >= 0 && y >= 0 && x < photo->width && y < photo->height;
        const std::uint32_t shows = there ? surface(x, y) : synth::kNoSurface;
        if (shows != of) found.alone = false;
        if (shows == of || shows == synth::kMixedSurfaces) found.any = true;
      }
    return found;
  }
};

// The mesh less an origin, for rays in floats.
synth::SynthScene traced_scene(const Truth& truth, WorldPoint& origin) {
  WorldPoint lo = truth.mesh.positions.front(), hi = lo;
  for (const WorldPoint& p : truth.mesh.positions) {
    lo = {std::min(lo.x, p.x), std::min(lo.y, p.y), std::min(lo.z, p.z)};
    hi = {std::max(hi.x, p.x), std::max(hi.y, p.y), std::max(hi.z, p.z)};
  }
  // Whole metres above a hundred: what is left is as exact as it was.
  const auto middle = [](double a, double b) {
    const double m = (a + b) / 2;
    return std::abs(m) < 100 ? 0.0 : std::floor(m);
  };
  origin = {middle(lo.x, hi.x), middle(lo.y, hi.y), middle(lo.z, hi.z)};
  synth::SynthScene scene;
  scene.mesh.faces = truth.mesh.faces;
  scene.mesh.positions.reserve(truth.mesh.positions.size());
  for (const WorldPoint& p : truth.mesh.positions) scene.mesh.positions.push_back(p - origin);
  return scene;
}

std::optional<Pixel> texel(const MatchedModel& matched, const Sample& s) {
  const std::uint32_t face = matched.model_face[s.face];
  if (face == kNoModelFace || matched.model->face_page[face] >= matched.pages.size()) return std::nullopt;
  const std::array<double, 3> weights{1 - static_cast<double>(s.b) - static_cast<double>(s.c), static_cast<double>(s.b),
                                      static_cast<double>(s.c)};
  double u = 0, v = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const io::TexCoord& t = matched.model->texcoords[matched.model->face_texcoords[face][matched.corners[s.face][i]]];
    u += weights[i] * static_cast<double>(t.u);
    v += weights[i] * static_cast<double>(t.v);
  }
  const Image& page = matched.pages[matched.model->face_page[face]];
  const Rgb color = bilinear(page, u * page.width, v * page.height);
  return Pixel{static_cast<float>(color[0]), static_cast<float>(color[1]), static_cast<float>(color[2])};
}

}  // namespace

struct TruthScorer::State {
  const Truth& truth;
  const Mesh& mesh;
  std::vector<visibility::FaceClass> best;
  const Scene& scene;
  std::vector<ViewId> used;
  io::PhotoSource& photos;
  std::vector<Sample> samples;                   // the seen ones, in face order
  std::vector<double> areas;                     // of each
  std::vector<Sample> hidden;                    // those that no used photo sees, in face order
  std::vector<double> hidden_areas;              // of each
  std::vector<OwnColors> own;                    // of each
  std::vector<float> untold;                     // of each
  std::vector<float> gains{1.0F};                // by which a texel may differ from photos at gain 1
  mutable std::map<ViewId, IdPicture> pictures;  // id pictures, as far as kKeptBytes reach
  mutable std::size_t kept_bytes = 0;

  State(const Truth& t, const Mesh& m, std::span<const visibility::FaceClass> b, const Scene& s,
        std::span<const ViewId> u, io::PhotoSource& p)
      : truth(t), mesh(m), best(b.begin(), b.end()), scene(s), used(u.begin(), u.end()), photos(p) {}
  void sample_faces();
  void part_seen_from_hidden();
  void collect_own(const Progress& progress);
  void find_untold(const Progress& progress);
  Shown shown(ViewId id) const;
  IdPicture surfaces(ViewId id) const;
  struct Judged {
    std::vector<std::optional<atlas::PointOrigin>> origins;
    std::vector<OriginVerdict> verdicts;
    std::vector<WrongPoint> places;
  };
  Judged judged(const std::vector<Sample>& points, const OriginOf& origin) const;
  template <class Visit>
  static void each_of(std::size_t count, const Visit& visit) {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 1024),
                      [&](const tbb::blocked_range<std::size_t>& range) {
                        for (std::size_t i = range.begin(); i < range.end(); ++i) visit(i);
                      });
  }
  template <class Visit>
  void each(const Visit& visit) const {
    each_of(samples.size(), visit);
  }
  double own_distance(std::size_t i, const Pixel& texel) const {
    double least = std::numeric_limits<double>::infinity();
    for (const float g : gains) least = std::min(least, own[i].distance({texel[0] * g, texel[1] * g, texel[2] * g}));
    return least;
  }
  std::vector<double> other_distances(const std::vector<std::optional<Pixel>>& texels,
                                      const std::vector<double>& own_distances, const Progress& progress) const;

  // Per sample, a bit for each used view that shows it clear of other surfaces.
  std::vector<std::uint64_t> clear;
  std::size_t words = 0;
  std::vector<std::uint8_t> met;  // per sample: some used photo sees it, or its surface right beside it
  bool is_clear(std::size_t i, std::size_t view) const { return (clear[i * words + view / 64] >> (view % 64)) & 1u; }
};

Shown TruthScorer::State::shown(ViewId id) const {
  const View& view = scene.views[index(id)];
  Shown s{view, photos.photo(id), surfaces(id), {}};
  const auto exposure = truth.exposures.find(view.name);
  if (exposure != truth.exposures.end()) s.exposure = exposure->second;
  return s;
}

IdPicture TruthScorer::State::surfaces(ViewId id) const {
  if (const auto found = pictures.find(id); found != pictures.end()) return found->second;
  const View& view = scene.views[index(id)];
  std::vector<std::uint32_t> shown = read_id_picture(truth, view.name, view.camera.width, view.camera.height);
  // What a mask hides is used for nothing: no telling whose it is.
  if (const std::optional<io::PhotoExclusion> exclusion = io::read_exclusion(view))
    for (int y = 0; y < view.camera.height; ++y)
      for (int x = 0; x < view.camera.width; ++x)
        if (exclusion->excludes(x, y))
          shown[static_cast<std::size_t>(y) * static_cast<std::size_t>(view.camera.width) +
                static_cast<std::size_t>(x)] = synth::kMixedSurfaces;
  auto picture = std::make_shared<const std::vector<std::uint32_t>>(std::move(shown));
  const std::size_t bytes = picture->size() * sizeof(std::uint32_t);
  if (kept_bytes + bytes > kKeptBytes) return picture;
  kept_bytes += bytes;
  return pictures[id] = std::move(picture);
}

// In proportion to area, at least one a face, spread by Roberts' two-dimensional golden ratio sequence.
void TruthScorer::State::sample_faces() {
  double total = 0;
  std::vector<double> face_area(mesh.faces.size());
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const WorldPoint n = twice_area_normal(mesh, f);
    face_area[f] = length(n) / 2;
    total += face_area[f];
  }
  const double cell = total / static_cast<double>(kAimedSamples);
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
      samples.push_back({f, static_cast<float>(u), static_cast<float>(v)});
      areas.push_back(face_area[f] / count);
    }
  }
}

void TruthScorer::State::collect_own(const Progress& progress) {
  WorldPoint origin;
  const synth::SynthScene traced = traced_scene(truth, origin);
  const synth::SynthRenderer renderer(traced);
  words = (used.size() + 63) / 64;
  clear.assign(samples.size() * words, 0);
  own.resize(samples.size());
  met.assign(samples.size(), 0);
  for (std::size_t n = 0; n < used.size(); ++n) {
    progress(n, 2 * used.size());
    const Shown photo = shown(used[n]);
    Pose pose = photo.view.pose;
    pose.centre = pose.centre - origin;
    each([&](std::size_t i) {
      const Sample& s = samples[i];
      const WorldPoint p = point_of(truth.mesh, s);
      const std::uint32_t surface = truth.face_surface[s.face];
      if (dot(twice_area_normal(truth.mesh, s.face), photo.view.pose.centre - p) <= 0) return;
      const auto at = photo.project(p);
      if (!at) return;
      const Shown::Window around = photo.window(*at, surface);
      if (around.any) met[i] = 1;
      if ((!around.alone && met[i] != 0) || !renderer.sees(pose, p - origin, s.face)) return;
      met[i] = 1;
      if (!around.alone) return;
      clear[i * words + n / 64] |= std::uint64_t{1} << (n % 64);
      photo.around(*at, kOwnReach_px, [&](int x, int y) {
        if (photo.surface(x, y) == surface) own[i].add(photo.color(x, y));
      });
    });
  }
}

void TruthScorer::State::part_seen_from_hidden() {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const auto bits = clear.begin() + static_cast<std::ptrdiff_t>(i * words);
    if (std::all_of(bits, bits + static_cast<std::ptrdiff_t>(words), [](std::uint64_t w) { return w == 0; })) {
      if (met[i] == 0) {
        hidden.push_back(samples[i]);
        hidden_areas.push_back(areas[i]);
      }
      continue;
    }
    samples[kept] = samples[i];
    areas[kept] = areas[i];
    own[kept] = own[i];
    std::copy_n(bits, words, clear.begin() + static_cast<std::ptrdiff_t>(kept * words));
    ++kept;
  }
  samples.resize(kept);
  areas.resize(kept);
  own.resize(kept);
  clear.resize(kept * words);
  met = {};
}

void TruthScorer::State::find_untold(const Progress& progress) {
  std::vector<std::uint16_t> hiding(samples.size(), 0), alike(samples.size(), 0);
  for (std::size_t n = 0; n < used.size(); ++n) {
    progress(used.size() + n, 2 * used.size());
    const Shown photo = shown(used[n]);
    each([&](std::size_t i) {
      if (is_clear(i, n)) return;
      const auto at = photo.project(point_of(truth.mesh, samples[i]));
      if (!at) return;
      const int x = static_cast<int>(at->x), y = static_cast<int>(at->y);
      const std::uint32_t there = photo.surface(x, y);
      if (there == synth::kMixedSurfaces || there == truth.face_surface[samples[i].face]) return;
      ++hiding[i];
      if (own_distance(i, photo.color(x, y)) <= kTold) ++alike[i];
    });
  }
  untold.resize(samples.size());
  for (std::size_t i = 0; i < samples.size(); ++i)
    untold[i] = hiding[i] == 0 ? 0.0F : static_cast<float>(alike[i]) / static_cast<float>(hiding[i]);
}

TruthScorer::TruthScorer(const Truth& truth, const Mesh& mesh, std::span<const visibility::FaceClass> best,
                         const Scene& scene, std::span<const ViewId> used, io::PhotoSource& photos,
                         const Progress& progress)
    : state_(new State(truth, mesh, best, scene, used, photos)) {
  if (mesh.faces.size() != truth.mesh.faces.size() || mesh.faces.size() != best.size())
    throw InputError(
        truth.dir, "",
        fmt::format("the truth is about {} faces, but the mesh has {}", truth.mesh.faces.size(), mesh.faces.size()));
  if (truth.most_gain > 1) {
    // Levelling may have brought a texel to any of the photos' gains.
    constexpr int kSteps = 8;
    state_->gains.clear();
    for (int n = 0; n <= kSteps; ++n)
      state_->gains.push_back(
          static_cast<float>(1 / (truth.least_gain + (truth.most_gain - truth.least_gain) * n / kSteps)));
  }
  state_->sample_faces();
  state_->collect_own(progress);
  state_->part_seen_from_hidden();
  state_->find_untold(progress);
}

TruthScorer::~TruthScorer() = default;

// How near photos come to the texels that are not their own surface's, with the colour of another.
std::vector<double> TruthScorer::State::other_distances(const std::vector<std::optional<Pixel>>& texels,
                                                        const std::vector<double>& own_distances,
                                                        const Progress& progress) const {
  std::vector<double> others(samples.size(), std::numeric_limits<double>::infinity());
  for (std::size_t n = 0; n < used.size(); ++n) {
    const Shown photo = shown(used[n]);
    each([&](std::size_t i) {
      if (!texels[i] || own_distances[i] <= kTold) return;
      const auto at = photo.project(point_of(truth.mesh, samples[i]));
      if (!at) return;
      const std::uint32_t surface = truth.face_surface[samples[i].face];
      photo.around(*at, kOtherReach_px, [&](int x, int y) {
        const std::uint32_t there = photo.surface(x, y);
        if (there == surface || there == synth::kMixedSurfaces) return;
        const Pixel color = photo.color(x, y), &t = *texels[i];
        for (const float g : gains) others[i] = std::min(others[i], distance(color, {t[0] * g, t[1] * g, t[2] * g}));
      });
    });
    progress(n + 1, used.size());
  }
  return others;
}

TruthScore TruthScorer::score(const MatchedModel& model, const Progress& progress) const {
  const State& s = *state_;
  std::vector<std::optional<Pixel>> texels(s.samples.size());
  std::vector<double> own_distances(s.samples.size(), 0);
  s.each([&](std::size_t i) {
    texels[i] = texel(model, s.samples[i]);
    if (texels[i]) own_distances[i] = s.own_distance(i, *texels[i]);
  });
  const std::vector<double> others = s.other_distances(texels, own_distances, progress);

  TruthScore score;
  score.samples = s.samples.size();
  const auto kind = [&](std::size_t face) -> std::size_t {
    return s.best[face] == visibility::FaceClass::full ? 0 : s.best[face] == visibility::FaceClass::partial ? 1 : 2;
  };
  for (std::size_t f = 0; f < s.mesh.faces.size(); ++f) {
    const WorldPoint normal = twice_area_normal(s.mesh, f);
    const double area = length(normal) / 2;
    score.all.area += area;
    if (kind(f) < 2) (kind(f) == 0 ? score.full : score.partial).area += area;
    ++score.faces[kind(f)];
    const std::uint32_t g = model.model_face[f];
    if (g != kNoModelFace && model.model->face_page[g] < model.pages.size()) ++score.textured[kind(f)];
  }
  for (std::size_t i = 0; i < s.samples.size(); ++i) {
    const std::uint32_t face = s.samples[i].face;
    const bool off = texels[i] && own_distances[i] > kTold, wrong = off && others[i] < own_distances[i];
    if (wrong && (score.wrong_faces.empty() || score.wrong_faces.back() != face)) score.wrong_faces.push_back(face);
    for (TruthShares* shares : {&score.all, kind(face) == 0 ? &score.full : &score.partial}) {
      shares->seen_area += s.areas[i];
      if (!texels[i]) continue;
      shares->textured += s.areas[i];
      shares->wrong += wrong ? s.areas[i] : 0;
      shares->strange += off && !wrong ? s.areas[i] : 0;
      shares->untold += s.areas[i] * static_cast<double>(s.untold[i]);
    }
  }
  for (TruthShares* shares : {&score.all, &score.full, &score.partial}) {
    const double textured = shares->textured;
    for (double* part : {&shares->wrong, &shares->strange, &shares->untold})
      *part = textured > 0 ? *part / textured : 0;
    shares->textured = shares->seen_area > 0 ? textured / shares->seen_area : 0;
  }
  return score;
}

TruthScorer::State::Judged TruthScorer::State::judged(const std::vector<Sample>& points, const OriginOf& origin) const {
  Judged result{std::vector<std::optional<atlas::PointOrigin>>(points.size()),
                std::vector<OriginVerdict>(points.size(), OriginVerdict::filled),
                std::vector<WrongPoint>(points.size())};
  each_of(points.size(), [&](std::size_t i) {
    result.origins[i] = origin(points[i].face, static_cast<double>(points[i].b), static_cast<double>(points[i].c));
  });
  for (const ViewId id : used) {
    const IdPicture picture = surfaces(id);
    const Camera& camera = scene.views[index(id)].camera;
    each_of(points.size(), [&](std::size_t i) {
      const std::optional<atlas::PointOrigin>& from = result.origins[i];
      if (!from) return;
      const std::uint32_t surface = truth.face_surface[points[i].face];
      for (const auto& [view, at] : {std::pair(from->first, from->first_at), {from->second, from->second_at}}) {
        if (view != id) continue;
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

OriginScore TruthScorer::score(const OriginOf& origin) const {
  const State& s = *state_;
  OriginScore score;
  score.right_area.assign(s.mesh.faces.size(), 0.0F);
  score.faithful_area.assign(s.mesh.faces.size(), 0.0F);
  const auto kind = [&](std::uint32_t face) -> OriginShares& {
    return s.best[face] == visibility::FaceClass::full      ? score.full
           : s.best[face] == visibility::FaceClass::partial ? score.partial
                                                            : score.none;
  };
  const State::Judged seen = s.judged(s.samples, origin);
  for (std::size_t i = 0; i < s.samples.size(); ++i) {
    const std::uint32_t face = s.samples[i].face;
    for (OriginShares* shares : {&score.all, &kind(face)}) {
      if (!seen.origins[i])
        shares->unknown += s.areas[i];
      else
        add_origin(seen.verdicts[i], s.areas[i], *shares);
    }
    if (!seen.origins[i]) continue;
    if (seen.verdicts[i] == OriginVerdict::wrong) score.wrong.push_back(seen.places[i]);
    if (seen.verdicts[i] != OriginVerdict::right && seen.verdicts[i] != OriginVerdict::edge) continue;
    score.right_area[face] += static_cast<float>(s.areas[i]);
    score.faithful_area[face] += static_cast<float>(s.areas[i]);
  }
  const State::Judged hidden = s.judged(s.hidden, origin);
  for (std::size_t i = 0; i < s.hidden.size(); ++i) {
    if (!hidden.origins[i]) continue;
    const std::uint32_t face = s.hidden[i].face;
    for (OriginShares* shares : {&score.all, &kind(face)})
      add_hidden_origin(hidden.verdicts[i], s.hidden_areas[i], *shares);
    if (hidden.verdicts[i] != OriginVerdict::wrong) score.faithful_area[face] += static_cast<float>(s.hidden_areas[i]);
  }
  for (OriginShares* shares : {&score.all, &score.full, &score.partial, &score.none}) make_shares(*shares);
  return score;
}

std::string truth_table(const TruthScore& score, const OriginScore* origins) {
  std::string table =
      "faces                     count  textured   of all area, seen   of that textured   wrong   strange   "
      "untold\n";
  const auto percent = [](double share) { return 100 * share; };
  const auto line = [&](const char* name, std::size_t faces, std::size_t textured, const TruthShares& s) {
    table += fmt::format("{:<22}{:>9}{:>10}{:>18.2f} %{:>16.2f} %{:>7.3f} %{:>7.3f} %{:>6.1f} %\n", name, faces,
                         textured, score.all.area > 0 ? percent(s.seen_area / score.all.area) : 0, percent(s.textured),
                         percent(s.wrong), percent(s.strange), percent(s.untold));
  };
  line("all", score.faces[0] + score.faces[1] + score.faces[2],
       score.textured[0] + score.textured[1] + score.textured[2], score.all);
  line("seen whole by a view", score.faces[0], score.textured[0], score.full);
  line("seen only in parts", score.faces[1], score.textured[1], score.partial);
  table += fmt::format("{:<22}{:>9}{:>10}\n", "seen by none", score.faces[2], score.textured[2]);
  return origins == nullptr ? table : table + origin_table(*origins);
}

}  // namespace gpvc::evaluate
