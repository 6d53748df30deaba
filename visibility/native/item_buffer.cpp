// The item buffer of a view, drawn natively.
#include "visibility/item_buffer.h"

#include <cassert>
#include <limits>

#include "visibility/native/ivm_cpu.h"
#include "visibility/raster/copies.h"

namespace gpvc::visibility {

Ivm draw_item_buffer(const Mesh& mesh, const Camera& camera, const Pose& pose) {
  Camera pinhole = camera;
  pinhole.distortion = {};
  const auto pixels = static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
  assert(camera.width > 0 && camera.height > 0 && pixels <= std::numeric_limits<std::uint32_t>::max());
  Ivm ivm{camera.width, camera.height, std::vector<FaceId>(pixels)};
  const Repeats repeats = find_repeats(mesh);
  const Mesh& drawn = repeats.collapsed ? *repeats.collapsed : mesh;
  ProjectedMesh projected;
  project_vertices(drawn, pinhole, pose, projected);
  const PhotoMask whole(pinhole);
  FaceScan scan;
  CpuIvm().draw({drawn, pinhole, ViewId{}, whole, projected, ivm.faces}, repeats.doubled, {}, ivm.faces, scan);
  return ivm;
}

}  // namespace gpvc::visibility
