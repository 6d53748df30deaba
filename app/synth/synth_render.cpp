// Photos of a synthetic scene, by rays.
#include <embree_rays.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>

#include "app/synth/synth_scene.h"
#include "io/error.h"
#include "io/vector.h"

namespace gpvc::synth {
namespace {

constexpr std::size_t kSamples = 4;   // positions in a pixel, whose rays are traced together
constexpr Color kSky{206, 218, 232};  // also of haze

struct Ray {
  WorldPoint origin, direction;
};

// The point that a ray hits.
struct SurfacePoint {
  bool sky = true;
  WorldPoint position, normal;  // of the side that is seen
  Color albedo = kSky;
  std::uint32_t surface = kNoSurface;
  bool pane = false;  // of a window
};

template <class Packet>
void set_ray(Packet& packet, std::size_t i, const Ray& ray, float far) {
  packet.org_x[i] = static_cast<float>(ray.origin.x);
  packet.org_y[i] = static_cast<float>(ray.origin.y);
  packet.org_z[i] = static_cast<float>(ray.origin.z);
  packet.dir_x[i] = static_cast<float>(ray.direction.x);
  packet.dir_y[i] = static_cast<float>(ray.direction.y);
  packet.dir_z[i] = static_cast<float>(ray.direction.z);
  packet.tnear[i] = 0;
  packet.tfar[i] = far;
  packet.time[i] = 0;
  packet.mask[i] = 0xFFFFFFFFu;
  packet.id[i] = 0;
  packet.flags[i] = 0;
}

using Wavelengths = std::optional<std::array<double, 3>>;

Color color_of(const Surface& surface, const WorldPoint& p, const Wavelengths& wavelengths) {
  if (!wavelengths) return surface_albedo(surface, p);
  Color color{};
  for (std::size_t i = 0; i < color.size(); ++i) color[i] = 255 * surface_reflectance(surface, p, (*wavelengths)[i]);
  return color;
}

// A scene in Embree, with normals in double, since Embree's floats are too coarse for distances.
struct TracedScene {
  const SynthScene& scene;
  RTCScene traced = nullptr;
  std::vector<WorldPoint> normals;  // per face, unit length
  double off_m = 0;  // distance from a surface at which rays to the sun start: 800 float steps at the scene's size

  TracedScene(RTCDevice device, const SynthScene& from);
  ~TracedScene() {
    if (traced != nullptr) rtcReleaseScene(traced);
  }
  TracedScene(const TracedScene&) = delete;
  TracedScene& operator=(const TracedScene&) = delete;

  // Distance along the ray to the plane of a face, in lengths of its direction; NaN for a ray along the plane.
  double distance(const Ray& ray, std::uint32_t face) const {
    const WorldPoint& n = normals[face];
    const WorldPoint& a = scene.mesh.positions[scene.mesh.faces[face][0]];
    const double above = dot(n, a - ray.origin);
    const double facing = dot(n, ray.direction);
    return facing == 0 ? std::numeric_limits<double>::quiet_NaN() : above / facing;
  }

  SurfacePoint on_face(const Ray& ray, std::uint32_t face, std::uint32_t first_surface,
                       const Wavelengths& wavelengths) const {
    const double t = distance(ray, face);
    if (std::isnan(t)) return {};
    const WorldPoint& n = normals[face];
    const WorldPoint p = ray.origin + ray.direction * t;
    const WorldPoint seen = dot(n, ray.direction) < 0 ? n : n * -1;
    const std::uint32_t surface = scene.face_surface[face];
    const Surface& made = scene.surfaces[surface];
    return {false, p, seen, color_of(made, p, wavelengths), first_surface + surface, in_window_pane(made, p)};
  }
};

TracedScene::TracedScene(RTCDevice device, const SynthScene& from) : scene(from) {
  traced = rtcNewScene(device);
  rtcSetSceneFlags(traced, RTC_SCENE_FLAG_ROBUST);
  const Mesh& mesh = scene.mesh;
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                               3 * sizeof(float), mesh.positions.size()));
  auto* faces = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), mesh.faces.size()));
  if (vertices == nullptr || faces == nullptr) throw std::bad_alloc();
  double reach_m = 0;
  for (const WorldPoint& p : mesh.positions)
    for (const double v : {p.x, p.y, p.z}) {
      *vertices++ = static_cast<float>(v);
      reach_m = std::max(reach_m, std::abs(v));
    }
  off_m = reach_m * 1e-4;
  normals.reserve(mesh.faces.size());
  for (const Triangle& t : mesh.faces) {
    for (const std::uint32_t v : t) *faces++ = v;
    const WorldPoint &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
    normals.push_back(unit(cross(b - a, c - a)));
  }
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(traced, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(traced);
}

}  // namespace

