// Visibility by brute force: every pixel centre against every triangle, as rays in long double. Shares no geometry with
// visibility/: no projection, no edge functions, no rasterizer.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "io/scene.h"
#include "visibility/result.h"

namespace gpvc::oracle {

using Real = long double;

struct Vec {
  Real x = 0, y = 0, z = 0;
};
inline Vec operator-(const Vec& a, const Vec& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Real dot(const Vec& a, const Vec& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec cross(const Vec& a, const Vec& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Real norm(const Vec& a) { return std::sqrt(dot(a, a)); }

inline Vec in_camera(const Pose& pose, const WorldPoint& p) {
  const Vec d{Real{p.x} - pose.centre.x, Real{p.y} - pose.centre.y, Real{p.z} - pose.centre.z};
  const auto& r = pose.rotation;
  return {r[0] * d.x + r[1] * d.y + r[2] * d.z, r[3] * d.x + r[4] * d.y + r[5] * d.z,
          r[6] * d.x + r[7] * d.y + r[8] * d.z};
}

/// Where the ray of a pixel position meets a triangle, in the camera frame.
struct Hit {
  Real depth = 0;
  Real margin_px = 0;  ///< distance to the nearest edge line on the image, negative outside
};

/// The ray's direction is (x, y, 1): the distance of a hit along it is its depth.
struct Ray {
  Vec direction;
  Real px_per_unit;  ///< focal length
};

inline Ray ray_of(const Camera& camera, Real px, Real py) {
  return {{(px - camera.cx) / camera.fx, (py - camera.cy) / camera.fy, 1}, std::min(camera.fx, camera.fy)};
}

using Corners = std::array<Vec, 3>;

inline std::optional<Hit> meet(const Ray& ray, const Corners& t, Real slack_px) {
  const Vec normal = cross(t[1] - t[0], t[2] - t[0]);
  const Real along = dot(normal, ray.direction);
  if (along == 0) return std::nullopt;
  const Real depth = dot(normal, t[0]) / along;
  if (!(depth > 0)) return std::nullopt;
  const Real facing = along > 0 ? 1 : -1;
  Real margin = std::numeric_limits<Real>::infinity();
  for (std::size_t k = 0; k < 3; ++k) {
    // The plane through the eye and an edge; its trace on the image is the edge's line.
    const Vec plane = cross(t[k], t[(k + 1) % 3]);
    const Real slope = std::hypot(plane.x, plane.y);
    if (slope == 0) return std::nullopt;
    margin = std::min(margin, facing * dot(plane, ray.direction) / slope * ray.px_per_unit);
  }
  if (margin < -slack_px) return std::nullopt;
  return Hit{depth, margin};
}

struct Answer {
  std::vector<visibility::FaceClass> classes;
  std::vector<bool> tied;  ///< a sample of the face lies within 1e-9 px of an edge, or 1e-12 of another depth
  std::vector<std::uint32_t> owners;  ///< per pixel; kNoFace's value where nothing is
};

inline constexpr Real kTiePx = 1e-9L, kTieDepth = 1e-12L;

struct Projected {
  Corners corners;
  bool all_in_front = false, front_facing = false, inside = false;
  Real x0 = 0, y0 = 0, x1 = 0, y1 = 0;  ///< bounds in pixels, when all in front
};

inline Projected prepare(const Mesh& mesh, const View& view, std::size_t face) {
  Projected p;
  const Camera& c = view.camera;
  p.all_in_front = true;
  p.inside = true;
  p.x0 = p.y0 = std::numeric_limits<Real>::infinity();
  p.x1 = p.y1 = -p.x0;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec v = in_camera(view.pose, mesh.positions[mesh.faces[face][k]]);
    p.corners[k] = v;
    if (!(v.z > 0)) {
      p.all_in_front = p.inside = false;
      continue;
    }
    const Real x = c.fx * v.x / v.z + c.cx, y = c.fy * v.y / v.z + c.cy;
    p.inside = p.inside && x >= 0 && y >= 0 && x <= c.width && y <= c.height;
    p.x0 = std::min(p.x0, x);
    p.x1 = std::max(p.x1, x);
    p.y0 = std::min(p.y0, y);
    p.y1 = std::max(p.y1, y);
  }
  // Counter-clockwise from outside: the normal points towards the camera.
  const Vec normal = cross(p.corners[1] - p.corners[0], p.corners[2] - p.corners[0]);
  p.front_facing = dot(normal, p.corners[0]) < 0;
  return p;
}

inline bool in_image(const Camera& camera, Real px, Real py) {
  return px >= 0 && py >= 0 && px <= camera.width && py <= camera.height &&
         in_photo(camera, {static_cast<double>(px), static_cast<double>(py)});
}

/// True when all corners are behind the camera or beyond one and the same border of the frame.
inline bool beside_frame(const Camera& camera, const Corners& corners) {
  const auto all = [&](auto&& beyond) { return std::all_of(corners.begin(), corners.end(), beyond); };
  const auto u = [&](const Vec& v) { return camera.fx * v.x + camera.cx * v.z; };
  const auto v = [&](const Vec& p) { return camera.fy * p.y + camera.cy * p.z; };
  return all([](const Vec& p) { return !(p.z > 0); }) || all([&](const Vec& p) { return u(p) < 0; }) ||
         all([&](const Vec& p) { return v(p) < 0; }) || all([&](const Vec& p) { return u(p) > camera.width * p.z; }) ||
         all([&](const Vec& p) { return v(p) > camera.height * p.z; });
}

/// Faces by the square of the image that they may touch, so that large scenes can be checked too.
class Squares {
 public:
  Squares(const Camera& camera, const std::vector<Projected>& faces)
      : columns_(camera.width / kSize + 1), rows_(camera.height / kSize + 1) {
    lists_.resize(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
    for (std::size_t f = 0; f < faces.size(); ++f) {
      const Projected& p = faces[f];
      const bool bounded = p.all_in_front;
      const int x0 = bounded ? square(p.x0 - 1, columns_) : 0, x1 = bounded ? square(p.x1 + 1, columns_) : columns_ - 1;
      const int y0 = bounded ? square(p.y0 - 1, rows_) : 0, y1 = bounded ? square(p.y1 + 1, rows_) : rows_ - 1;
      for (int y = y0; y <= y1; ++y)
        for (int x = x0; x <= x1; ++x) list(x, y).push_back(f);
    }
  }
  const std::vector<std::size_t>& at(Real px, Real py) const {
    return const_cast<Squares*>(this)->list(square(px, columns_), square(py, rows_));
  }

 private:
  static constexpr int kSize = 16;
  static int square(Real position, int count) {
    return static_cast<int>(std::clamp(std::floor(position / kSize), Real{0}, static_cast<Real>(count - 1)));
  }
  std::vector<std::size_t>& list(int x, int y) {
    return lists_[static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(x)];
  }
  int columns_, rows_;
  std::vector<std::vector<std::size_t>> lists_;
};

/// True when `face` is the nearest at a position that its projection contains; sets `tied` where that is a tie.
inline bool owns(const std::vector<Projected>& faces, const Squares& squares, const Ray& ray, Real px, Real py,
                 std::size_t face, bool& tied) {
  const std::optional<Hit> own = meet(ray, faces[face].corners, kTiePx);
  if (!own) {
    tied = true;
    return false;
  }
  for (const std::size_t other : squares.at(px, py)) {
    if (other == face) continue;
    const std::optional<Hit> hit = meet(ray, faces[other].corners, kTiePx);
    if (!hit) continue;
    if (std::abs(hit->depth - own->depth) < kTieDepth * own->depth) {
      tied = true;
      continue;
    }
    if (hit->depth > own->depth) continue;
    if (std::abs(hit->margin_px) < kTiePx) {
      tied = true;
      continue;
    }
    return false;
  }
  return true;
}

/// O(pixels of all faces * faces nearby). Distortion is honoured through in_photo alone.
inline Answer classify(const Mesh& mesh, const View& view, bool subpixel = true) {
  const Camera& camera = view.camera;
  std::vector<Projected> faces;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) faces.push_back(prepare(mesh, view, f));
  const Squares squares(camera, faces);
  Answer answer;
  answer.classes.assign(faces.size(), visibility::FaceClass::hidden);
  answer.tied.assign(faces.size(), false);
  answer.owners.assign(static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height),
                       static_cast<std::uint32_t>(kNoFace));
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const Projected& p = faces[f];
    bool tied = false;
    std::size_t samples = 0, seen = 0, outside = 0;
    const int w = camera.width, h = camera.height;
    const auto bound = [](Real v, int most) {
      return static_cast<int>(std::clamp(std::floor(v), Real{0}, static_cast<Real>(most)));
    };
    const int xa = p.all_in_front ? bound(p.x0 - 1, w - 1) : 0, xb = p.all_in_front ? bound(p.x1 + 1, w - 1) : w - 1;
    const int ya = p.all_in_front ? bound(p.y0 - 1, h - 1) : 0, yb = p.all_in_front ? bound(p.y1 + 1, h - 1) : h - 1;
    for (int y = ya; y <= yb; ++y)
      for (int x = xa; x <= xb; ++x) {
        const Real px = x + Real{0.5}, py = y + Real{0.5};
        const Ray ray = ray_of(camera, px, py);
        const std::optional<Hit> hit = meet(ray, p.corners, kTiePx);
        if (!hit) continue;
        if (std::abs(hit->margin_px) < kTiePx) {
          tied = true;
          continue;
        }
        ++samples;
        if (!in_image(camera, px, py)) {
          ++outside;
          continue;
        }
        if (!owns(faces, squares, ray, px, py, f, tied)) continue;
        ++seen;
        answer.owners[static_cast<std::size_t>(y) * static_cast<std::size_t>(w) + static_cast<std::size_t>(x)] =
            static_cast<std::uint32_t>(f);
      }
    visibility::FaceClass found = visibility::FaceClass::hidden;
    if (p.front_facing && samples == 0 && !beside_frame(camera, p.corners)) {
      if (!subpixel) {
        found = visibility::FaceClass::unresolved;
      } else {
        const Vec a = p.corners[0], b = p.corners[1], c = p.corners[2];
        const Vec g{(a.x + b.x + c.x) / 3, (a.y + b.y + c.y) / 3, (a.z + b.z + c.z) / 3};
        for (const Vec& v : {Vec{g.x + g.x, g.y + g.y, g.z + g.z}, Vec{g.x + a.x, g.y + a.y, g.z + a.z},
                             Vec{g.x + b.x, g.y + b.y, g.z + b.z}, Vec{g.x + c.x, g.y + c.y, g.z + c.z}}) {
          const Real px = camera.fx * v.x / v.z + camera.cx, py = camera.fy * v.y / v.z + camera.cy;
          ++samples;
          if (v.z > 0 && in_image(camera, px, py))
            seen += owns(faces, squares, ray_of(camera, px, py), px, py, f, tied);
        }
      }
    }
    if (p.front_facing && seen > 0) {
      const bool full = p.inside && outside == 0 && seen == samples;
      found = full ? visibility::FaceClass::full : visibility::FaceClass::partial;
    }
    answer.classes[f] = found;
    answer.tied[f] = tied;
  }
  return answer;
}

}  // namespace gpvc::oracle
