#include "visibility/native/ivm_cpu.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>

#include "visibility/classify/front_faces.h"

namespace gpvc::visibility {
namespace {

/// A face that touches more tiles than this, four megapixels, is drawn into every tile instead of being listed; there
/// are few.
constexpr std::int64_t kMostTiles = 256;

/// The box around the pixels that a face across the camera plane covers; empty when there are none.
PixelBox covered_box(const PreparedView& view, FaceId face) {
  const RasterFace raster = view.raster(face);
  if (raster.facing == Facing::edge_on) return {};
  const SpanWalker walker(raster, pixel_bounds(raster, view.frame()));
  std::vector<Span> spans;
  collect_spans(raster, walker, true, spans);
  if (spans.empty()) return {};
  PixelBox box{spans[0].x0, spans.front().y, spans[0].x1, spans.back().y + 1};
  for (const Span& span : spans) {
    box.x0 = std::min(box.x0, span.x0);
    box.x1 = std::max(box.x1, span.x1);
  }
  return box;
}

/// \pre all tiles of the face were drawn
FaceCode code_of(std::uint8_t marks) {
  if ((marks & kMarkUnsure) != 0) return FaceCode::unsure;
  if ((marks & kMarkFront) == 0) return FaceCode::hidden;
  // kMarkInside missing: the face may leave the frame, and ExactScan decides.
  if ((marks & kMarkInside) == 0) return FaceCode::unsure;
  if ((marks & kMarkSampled) == 0) return FaceCode::no_centre;
  if ((marks & kMarkLost) == 0) return FaceCode::full;
  return (marks & kMarkStored) != 0 ? FaceCode::partial : FaceCode::unstored;
}

}  // namespace

void CpuIvm::draw(const PreparedView& view, std::span<const std::uint8_t> doubled, std::span<const std::uint8_t> beside,
                  std::span<FaceId> ivm, FaceScan& scan) {
  const std::size_t faces = view.mesh.faces.size();
  grid_ = TileGrid(view.frame(), IvmTile::kShift);
  drawn_.start(faces);
  scan.start(faces);
  list_faces(view, doubled, beside, scan);
  draw_tiles(view, ivm, scan);
  derive_face_codes(scan);
}

void CpuIvm::list_faces(const PreparedView& view, std::span<const std::uint8_t> doubled,
                        std::span<const std::uint8_t> beside, FaceScan& scan) {
  const std::size_t faces = view.mesh.faces.size();
  const std::size_t rectangles = (faces + kFacesPerRectangle - 1) / kFacesPerRectangle;
  const std::size_t per_part = (rectangles + kListParts - 1) / kListParts;
  scan.touched.resize(rectangles);
  lists_.start(kListParts, grid_.count());
  unlisted_parts_.resize(kListParts);
  tbb::parallel_for(std::size_t{0}, kListParts, [&](std::size_t part) {
    TileLists::Part& lists = lists_.part(part);
    std::vector<FaceId>& unlisted = unlisted_parts_[part];
    unlisted.clear();
    for (std::size_t r = part * per_part; r < std::min((part + 1) * per_part, rectangles); ++r) {
      FaceBounds touched;
      const std::size_t first = r * kFacesPerRectangle, end = std::min(first + kFacesPerRectangle, faces);
      for (std::size_t f = first; f < end; ++f) drawn_.marks[f] = 0;
      for (std::size_t f = first; f < end; ++f) drawn_.samples[f] = 0;
      for (std::size_t f = first; f < end && (beside.empty() || beside[r] == 0); ++f) {
        const FaceId face{static_cast<std::uint32_t>(f)};
        const FaceBounds bounds = view.bounds(face);
        if (outside(bounds, view.camera.width, view.camera.height)) continue;
        if (!doubled.empty() && doubled[f] != 0 && view.quick(face, bounds).facing() == Facing::back) continue;
        touched = united(touched, bounds);
        drawn_.marks[f] = list_face(view, face, bounds, lists, unlisted);
      }
      scan.touched[r] = touched_pixels(touched, view.frame());
    }
  });
  lists_.sort();
  unlisted_.clear();
  for (const std::vector<FaceId>& unlisted : unlisted_parts_)
    unlisted_.insert(unlisted_.end(), unlisted.begin(), unlisted.end());
}

/// Lists the face in the tiles that it may touch. Returns its marks: those of a face that touches no tile are final.
std::uint8_t CpuIvm::list_face(const PreparedView& view, FaceId face, const FaceBounds& bounds, TileLists::Part& lists,
                               std::vector<FaceId>& unlisted) const {
  const PixelBox box = bounds.bounded ? pixel_centres(bounds, view.frame()) : covered_box(view, face);
  const std::int64_t tiles = grid_.touched(box);
  if (tiles == 0) {
    const QuickFace quick = view.quick(face, bounds);
    if (quick.facing() == Facing::edge_on) return kMarkUnsure;
    return static_cast<std::uint8_t>((quick.facing() == Facing::front ? kMarkFront : 0) |
                                     (view.limits.inside_frame(bounds) ? kMarkInside : 0));
  }
  if (tiles > kMostTiles) {
    unlisted.push_back(face);
    return 0;
  }
  const QuickFace quick = tiles > 4 ? view.quick(face, bounds) : QuickFace();
  std::uint8_t marks = kMarkUnsure;
  grid_.for_each(box, quick, [&](std::size_t tile) {
    lists.add(tile, face);
    marks = 0;
  });
  return marks;
}

void CpuIvm::draw_tiles(const PreparedView& view, std::span<FaceId> ivm, FaceScan& scan) {
  for (IvmTile& tile : tiles_) tile.start_view();
  tbb::parallel_for(std::size_t{0}, grid_.count(), [&](std::size_t number) {
    tiles_.local().draw(view, grid_.pixels(number), lists_.of(number), unlisted_, ivm, drawn_);
  });
  scan.rough_pixels.emplace();
  for (const IvmTile& tile : tiles_) {
    scan.rough_pixels->insert(scan.rough_pixels->end(), tile.rough_pixels().begin(), tile.rough_pixels().end());
    scan.claims.insert(scan.claims.end(), tile.doubts().begin(), tile.doubts().end());
    scan.counts.contested_samples += tile.hidden_samples();
  }
}

void CpuIvm::derive_face_codes(FaceScan& scan) const {
  tbb::enumerable_thread_specific<VisibilityStatistics> counts;
  for_each_block(scan.codes.size(), [&](std::size_t, std::size_t first, std::size_t end) {
    VisibilityStatistics& sum = counts.local();
    for (std::size_t f = first; f < end; ++f) {
      scan.codes[f] = code_of(drawn_.marks[f]);
      if (scan.codes[f] != FaceCode::full) continue;
      ++sum.processed_faces;
      sum.samples += drawn_.samples[f];
    }
  });
  for (const VisibilityStatistics& sum : counts) scan.counts += sum;
}

}  // namespace gpvc::visibility