struct SynthRenderer::State {
  RTCDevice device = nullptr;
  std::optional<TracedScene> still, unmodelled;
  Wavelengths wavelengths{};  // of the photo that is taken

  ~State() {
    unmodelled.reset();
    still.reset();
    if (device != nullptr) rtcReleaseDevice(device);
  }

  // The point of the endless ground that a ray hits, if the scene has one; else sky.
  SurfacePoint beyond(const Ray& ray) const {
    const auto& d = ray.direction;
    if (!still->scene.endless_ground || d.z >= -1e-3 * (std::abs(d.x) + std::abs(d.y))) return {};
    const double t = -ray.origin.z / d.z;
    const WorldPoint p{ray.origin.x + t * d.x, ray.origin.y + t * d.y, 0};
    return {false, p, {0, 0, 1}, color_of(still->scene.surfaces[0], p, wavelengths), kNoSurface, false};
  }

  using Points = std::array<SurfacePoint, kSamples>;

  void first_points(const std::array<Ray, kSamples>& rays, const std::array<bool, kSamples>& valid,
                    Points& points) const {
    alignas(16) std::array<int, kSamples> active{};
    std::array<double, kSamples> nearest;
    nearest.fill(std::numeric_limits<double>::infinity());
    for (std::size_t i = 0; i < kSamples; ++i) {
      active[i] = valid[i] ? -1 : 0;
      if (valid[i]) points[i] = beyond(rays[i]);
    }
    for (const auto* part : {&still, &unmodelled}) {
      if (!*part) continue;
      RTCRayHit4 hits;
      for (std::size_t i = 0; i < kSamples; ++i) {
        set_ray(hits.ray, i, rays[i], std::numeric_limits<float>::infinity());
        hits.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
        hits.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
      }
      embree::intersect(active.data(), (*part)->traced, hits);
      const auto first_surface = static_cast<std::uint32_t>(part == &unmodelled ? still->scene.surfaces.size() : 0);
      for (std::size_t i = 0; i < kSamples; ++i) {
        if (!valid[i] || hits.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) continue;
        const double t = (*part)->distance(rays[i], hits.hit.primID[i]);
        if (t >= nearest[i]) continue;
        nearest[i] = t;
        points[i] = (*part)->on_face(rays[i], hits.hit.primID[i], first_surface, wavelengths);
      }
    }
  }

  // -1 for each point that the sun reaches, else 0.
  std::array<int, kSamples> in_the_sun(const Points& points, const std::array<bool, kSamples>& valid,
                                       const WorldPoint& sun) const {
    alignas(16) std::array<int, kSamples> lit{};
    for (std::size_t i = 0; i < kSamples; ++i)
      lit[i] = valid[i] && !points[i].sky && dot(points[i].normal, sun) > 0 ? -1 : 0;
    for (const auto* part : {&still, &unmodelled}) {
      if (!*part) continue;
      RTCRay4 to_sun;
      const double off = still->off_m;
      for (std::size_t i = 0; i < kSamples; ++i) {
        set_ray(to_sun, i, {points[i].position + points[i].normal * off, sun}, 1e4F);
      }
      embree::occlude(lit.data(), (*part)->traced, to_sun);
      for (std::size_t i = 0; i < kSamples; ++i)
        if (lit[i] != 0 && to_sun.tfar[i] < 0) lit[i] = 0;
    }
    return lit;
  }

