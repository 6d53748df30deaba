// One view, ready to be classified: the mesh with its vertices projected, the photo mask and the item buffer.
#pragma once

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include "visibility/raster/photo_mask.h"
#include "visibility/raster/projection.h"
#include "visibility/raster/quick_face.h"
#include "visibility/raster/raster.h"
#include "visibility/result.h"

namespace gpvc::visibility {

struct DepthRange {
  double nearest = 0, farthest = 0;
};

/// Everything is borrowed.
struct PreparedView {
  PreparedView(const Mesh& of_mesh, const Camera& of_camera, ViewId view, const PhotoMask& photo_mask,
               const ProjectedMesh& projected_mesh, std::span<const FaceId> item_buffer)
      : mesh(of_mesh),
        camera(of_camera),
        id(view),
        mask(photo_mask),
        projected(projected_mesh),
        ivm(item_buffer),
        rounding(projection_rounding(of_camera)),
        limits(of_camera.width, of_camera.height, rounding, projected_mesh.moderate) {}

  const Mesh& mesh;
  const Camera& camera;
  ViewId id;
  const PhotoMask& mask;
  const ProjectedMesh& projected;
  std::span<const FaceId> ivm;  ///< row-major; pixels outside the photo hold kNoFace
  ProjectionRounding rounding;
  QuickLimits limits;

  PixelBox frame() const { return {0, 0, camera.width, camera.height}; }
  std::size_t pixel_index(std::int32_t x, std::int32_t y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(camera.width) + static_cast<std::size_t>(x);
  }
  FaceId owner(std::int32_t x, std::int32_t y) const { return ivm[pixel_index(x, y)]; }
  const FaceId* row(std::int32_t y) const { return ivm.data() + pixel_index(0, y); }
  /// True when a subpixel position is on the frame and, once distorted, in the photo. False for NaN.
  bool in_image(double x, double y) const {
    return x >= 0 && y >= 0 && x <= camera.width && y <= camera.height && mask.contains(PixelPoint{x, y});
  }

  RasterFace raster(FaceId face) const {
    const auto [a, b, c] = corners(projected.vertices, face);
    return raster_face(a, b, c, rounding);
  }
  FaceBounds bounds(FaceId face) const {
    const auto [a, b, c] = corners(projected.positions, face);
    FaceBounds bounds = face_bounds(a, b, c);
    // Most faces that cross the camera plane miss the frame.
    if (bounds.ahead && !bounds.bounded) bounds.ahead = !misses_frame(camera, corners(projected.vertices, face));
    return bounds;
  }
  QuickFace quick(FaceId face, const FaceBounds& of_face) const {
    const auto [a, b, c] = corners(projected.positions, face);
    return {limits, a, b, c, of_face};
  }
  InverseDepth inverse_depth(const QuickFace& quick, FaceId face) const {
    const auto [a, b, c] = corners(projected.positions, face);
    return quick.inverse_depth(a.per_z, b.per_z, c.per_z);
  }
  /// The rounded inverse depths of its nearest and its farthest vertex: the greatest and the least.
  DepthRange inverse_depths(FaceId face) const {
    const auto [a, b, c] = corners(projected.positions, face);
    return {std::max({a.per_z, b.per_z, c.per_z}), std::min({a.per_z, b.per_z, c.per_z})};
  }
  /// The least and the greatest depth of its vertices.
  DepthRange depths(FaceId face) const {
    const auto [a, b, c] = corners(projected.vertices, face);
    return {std::min({a.z, b.z, c.z}), std::max({a.z, b.z, c.z})};
  }

 private:
  template <class Vertex>
  std::array<Vertex, 3> corners(const std::vector<Vertex>& vertices, FaceId face) const {
    const Triangle& t = mesh.faces[index(face)];
    return {vertices[t[0]], vertices[t[1]], vertices[t[2]]};
  }
};

/// Faces in blocks of a fixed size, so that the result of a block does not depend on the number of threads.
inline constexpr std::size_t kFacesPerBlock = 2048;
inline std::size_t block_count(std::size_t items) { return (items + kFacesPerBlock - 1) / kFacesPerBlock; }
/// Calls block(number, first, end) for each block of items first .. end - 1. TBB.
template <class Callback>
void for_each_block(std::size_t items, const Callback& block) {
  tbb::parallel_for(std::size_t{0}, block_count(items), [&](std::size_t number) {
    const std::size_t first = number * kFacesPerBlock;
    block(number, first, std::min(first + kFacesPerBlock, items));
  });
}

}  // namespace gpvc::visibility
