#include "app/pipeline/render_model.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cassert>
#include <cmath>

#include "io/bilinear.h"
#include "io/images.h"
#include "visibility/item_buffer.h"

namespace gpvc::pipeline {
namespace {

/// A vertex in homogeneous pixel coordinates: it appears at (u / z, v / z). Nothing is divided, so that faces may cross
/// the camera plane.
struct Homogeneous {
  double u, v, z;
};

Homogeneous project(const Camera& camera, const Pose& pose, const WorldPoint& world) {
  const CameraPoint p = camera_from_world(pose, world);
  return {camera.fx * p.x + camera.cx * p.z, camera.fy * p.y + camera.cy * p.z, p.z};
}

/// A function of the pixel position (x, y): x * dx + y * dy + at_origin.
struct Linear {
  double dx = 0, dy = 0, at_origin = 0;
  double at(double x, double y) const { return dx * x + dy * y + at_origin; }
  void add(double weight, const Linear& other) {
    dx += weight * other.dx;
    dy += weight * other.dy;
    at_origin += weight * other.at_origin;
  }
};

/// The edge function of p and q, proportional to the third vertex's barycentric weight on the face in space: the
/// determinant of p, q and (x, y, 1).
Linear edge_function(const Homogeneous& p, const Homogeneous& q) {
  return {p.v * q.z - p.z * q.v, p.z * q.u - p.u * q.z, p.u * q.v - p.v * q.u};
}

using Corners = std::array<Homogeneous, 3>;

Corners corners_of(const Mesh& mesh, FaceId face, const Camera& camera, const Pose& pose) {
  Corners corners;
  for (std::size_t k = 0; k < 3; ++k)
    corners[k] = project(camera, pose, mesh.positions[mesh.faces[gpvc::index(face)][k]]);
  return corners;
}

/// Positive for a face that winds counter-clockwise for the eye, wherever the camera plane cuts it.
double facing(const Corners& c) {
  const Linear edge = edge_function(c[1], c[0]);
  return edge.dx * c[2].u + edge.dy * c[2].v + edge.at_origin * c[2].z;
}

/// Perspective-correct texel coordinates on one face: (u, v) / weight, each of the three linear in the pixel position.
struct TexelPlane {
  Linear u, v, weight;
  bool repeats = false;  ///< the page is to be repeated beyond its rim
};

TexelPlane texel_plane(const io::TexturedModel& model, FaceId face, const Image& page, const Camera& camera,
                       const Pose& pose) {
  const Corners corners = corners_of(*model.mesh, face, camera, pose);
  TexelPlane plane;
  plane.repeats = io::reaches_beyond_page(model, gpvc::index(face));
  for (std::size_t k = 0; k < 3; ++k) {
    const Linear weight = edge_function(corners[(k + 1) % 3], corners[(k + 2) % 3]);
    const io::TexCoord& at = model.texcoords[model.face_texcoords[gpvc::index(face)][k]];
    plane.u.add(static_cast<double>(at.u) * page.width, weight);
    plane.v.add(static_cast<double>(at.v) * page.height, weight);
    plane.weight.add(1, weight);
  }
  return plane;
}

/// The mipmap level: the logarithm, to base 2, of how many texels the texture coordinates pass from a pixel to the next one, along
/// x or y, whichever is more. What OpenGL chooses levels by.
double mipmap_level(const TexelPlane& plane, double u, double v, double weight) {
  const auto square = [](double a, double b) { return a * a + b * b; };
  const double along_x = square(plane.u.dx - u * plane.weight.dx, plane.v.dx - v * plane.weight.dx);
  const double along_y = square(plane.u.dy - u * plane.weight.dy, plane.v.dy - v * plane.weight.dy);
  return 0.5 * std::log2(std::max(along_x, along_y) / (weight * weight));
}

/// A page and its smaller levels, each half as wide and high as the one before.
struct Mipmap {
  const Image* page;
  std::vector<Image> smaller{};

  void build() {
    for (const Image* last = page; std::min(last->width, last->height) > 1; last = &smaller.back())
      smaller.push_back(io::reduce_image(*last, 2));
  }
  /// At texel (u, v) of the page.
  Rgb at(std::size_t level, double u, double v) const {
    const double scale = std::ldexp(1.0, -static_cast<int>(level));
    return bilinear(level == 0 ? *page : smaller[level - 1], u * scale, v * scale);
  }
  Rgb trilinear(double u, double v, double level) const {
    if (!(level > 0)) return at(0, u, v);
    level = std::min(level, static_cast<double>(smaller.size()));
    const auto finer = static_cast<std::size_t>(level);
    const double coarser_share = level - static_cast<double>(finer);
    Rgb color = at(finer, u, v);
    if (coarser_share == 0) return color;
    const Rgb coarser = at(finer + 1, u, v);
    for (std::size_t c = 0; c < 3; ++c) color[c] += coarser_share * (coarser[c] - color[c]);
    return color;
  }
};

class Shader {
 public:
  Shader(const io::TexturedModel& model, const std::vector<Image>& pages, const Camera& camera, const Pose& pose,
         const RenderOptions& options)
      : model_(model), camera_(camera), pose_(pose), options_(options) {
    for (const Image& page : pages) pages_.push_back({&page});
    if (options.mipmaps) tbb::parallel_for(std::size_t{0}, pages_.size(), [&](std::size_t n) { pages_[n].build(); });
  }