  // The light that a point sends towards the camera.
  static Color shaded(const SurfacePoint& p, bool lit, const WorldPoint& sun) {
    double light = p.sky ? 1 : 0.42 + 0.13 * p.normal.z;
    if (lit) light += 0.55 * dot(p.normal, sun);
    return {p.albedo[0] * light, p.albedo[1] * light, p.albedo[2] * light};
  }

  // Mixes into the colours of window panes what they mirror: the share of Schlick, "An inexpensive BRDF model for
  // physically-based rendering" (1994), for the two sides of a pane. What mirrored panes mirror is left out.
  void add_reflections(const std::array<Ray, kSamples>& rays, const Points& points,
                       const std::array<bool, kSamples>& valid, const WorldPoint& sun,
                       std::array<Color, kSamples>& colors) const {
    constexpr double kHeadOn = 0.08;     // of the light, at normal incidence: 0.04 at each side
    constexpr double kInTheSun = 0.999;  // cosine of 2.6 degrees: uneven glass widens the sun's half degree
    constexpr double kSunBrightness = 2550;
    std::array<Ray, kSamples> mirrored{};
    std::array<bool, kSamples> panes{};
    std::array<double, kSamples> shares{};
    for (std::size_t i = 0; i < kSamples; ++i) {
      panes[i] = valid[i] && points[i].pane;
      if (!panes[i]) continue;
      const SurfacePoint& p = points[i];
      const WorldPoint along = unit(rays[i].direction);
      const double facing = dot(along, p.normal), grazing = 1 + facing, grazing2 = grazing * grazing;
      shares[i] = kHeadOn + (1 - kHeadOn) * grazing2 * grazing2 * grazing;
      mirrored[i] = {p.position + p.normal * still->off_m, along - p.normal * (2 * facing)};
    }
    if (std::none_of(panes.begin(), panes.end(), [](bool pane) { return pane; })) return;
    Points met;
    first_points(mirrored, panes, met);
    const std::array<int, kSamples> lit = in_the_sun(met, panes, sun);
    for (std::size_t i = 0; i < kSamples; ++i) {
      if (!panes[i]) continue;
      Color image = shaded(met[i], lit[i] != 0, sun);
      if (met[i].sky && dot(mirrored[i].direction, sun) > kInTheSun) image.fill(kSunBrightness);
      for (std::size_t c = 0; c < 3; ++c) colors[i][c] += shares[i] * (image[c] - colors[i][c]);
    }
  }

  // What the rays of a pixel see.
  struct Seen {
    Color sum{};                         // of their colours; invalid ones are black
    std::uint32_t surface = kNoSurface;  // that all of them see
    std::uint32_t rays = 0, unmodelled = 0;

    void add(std::uint32_t s, std::size_t modelled_surfaces) {
      surface = rays++ == 0 || s == surface ? s : kMixedSurfaces;
      unmodelled += s != kNoSurface && s >= modelled_surfaces ? 1 : 0;
    }
  };

  void look_along(const std::array<Ray, kSamples>& rays, const std::array<bool, kSamples>& valid, const Shot& shot,
                  Seen& seen) const {
    Points points;
    first_points(rays, valid, points);
    const std::array<int, kSamples> lit = in_the_sun(points, valid, shot.towards_sun);
    std::array<Color, kSamples> colors{};
    for (std::size_t i = 0; i < kSamples; ++i)
      if (valid[i]) colors[i] = shaded(points[i], lit[i] != 0, shot.towards_sun);
    if (shot.reflections) add_reflections(rays, points, valid, shot.towards_sun, colors);
    Color sum{};
    for (std::size_t i = 0; i < kSamples; ++i) {
      seen.add(points[i].surface, still->scene.surfaces.size());
      if (!valid[i]) continue;
      const SurfacePoint& p = points[i];
      const double kept = p.sky ? 1 : haze_transmission(length(p.position - rays[i].origin), shot.visibility_m);
      for (std::size_t c = 0; c < 3; ++c) sum[c] += (colors[i][c] * kept + kSky[c] * (1 - kept)) * (1.0 / kSamples);
    }
    for (std::size_t c = 0; c < 3; ++c) seen.sum[c] += sum[c];
  }

