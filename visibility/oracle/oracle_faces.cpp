#include "visibility/oracle/oracle_faces.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "visibility/oracle/oracle_exact.h"

namespace gpvc::visibility::truth {
namespace {

struct Vector {
  long double x = 0, y = 0, z = 0;
};

long double dot(const Vector& a, const Vector& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Vector cross(const Vector& a, const Vector& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
long double length(const Vector& a) { return std::sqrt(dot(a, a)); }

Vector difference(const WorldPoint& a, const WorldPoint& b) {
  return {static_cast<long double>(a.x) - b.x, static_cast<long double>(a.y) - b.y,
          static_cast<long double>(a.z) - b.z};
}

Vector turned(const Pose& pose, const Vector& d) {
  const auto& r = pose.rotation;
  return {r[0] * d.x + r[1] * d.y + r[2] * d.z, r[3] * d.x + r[4] * d.y + r[5] * d.z,
          r[6] * d.x + r[7] * d.y + r[8] * d.z};
}

Vertex project(const View& view, const WorldPoint& p) {
  const Camera& c = view.camera;
  const Vector d = difference(p, view.pose.centre), q = turned(view.pose, d);
  // Rotations have entries up to 1: a coordinate of q is off by 6 r of d's sum, the products with focal length,
  // principal point and a position of the frame carry that and round four times themselves.
  const long double steps = 16 * std::numeric_limits<long double>::epsilon();
  const long double scale = std::max(c.fx, c.fy) + std::max(std::abs(c.cx), std::abs(c.cy)) +
                            static_cast<long double>(c.width) + c.height + 1;
  const long double size = std::abs(d.x) + std::abs(d.y) + std::abs(d.z);
  return {c.fx * q.x + c.cx * q.z, c.fy * q.y + c.cy * q.z, q.z, steps * scale * size};
}

/// How the face is turned, from edges taken in the world, where their own differences round least.
void orient(const Mesh& mesh, const View& view, std::size_t face, FaceFacts& facts) {
  const Triangle& t = mesh.faces[face];
  const auto& p = mesh.positions;
  const Vector along1 = turned(view.pose, difference(p[t[1]], p[t[0]]));
  const Vector along2 = turned(view.pose, difference(p[t[2]], p[t[0]]));
  const Vector eye = turned(view.pose, difference(p[t[0]], view.pose.centre));
  const long double volume = dot(cross(along1, along2), eye);
  const long double size = length(along1) * length(along2) * length(eye);
  // Each vector is off by 6 r of its length, and the triple product rounds 5 times more: 64 r is generous.
  if (std::abs(volume) > 64 * std::numeric_limits<long double>::epsilon() * size)
    facts.orientation = volume < 0 ? -1 : 1;
  else
    facts.orientation = static_cast<std::int8_t>(ExactFace(mesh, view, face).orientation());
  // Sine of an angle between face and ray, or between two edges, that rounded coordinates cannot keep apart from zero.
  facts.thin = std::abs(volume) <= 1e-12L * size;
}

bool exactly_inside(const Mesh& mesh, const View& view, std::size_t face) {
  const ExactFace exact(mesh, view, face);
  const Dyadic width(view.camera.width), height(view.camera.height);
  for (const ExactPoint& v : exact.vertices())
    if (v.w.sign() <= 0 || v.x.sign() < 0 || v.y.sign() < 0 || (width * v.w - v.x).sign() < 0 ||
        (height * v.w - v.y).sign() < 0)
      return false;
  return true;
}

/// True when the part in front of the camera certainly lies beside the frame: every vertex does, beyond the same
/// border, in homogeneous terms.
bool beside_frame(const Camera& c, const Corners& corners) {
  const auto all = [&](auto&& beyond) { return std::all_of(corners.begin(), corners.end(), beyond); };
  const long double w = c.width, h = c.height;
  return all([](const Vertex& v) { return v.z < -v.error; }) || all([](const Vertex& v) { return v.x < -v.error; }) ||
         all([](const Vertex& v) { return v.y < -v.error; }) ||
         all([w](const Vertex& v) { return v.x - w * v.z > v.error; }) ||
         all([h](const Vertex& v) { return v.y - h * v.z > v.error; });
}

struct Extent {
  long double x0 = std::numeric_limits<long double>::infinity(), y0 = x0, x1 = -x0, y1 = -x0;
  void add(long double x, long double y) {
    x0 = std::min(x0, x);
    x1 = std::max(x1, x);
    y0 = std::min(y0, y);
    y1 = std::max(y1, y);
  }
};

/// Height of the projected triangle over its longest side.
long double thickness_px(const Corners& corners) {
  std::array<long double, 3> x{}, y{};
  for (std::size_t k = 0; k < 3; ++k) {
    x[k] = corners[k].x / corners[k].z;
    y[k] = corners[k].y / corners[k].z;
  }
  long double longest = 0;
  for (std::size_t k = 0; k < 3; ++k)
    longest = std::max(longest, std::hypot(x[(k + 1) % 3] - x[k], y[(k + 1) % 3] - y[k]));
  const long double doubled = (x[1] - x[0]) * (y[2] - y[0]) - (y[1] - y[0]) * (x[2] - x[0]);
  return longest == 0 ? 0 : std::abs(doubled) / longest;
}

}  // namespace

std::vector<Vertex> project_vertices(const Mesh& mesh, const View& view) {
  std::vector<Vertex> vertices(mesh.positions.size());
  tbb::parallel_for(std::size_t{0}, vertices.size(),
                    [&](std::size_t v) { vertices[v] = project(view, mesh.positions[v]); });
  return vertices;
}

FaceFacts face_facts(const Mesh& mesh, const View& view, const Corners& corners, std::size_t face) {
  FaceFacts facts;
  const Camera& c = view.camera;
  if (beside_frame(c, corners)) return facts;
  for (const Vertex& v : corners) facts.crosses |= !(v.z > v.error);
  Extent extent;
  if (facts.crosses) {
    // A vertex so close to the camera plane that its side is not certain projects far outside, or anywhere.
    extent = {0, 0, static_cast<long double>(c.width), static_cast<long double>(c.height)};
  } else {
    facts.inside = Answer::yes;
    for (const Vertex& v : corners) {
      const long double x = v.x / v.z, y = v.y / v.z, error = v.error / v.z + kTiePx;
      extent.add(x, y);
      const long double room = std::min(std::min(x, y), std::min(c.width - x, c.height - y));
      facts.inside = std::min(facts.inside, room > error ? Answer::yes : room >= -error ? Answer::maybe : Answer::no);
    }
  }
  // A position within the frame is kept as float, off by 2^-24 of 2^16 at most.
  constexpr long double kWider = 0.01L;
  if (extent.x1 < -kWider || extent.y1 < -kWider || extent.x0 > c.width + kWider || extent.y0 > c.height + kWider)
    return facts;
  orient(mesh, view, face, facts);
  if (facts.orientation == 0) return facts;
  if (!facts.crosses) facts.thin |= thickness_px(corners) <= 2 * kTiePx;
  facts.reaches = true;
  const auto clamped = [](long double value, int most) {
    return static_cast<float>(std::clamp(value, -1.0L, most + 1.0L));
  };
  facts.x0 = clamped(extent.x0 - kWider, c.width);
  facts.y0 = clamped(extent.y0 - kWider, c.height);
  facts.x1 = clamped(extent.x1 + kWider, c.width);
  facts.y1 = clamped(extent.y1 + kWider, c.height);
  facts.inside_exactly =
      facts.inside == Answer::yes || (facts.inside == Answer::maybe && exactly_inside(mesh, view, face));
  return facts;
}

LocalFace::LocalFace(const Corners& corners, int orientation, double origin_x, double origin_y) {
  // Vertices as seen from the origin, each divided by a power of two that brings it to size 1: no product overflows,
  // and no digit is lost to the origin's own coordinates.
  std::array<double, 3> a{}, b{}, z{}, lost{};
  std::array<int, 3> scale{};
  for (std::size_t k = 0; k < 3; ++k) {
    const Vertex& v = corners[k];
    const long double from_x = v.x - origin_x * v.z, from_y = v.y - origin_y * v.z;
    std::frexp(std::max({std::abs(from_x), std::abs(from_y), std::abs(v.z)}), &scale[k]);
    const auto scaled = [&](long double value) { return static_cast<double>(std::ldexp(value, -scale[k])); };
    a[k] = scaled(from_x);
    b[k] = scaled(from_y);
    z[k] = scaled(v.z);
    lost[k] = scaled(v.error);
    depth_[k] = static_cast<double>(v.z);
  }
  const int least = std::min({scale[0], scale[1], scale[2]});
  constexpr double kRoundoff = std::numeric_limits<double>::epsilon() / 2;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
    Edge& edge = edges_[k];
    edge.x = orientation * (b[i] * z[j] - z[i] * b[j]);
    edge.y = orientation * (z[i] * a[j] - a[i] * z[j]);
    edge.c = orientation * (a[i] * b[j] - b[i] * a[j]);
    const double size_x = std::abs(b[i] * z[j]) + std::abs(z[i] * b[j]);
    const double size_y = std::abs(z[i] * a[j]) + std::abs(a[i] * z[j]);
    const double size_c = std::abs(a[i] * b[j]) + std::abs(b[i] * a[j]);
    // Each product carries two rounded factors and rounds itself, the difference once more, evaluation twice or thrice:
    // 7 r. What the vertices are off by is multiplied by the other's coordinates, at most 1.
    edge.error = 8 * kRoundoff * (kReach * (size_x + size_y) + size_c) + 2 * (lost[i] + lost[j]) * (2 * kReach + 1);
    edge.slope = std::hypot(edge.x, edge.y);
    edge.doubtful = kTiePx * edge.slope + edge.error;
    weight_[k] = std::ldexp(1.0, least - scale[k]);
    edge_error_sum_ += edge.error * weight_[k];
    slope_sum_ += edge.slope * weight_[k];
    largest_ = std::max(largest_, std::abs(depth_[k]));
    span_ = std::max(span_, std::abs(depth_[k] - depth_[0]));
  }
  span_ = std::max(span_, std::abs(depth_[1] - depth_[2]));
}

}  // namespace gpvc::visibility::truth