  /// Colours a row of pixels from the faces they show.
  void shade(int y, std::span<const FaceId> faces, std::uint8_t* rgb, std::uint8_t* textured) const {
    FaceId last = kNoFace;
    const Mipmap* page = nullptr;
    TexelPlane plane;
    for (std::size_t x = 0; x < faces.size(); ++x, rgb += 3) {
      if (faces[x] != last) {
        last = faces[x];
        page = last == kNoFace ? nullptr : page_of(last);
        if (page) plane = texel_plane(model_, last, *page->page, camera_, pose_);
      }
      if (!page) {
        std::copy(options_.background.begin(), options_.background.end(), rgb);
        continue;
      }
      textured[x] = 255;
      const double px = static_cast<double>(x) + 0.5, py = y + 0.5;
      const double weight = plane.weight.at(px, py);
      double u = plane.u.at(px, py) / weight, v = plane.v.at(px, py) / weight;
      const double level = options_.mipmaps ? mipmap_level(plane, u, v, weight) : 0;
      if (plane.repeats) {
        u = page->page->width * repeated(u / page->page->width);
        v = page->page->height * repeated(v / page->page->height);
      }
      const Rgb color = page->trilinear(u, v, level);
      for (std::size_t c = 0; c < 3; ++c) rgb[c] = static_cast<std::uint8_t>(color[c] + 0.5);
    }
  }

 private:
  const Mipmap* page_of(FaceId face) const {
    const std::uint32_t page = model_.face_page[gpvc::index(face)];
    return page < pages_.size() ? &pages_[page] : nullptr;
  }

  const io::TexturedModel& model_;
  std::vector<Mipmap> pages_;
  const Camera& camera_;
  const Pose& pose_;
  const RenderOptions& options_;
};

/// The item buffer of the faces that the camera looks at from in front.
visibility::Ivm draw_front_faces(const Mesh& mesh, const Camera& camera, const Pose& pose) {
  std::vector<std::uint8_t> is_front(mesh.faces.size());
  tbb::parallel_for(std::size_t{0}, mesh.faces.size(), [&](std::size_t f) {
    is_front[f] = facing(corners_of(mesh, FaceId{static_cast<std::uint32_t>(f)}, camera, pose)) > 0 ? 1 : 0;
  });
  Mesh front;
  front.positions = mesh.positions;
  std::vector<FaceId> original;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    if (is_front[f] == 0) continue;
    front.faces.push_back(mesh.faces[f]);
    original.push_back(FaceId{static_cast<std::uint32_t>(f)});
  }
  visibility::Ivm ivm = visibility::draw_item_buffer(front, camera, pose);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, ivm.faces.size()), [&](const auto& range) {
    for (std::size_t i = range.begin(); i != range.end(); ++i)
      if (ivm.faces[i] != kNoFace) ivm.faces[i] = original[gpvc::index(ivm.faces[i])];
  });
  return ivm;
}

}  // namespace

RenderResult render_model(const io::TexturedModel& model, const std::vector<Image>& pages, const Camera& camera,
                          const Pose& pose, const RenderOptions& options) {
  assert(model.mesh != nullptr && model.face_page.size() == model.mesh->faces.size());
  const visibility::Ivm ivm = options.cull_back_faces ? draw_front_faces(*model.mesh, camera, pose)
                                                      : visibility::draw_item_buffer(*model.mesh, camera, pose);
  RenderResult result;
  result.image = {ivm.width, ivm.height, 3, std::vector<std::uint8_t>(3 * ivm.faces.size())};
  result.textured.resize(ivm.faces.size());
  const Shader shader(model, pages, camera, pose, options);
  const auto width = static_cast<std::size_t>(ivm.width);
  tbb::parallel_for(0, ivm.height, [&](int y) {
    const std::size_t first = static_cast<std::size_t>(y) * width;
    shader.shade(y, std::span(ivm.faces).subspan(first, width), result.image.at(0, y), result.textured.data() + first);
  });
  return result;
}

}  // namespace gpvc::pipeline