  // What a pixel sees whose positions on the image plane start at `at`; the sum of its colours is their mean.
  Seen pixel(const Pose& pose, const Shot& shot, int x, int y, const PixelPoint* at) const {
    const auto rounds = static_cast<std::uint32_t>(shot.sharp() ? 1 : static_cast<std::size_t>(shot.rays) / kSamples);
    std::array<bool, kSamples> valid{};
    for (std::size_t s = 0; s < kSamples; ++s) valid[s] = !std::isnan(at[s].x);
    Seen seen;
    for (std::uint32_t round = 0; round < rounds; ++round) {
      std::array<Ray, kSamples> rays;
      for (std::size_t s = 0; s < kSamples; ++s) {
        CameraRay ray{{}, {at[s].x, at[s].y, 1}};
        if (!shot.sharp()) {
          const auto n = static_cast<std::uint32_t>(round * kSamples + s);
          ray = shot_ray(shot, at[s].x, at[s].y,
                         lens_sample(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y), n));
        }
        rays[s] = {pose.centre + to_world_axes(pose, ray.origin), to_world_axes(pose, ray.direction)};
      }
      look_along(rays, valid, shot, seen);
    }
    for (double& c : seen.sum) c *= 1.0 / rounds;
    return seen;
  }

  // Positions of a row's samples on the undistorted image plane, four a pixel; NaN beyond the fold of the lens model.
  static void plane_row(const Camera& camera, int y, PixelPoint* row) {
    for (int x = 0; x < camera.width; ++x)
      for (int i = 0; i < static_cast<int>(kSamples); ++i) {
        constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
        const auto pixel = pixel_from_photo(camera, {x + 0.25 + 0.5 * (i % 2), y + 0.25 + 0.5 * (i / 2)});
        *row++ = pixel ? PixelPoint{(pixel->x - camera.cx) / camera.fx, (pixel->y - camera.cy) / camera.fy}
                       : PixelPoint{kNone, kNone};
      }
  }

  // How much brighter than straight below what a sample shows is, because it lies nearer to the shadow of the camera.
  static double backscattered(const Pose& pose, const Shot& shot, const PixelPoint& plane) {
    if (shot.backscatter == 0 || !std::isfinite(plane.x)) return 0;
    const auto& r = pose.rotation;
    const WorldPoint forward =
        unit(WorldPoint{r[0] * plane.x + r[3] * plane.y + r[6], r[1] * plane.x + r[4] * plane.y + r[7],
                        r[2] * plane.x + r[5] * plane.y + r[8]});
    return shot.backscatter * (-dot(forward, shot.towards_sun) - shot.towards_sun.z);
  }

  // Keeps the samples of the camera, which all photos of a flight share, unless they are too many.
  void prepare(const Camera& camera) {
    constexpr std::size_t kMost = (std::size_t{256} << 20) / sizeof(PixelPoint);
    if (plane_camera && *plane_camera == camera) return;
    const std::size_t row = kSamples * static_cast<std::size_t>(camera.width);
    plane.clear();
    plane_camera = camera;
    if (row * static_cast<std::size_t>(camera.height) > kMost) return;
    plane.resize(row * static_cast<std::size_t>(camera.height));
    tbb::parallel_for(0, camera.height,
                      [&](int y) { plane_row(camera, y, plane.data() + row * static_cast<std::size_t>(y)); });
  }

  std::optional<Camera> plane_camera;
  std::vector<PixelPoint> plane;  // kSamples a pixel, or empty
};

SynthRenderer::SynthRenderer(const SynthScene& scene) : state_(std::make_unique<State>()) {
  // The same instruction set on every x86-64, for the same bits.
  state_->device = rtcNewDevice("isa=sse2");
  if (state_->device == nullptr) throw Error("Embree: no device");
  state_->still.emplace(state_->device, scene);
}

