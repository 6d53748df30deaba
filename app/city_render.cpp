#include <embree3/rtcore.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>

#include "app/city.h"

namespace gpvc {
namespace {

constexpr WorldPoint kSun{0.4514015204477136, -0.32099663676281853, 0.8325850266035605};  // unit length

constexpr std::size_t kSamples = 4;  // of a pixel, traced together

struct Ray {
  WorldPoint origin, direction;
};

// What a ray meets: a face, or, beyond the mesh, the ground going on for ever.
struct SurfacePoint {
  bool sky = true;
  WorldPoint position, normal;  // the side that is seen
  Colour albedo{206, 218, 232};
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

// Rays leave a surface 5 mm off it: floats of the city's size (100 m) are 2^-17 m apart, its vertices on a 1
// mm grid.
WorldPoint off_surface(const WorldPoint& p, const WorldPoint& normal) {
  constexpr double kOff_m = 0.005;
  return {p.x + kOff_m * normal.x, p.y + kOff_m * normal.y, p.z + kOff_m * normal.z};
}

}  // namespace

struct CityRenderer::State {
  const City& city;
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  std::vector<WorldPoint> normals;  // per face, unit length

  explicit State(const City& c) : city(c) {}
  ~State() {
    if (scene != nullptr) rtcReleaseScene(scene);
    if (device != nullptr) rtcReleaseDevice(device);
  }

  SurfacePoint on_face(const Ray& ray, std::uint32_t face) const {
    const WorldPoint& n = normals[face];
    const WorldPoint& a = city.mesh.positions[city.mesh.faces[face][0]];
    const double facing = n.x * ray.direction.x + n.y * ray.direction.y + n.z * ray.direction.z;
    if (facing == 0) return {};  // along the face: no point to speak of
    const double above = n.x * (a.x - ray.origin.x) + n.y * (a.y - ray.origin.y) + n.z * (a.z - ray.origin.z);
    const double t = above / facing;
    const WorldPoint p{ray.origin.x + t * ray.direction.x, ray.origin.y + t * ray.direction.y,
                       ray.origin.z + t * ray.direction.z};
    const WorldPoint seen = facing < 0 ? n : WorldPoint{-n.x, -n.y, -n.z};
    return {false, p, seen, city_albedo(city.surfaces[city.face_surface[face]], p)};
  }

  SurfacePoint beyond(const Ray& ray) const {
    const auto& d = ray.direction;
    if (d.z >= -1e-3 * (std::abs(d.x) + std::abs(d.y))) return {};
    const double t = -ray.origin.z / d.z;
    const WorldPoint p{ray.origin.x + t * d.x, ray.origin.y + t * d.y, 0};
    return {false, p, {0, 0, 1}, city_albedo(city.surfaces[0], p)};
  }

  // The mean colour of the samples; those that are not `valid` are black.
  Colour colour(const std::array<Ray, kSamples>& rays, const std::array<bool, kSamples>& valid) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    alignas(16) std::array<int, kSamples> active{};
    RTCRayHit4 hits;
    for (std::size_t i = 0; i < kSamples; ++i) {
      active[i] = valid[i] ? -1 : 0;
      set_ray(hits.ray, i, rays[i], std::numeric_limits<float>::infinity());
      hits.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
      hits.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
    }
    rtcIntersect4(active.data(), scene, &context, &hits);

    std::array<SurfacePoint, kSamples> points;
    alignas(16) std::array<int, kSamples> lit{};
    RTCRay4 to_sun;
    for (std::size_t i = 0; i < kSamples; ++i) {
      if (valid[i])
        points[i] = hits.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID ? on_face(rays[i], hits.hit.primID[i])
                                                                  : beyond(rays[i]);
      lit[i] = valid[i] && !points[i].sky && dot(points[i].normal, kSun) > 0 ? -1 : 0;
      set_ray(to_sun, i, {off_surface(points[i].position, points[i].normal), kSun}, 1e4F);
    }
    rtcOccluded4(lit.data(), scene, &context, &to_sun);

    Colour sum{};
    for (std::size_t i = 0; i < kSamples; ++i) {
      if (!valid[i]) continue;
      const SurfacePoint& p = points[i];
      double light = p.sky ? 1 : 0.42 + 0.13 * p.normal.z;
      if (lit[i] != 0 && !(to_sun.tfar[i] < 0)) light += 0.55 * dot(p.normal, kSun);
      for (std::size_t c = 0; c < 3; ++c) sum[c] += p.albedo[c] * light * (1.0 / kSamples);
    }
    return sum;
  }

