// The initial visibility map drawn on the CPU instead of by OpenGL. It knows for every pixel whether its owner is
// certain, so most faces are classified once it is drawn.
#pragma once

#include <tbb/enumerable_thread_specific.h>

#include <span>
#include <vector>

#include "visibility/classify/exact_scan.h"
#include "visibility/native/ivm_tile.h"
#include "visibility/raster/tile_lists.h"

namespace gpvc::visibility {

/// Scratch memory that views share. Results do not depend on what was drawn before.
class CpuIvm {
 public:
  /// Draws all faces, front and back, into the row-major item buffer that the view borrows; kNoFace where nothing is
  /// and outside the photo. Where the real owner of a pixel differs from the stored one it is among the scan's claims,
  /// or its face is unsure; decide_unsure_exactly() decides both. O(vertices + faces + pixels that the faces cover + 64 x
  /// tiles), TBB; the same bits for any number of threads, except for claims that turn out to be wrong.
  /// \param doubled  Repeats::doubled of the mesh; faces of these that turn their back are left out
  /// \param beside  see FaceHulls::find_beside(); or empty
  void draw(const PreparedView& view, std::span<const std::uint8_t> doubled, std::span<const std::uint8_t> beside,
            std::span<FaceId> ivm, FaceScan& scan);

 private:
  void list_faces(const PreparedView& view, std::span<const std::uint8_t> doubled, std::span<const std::uint8_t> beside,
                  FaceScan& scan);
  std::uint8_t list_face(const PreparedView& view, FaceId face, const FaceBounds& bounds, TileLists::Part& lists,
                         std::vector<FaceId>& unlisted) const;
  void draw_tiles(const PreparedView& view, std::span<FaceId> ivm, FaceScan& scan);
  void derive_face_codes(FaceScan& scan) const;

  TileGrid grid_;
  TileLists lists_;
  std::vector<std::vector<FaceId>> unlisted_parts_;
  std::vector<FaceId> unlisted_;  ///< faces that touch too many tiles to be listed
  DrawnFaces drawn_;
  tbb::enumerable_thread_specific<IvmTile> tiles_;
};

}  // namespace gpvc::visibility