SynthRenderer::~SynthRenderer() = default;

SynthPhoto SynthRenderer::photo(const Camera& camera, const Pose& pose, const Shot& shot,
                                const SynthScene* unmodelled) {
  SynthPhoto photo;
  Image& image = photo.image;
  image.width = camera.width;
  image.height = camera.height;
  const auto width = static_cast<std::size_t>(camera.width), height = static_cast<std::size_t>(camera.height);
  image.pixels.resize(width * height * 3);
  photo.surfaces.resize(width * height);
  photo.unmodelled.resize(width * height);
  state_->prepare(camera);
  state_->wavelengths = shot.wavelengths_nm;
  if (shot.wavelengths_nm) photo.light.resize(width * height);
  state_->unmodelled.reset();
  if (unmodelled != nullptr && !unmodelled->mesh.faces.empty()) state_->unmodelled.emplace(state_->device, *unmodelled);
  const double half_x = camera.width / 2.0, half_y = camera.height / 2.0;
  tbb::parallel_for(0, camera.height, [&](int y) {
    std::vector<PixelPoint> own_row;
    const std::size_t row_samples = kSamples * width;
    const PixelPoint* at = state_->plane.data() + row_samples * static_cast<std::size_t>(y);
    if (state_->plane.empty()) {
      own_row.resize(row_samples);
      State::plane_row(camera, y, own_row.data());
      at = own_row.data();
    }
    for (int x = 0; x < camera.width; ++x, at += kSamples) {
      const State::Seen seen = state_->pixel(pose, shot, x, y, at);
      const std::size_t index = pixel_index(x, y, camera.width);
      photo.surfaces[index] = seen.surface;
      photo.unmodelled[index] = static_cast<std::uint8_t>((255 * seen.unmodelled + seen.rays / 2) / seen.rays);
      const double dx = x + 0.5 - half_x, dy = y + 0.5 - half_y;
      const double corner_share = (dx * dx + dy * dy) / (half_x * half_x + half_y * half_y);
      const double light = 1 + State::backscattered(pose, shot, *at);
      std::uint8_t* out = image.at(x, y);
      for (std::size_t i = 0; i < 3; ++i) {
        const double gain = light * shot.exposure.at(i, corner_share);
        out[i] = static_cast<std::uint8_t>(std::clamp(gain * seen.sum[i] + 0.5, 0.0, 255.0));
        if (!photo.light.empty()) photo.light[index][i] = static_cast<float>(gain * seen.sum[i] / 255);
      }
    }
  });
  state_->unmodelled.reset();
  return photo;
}

bool SynthRenderer::sees(const Pose& pose, const WorldPoint& p, std::uint32_t face) const {
  const TracedScene& still = *state_->still;
  const Ray ray{pose.centre, p - pose.centre};
  RTCRayHit hit{};
  hit.ray.org_x = static_cast<float>(ray.origin.x);
  hit.ray.org_y = static_cast<float>(ray.origin.y);
  hit.ray.org_z = static_cast<float>(ray.origin.z);
  hit.ray.dir_x = static_cast<float>(ray.direction.x);
  hit.ray.dir_y = static_cast<float>(ray.direction.y);
  hit.ray.dir_z = static_cast<float>(ray.direction.z);
  hit.ray.tfar = 2;
  hit.ray.mask = 0xFFFFFFFFu;
  hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  hit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  embree::intersect(still.traced, hit);
  if (hit.hit.geomID == RTC_INVALID_GEOMETRY_ID || hit.hit.primID == face) return true;
  // Where the surface is flat, the plane of a neighbouring face contains p. A dozen rounded operations on numbers of the
  // distance's size are accurate to 1e-13 of it, and to 1e-9 for rays at 1e-4 of a right angle to the plane.
  return !(still.distance(ray, hit.hit.primID) < 1 - 1e-9);
}

}  // namespace gpvc::synth