  // Where the samples of a row of pixels lie on the undistorted plane, four a pixel; NaN beyond the fold of
  // the lens.
  static void plane_row(const Camera& camera, int y, PixelPoint* row) {
    for (int x = 0; x < camera.width; ++x)
      for (int i = 0; i < static_cast<int>(kSamples); ++i) {
        constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
        const auto pixel = pixel_from_photo(camera, {x + 0.25 + 0.5 * (i % 2), y + 0.25 + 0.5 * (i / 2)});
        *row++ = pixel ? PixelPoint{(pixel->x - camera.cx) / camera.fx, (pixel->y - camera.cy) / camera.fy}
                       : PixelPoint{kNone, kNone};
      }
  }

  // All photos of a flight share a camera: its samples are kept, unless they are many.
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

  static double dot(const WorldPoint& a, const WorldPoint& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
};

CityRenderer::CityRenderer(const City& city) : state_(std::make_unique<State>(city)) {
  // The lowest instruction set everywhere: the same bits on every x86-64.
  state_->device = rtcNewDevice("isa=sse2");
  if (state_->device == nullptr) throw std::runtime_error("Embree: no device");
  state_->scene = rtcNewScene(state_->device);
  rtcSetSceneFlags(state_->scene, RTC_SCENE_FLAG_ROBUST);
  RTCGeometry geometry = rtcNewGeometry(state_->device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), city.mesh.positions.size()));
  auto* faces = static_cast<std::uint32_t*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t),
                              city.mesh.faces.size()));
  if (vertices == nullptr || faces == nullptr) throw std::bad_alloc();
  for (const WorldPoint& p : city.mesh.positions)
    for (const double v : {p.x, p.y, p.z}) *vertices++ = static_cast<float>(v);
  for (const Triangle& t : city.mesh.faces) {
    for (const std::uint32_t v : t) *faces++ = v;
    const WorldPoint &a = city.mesh.positions[t[0]], &b = city.mesh.positions[t[1]],
                     &c = city.mesh.positions[t[2]];
    const double ux = b.x - a.x, uy = b.y - a.y, uz = b.z - a.z, vx = c.x - a.x, vy = c.y - a.y,
                 vz = c.z - a.z;
    const double nx = uy * vz - uz * vy, ny = uz * vx - ux * vz, nz = ux * vy - uy * vx;
    const double length = std::sqrt(nx * nx + ny * ny + nz * nz);
    const double s = length > 0 ? 1 / length : 0;
    state_->normals.push_back({nx * s, ny * s, nz * s});
  }
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(state_->scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(state_->scene);
}

CityRenderer::~CityRenderer() = default;

Image CityRenderer::photo(const Camera& camera, const Pose& pose) {
  Image image;
  image.width = camera.width;
  image.height = camera.height;
  image.pixels.resize(static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height) * 3);
  const auto& r = pose.rotation;
  state_->prepare(camera);
  tbb::parallel_for(0, camera.height, [&](int y) {
    std::vector<PixelPoint> own_row;
    const std::size_t row_samples = kSamples * static_cast<std::size_t>(camera.width);
    const PixelPoint* at = state_->plane.data() + row_samples * static_cast<std::size_t>(y);
    if (state_->plane.empty()) {
      own_row.resize(row_samples);
      State::plane_row(camera, y, own_row.data());
      at = own_row.data();
    }
    std::array<Ray, kSamples> rays;
    std::array<bool, kSamples> valid{};
    for (int x = 0; x < camera.width; ++x) {
      for (std::size_t s = 0; s < kSamples; ++s) {
        const double cx = at->x, cy = at->y;
        ++at;
        valid[s] = !std::isnan(cx);  // else black
        rays[s] = {
            pose.centre,
            {r[0] * cx + r[3] * cy + r[6], r[1] * cx + r[4] * cy + r[7], r[2] * cx + r[5] * cy + r[8]}};
      }
      const Colour c = state_->colour(rays, valid);
      std::uint8_t* out = image.at(x, y);
      for (std::size_t i = 0; i < 3; ++i)
        out[i] = static_cast<std::uint8_t>(std::clamp(c[i] + 0.5, 0.0, 255.0));
    }
  });
  return image;
}

bool CityRenderer::sees(const Pose& pose, const WorldPoint& p) const {
  const WorldPoint d{pose.centre.x - p.x, pose.centre.y - p.y, pose.centre.z - p.z};
  const double length = std::sqrt(State::dot(d, d));
  if (length == 0) return true;
  const WorldPoint towards{d.x / length, d.y / length, d.z / length};
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  alignas(16) const std::array<int, kSamples> active{-1, 0, 0, 0};
  RTCRay4 ray;
  for (std::size_t i = 0; i < kSamples; ++i)
    set_ray(ray, i, {off_surface(p, towards), towards}, static_cast<float>(length));
  rtcOccluded4(active.data(), state_->scene, &context, &ray);
  return !(ray.tfar[0] < 0);
}

}  // namespace gpvc
