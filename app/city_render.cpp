#include <embree3/rtcore.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "app/city.h"

namespace gpvc {
namespace {

constexpr WorldPoint kSun{0.4514015204477136, -0.32099663676281853, 0.8325850266035605};  // unit length

struct Hit {
  bool surface = false;  // else the ground beyond the mesh, or the sky
  std::uint32_t face = 0;
};

struct Ray {
  WorldPoint origin, direction;
};

RTCRayHit embree_ray(const Ray& ray, double near, double far) {
  RTCRayHit r;
  r.ray = {};
  r.ray.org_x = static_cast<float>(ray.origin.x);
  r.ray.org_y = static_cast<float>(ray.origin.y);
  r.ray.org_z = static_cast<float>(ray.origin.z);
  r.ray.dir_x = static_cast<float>(ray.direction.x);
  r.ray.dir_y = static_cast<float>(ray.direction.y);
  r.ray.dir_z = static_cast<float>(ray.direction.z);
  r.ray.tnear = static_cast<float>(near);
  r.ray.tfar = static_cast<float>(far);
  r.ray.mask = 0xFFFFFFFFu;
  r.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  r.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  return r;
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

  Hit first_hit(const Ray& ray) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    RTCRayHit r = embree_ray(ray, 0, std::numeric_limits<float>::infinity());
    rtcIntersect1(scene, &context, &r);
    return {r.hit.geomID != RTC_INVALID_GEOMETRY_ID, r.hit.primID};
  }

  // From a point on the surface towards `direction`: is anything within `reach` of its length in the way?
  // Rays leave 5 mm off the surface: floats of the city's size (100 m) are 2^-17 m apart, its vertices lie on
  // a 1 mm grid.
  bool blocked(const WorldPoint& p, const WorldPoint& normal, const WorldPoint& direction,
               double reach) const {
    constexpr double kOff_m = 0.005;
    const Ray ray{{p.x + kOff_m * normal.x, p.y + kOff_m * normal.y, p.z + kOff_m * normal.z}, direction};
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRay r = embree_ray(ray, 0, reach).ray;
    rtcOccluded1(scene, &context, &r);
    return r.tfar < 0;
  }

  Colour lit(const Colour& albedo, const WorldPoint& p, const WorldPoint& normal) const {
    const double towards_sun = normal.x * kSun.x + normal.y * kSun.y + normal.z * kSun.z;
    double light = 0.42 + 0.13 * normal.z;
    if (towards_sun > 0 && !blocked(p, normal, kSun, 1e4)) light += 0.55 * towards_sun;
    return {albedo[0] * light, albedo[1] * light, albedo[2] * light};
  }

  Colour colour(const Ray& ray) const {
    const Hit hit = first_hit(ray);
    if (!hit.surface) {
      if (ray.direction.z >= -1e-3 * std::abs(ray.direction.x) - 1e-3 * std::abs(ray.direction.y))
        return {206, 218, 232};
      const double t = -ray.origin.z / ray.direction.z;
      const WorldPoint p{ray.origin.x + t * ray.direction.x, ray.origin.y + t * ray.direction.y, 0};
      return lit(city_albedo(city.surfaces[0], p), p, {0, 0, 1});
    }
    const WorldPoint& n = normals[hit.face];
    const WorldPoint& a = city.mesh.positions[city.mesh.faces[hit.face][0]];
    const double facing = n.x * ray.direction.x + n.y * ray.direction.y + n.z * ray.direction.z;
    if (facing == 0) return {0, 0, 0};  // along the face: no point to speak of
    const double t =
        (n.x * (a.x - ray.origin.x) + n.y * (a.y - ray.origin.y) + n.z * (a.z - ray.origin.z)) / facing;
    const WorldPoint p{ray.origin.x + t * ray.direction.x, ray.origin.y + t * ray.direction.y,
                       ray.origin.z + t * ray.direction.z};
    const WorldPoint seen = facing < 0 ? n : WorldPoint{-n.x, -n.y, -n.z};
    return lit(city_albedo(city.surfaces[city.face_surface[hit.face]], p), p, seen);
  }
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

Image CityRenderer::photo(const Camera& camera, const Pose& pose) const {
  Image image;
  image.width = camera.width;
  image.height = camera.height;
  image.pixels.resize(static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height) * 3);
  const auto& r = pose.rotation;
  tbb::parallel_for(0, camera.height, [&](int y) {
    for (int x = 0; x < camera.width; ++x) {
      Colour sum{};
      for (int sample = 0; sample < 4; ++sample) {
        const PhotoPoint at{x + 0.25 + 0.5 * (sample % 2), y + 0.25 + 0.5 * (sample / 2)};
        const auto pixel = pixel_from_photo(camera, at);
        if (!pixel) continue;  // beyond the fold of the lens: black
        const double cx = (pixel->x - camera.cx) / camera.fx, cy = (pixel->y - camera.cy) / camera.fy;
        const WorldPoint d{r[0] * cx + r[3] * cy + r[6], r[1] * cx + r[4] * cy + r[7],
                           r[2] * cx + r[5] * cy + r[8]};
        const Colour c = state_->colour({pose.centre, d});
        for (std::size_t i = 0; i < 3; ++i) sum[i] += c[i];
      }
      std::uint8_t* out = image.at(x, y);
      for (std::size_t i = 0; i < 3; ++i)
        out[i] = static_cast<std::uint8_t>(std::clamp(sum[i] * 0.25 + 0.5, 0.0, 255.0));
    }
  });
  return image;
}

bool CityRenderer::sees(const Pose& pose, const WorldPoint& p) const {
  const WorldPoint d{pose.centre.x - p.x, pose.centre.y - p.y, pose.centre.z - p.z};
  // Leaves the surface towards the camera; all but the last millionth of the way.
  const double length = std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z);
  if (length == 0) return true;
  const WorldPoint towards{d.x / length, d.y / length, d.z / length};
  return !state_->blocked(p, towards, towards, length);
}

}  // namespace gpvc
