// The initial visibility map drawn on the CPU: the twin of IvmRenderer where OpenGL would run there as well. It knows
// of every pixel whether its owner is certain, so that most faces are classified once it is drawn.
#pragma once

#include <tbb/enumerable_thread_specific.h>

#include <span>
#include <vector>

#include "visibility/classify/classify.h"
#include "visibility/classify/exact_scan.h"
#include "visibility/native/ivm_tile.h"
#include "visibility/raster/tile_lists.h"

namespace gpvc::visibility {

/// Scratch memory that views share. Results do not depend on what was drawn before.
class CpuIvm {
 public:
  /// Draws all faces, front and back, into the item buffer that the view borrows, row-major; kNoFace where nothing is
  /// and outside the photo. Where the real owner differs from the stored one it is among the scan's claims, or its face
  /// is unsure; both are to be settled: ExactScan::settle(). O(vertices + faces + pixels that the faces cover + 64 x
  /// tiles), TBB; the same bits for any number of threads, but for the claims that turn out to be wrong.
  void draw(const ClassifyView& view, std::span<FaceId> ivm, FaceScan& scan);

 private:
  void list_faces(const ClassifyView& view, FaceScan& scan);
  std::uint8_t list_face(const ClassifyView& view, FaceId face, const FaceBounds& bounds, TileLists::Part& lists,
                         std::vector<FaceId>& vast) const;
  void draw_tiles(const ClassifyView& view, std::span<FaceId> ivm, FaceScan& scan);
  void tell_codes(FaceScan& scan) const;

  QuickLimits limits_;
  TileGrid grid_;
  TileLists lists_;
  std::vector<std::vector<FaceId>> vast_parts_;
  std::vector<FaceId> vast_;  ///< faces of so many tiles that they are not listed
  DrawnFaces drawn_;
  tbb::enumerable_thread_specific<IvmTile> tiles_;
};

}  // namespace gpvc::visibility
