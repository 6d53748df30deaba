#include "visibility/native/ivm_cpu.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>

#include "visibility/classify/face_sampler.h"

namespace gpvc::visibility {
namespace {

/// Faces of more tiles than this, four megapixels, are few.
constexpr std::int64_t kVast = 256;

/// The pixels that an unbounded face covers: none where there are none.
PixelBox covered_box(const ClassifyView& view, FaceId face) {
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

/// \pre a face all of whose tiles were drawn, or one that has none.
FaceCode code_of(std::uint8_t marks) {
  if ((marks & kMarkUnsure) != 0) return FaceCode::unsure;
  if ((marks & kMarkFront) == 0) return FaceCode::hidden;
  // A face that may leave the frame is decided by ExactScan.
  if ((marks & kMarkInside) == 0) return FaceCode::unsure;
  if ((marks & kMarkSampled) == 0) return FaceCode::no_centre;
  if ((marks & kMarkLost) == 0) return FaceCode::full;
  return (marks & kMarkStored) != 0 ? FaceCode::partial : FaceCode::unstored;
}

}  // namespace

void CpuIvm::draw(const ClassifyView& view, std::span<FaceId> ivm, FaceScan& scan) {
  const std::size_t faces = view.mesh.faces.size();
  limits_ = view.quick_limits();
  grid_ = TileGrid(view.frame(), IvmTile::kShift);
  drawn_.start(faces);
  scan.start(faces);
  list_faces(view, scan);
  draw_tiles(view, ivm, scan);
  tell_codes(scan);
}

void CpuIvm::list_faces(const ClassifyView& view, FaceScan& scan) {
  const std::size_t faces = view.mesh.faces.size();
  const std::size_t rectangles = (faces + kFacesPerRectangle - 1) / kFacesPerRectangle;
  const std::size_t per_part = (rectangles + kListParts - 1) / kListParts;
  scan.touched.resize(rectangles);
  lists_.start(kListParts, grid_.count());
  vast_parts_.resize(kListParts);
  tbb::parallel_for(std::size_t{0}, kListParts, [&](std::size_t part) {
    TileLists::Part& lists = lists_.part(part);
    std::vector<FaceId>& vast = vast_parts_[part];
    vast.clear();
    for (std::size_t r = part * per_part; r < std::min((part + 1) * per_part, rectangles); ++r) {
      FaceBounds touched;
      for (std::size_t f = r * kFacesPerRectangle; f < std::min((r + 1) * kFacesPerRectangle, faces); ++f) {
        const FaceId face{static_cast<std::uint32_t>(f)};
        const FaceBounds bounds = view.bounds(face);
        drawn_.marks[f] = 0;
        drawn_.samples[f] = 0;
        if (outside(bounds, view.camera.width, view.camera.height)) continue;
        touched = united(touched, bounds);
        drawn_.marks[f] = list_face(view, face, bounds, lists, vast);
      }
      scan.touched[r] = touched_pixels(touched, view.frame());
    }
  });
  lists_.sort();
  vast_.clear();
  for (const std::vector<FaceId>& vast : vast_parts_) vast_.insert(vast_.end(), vast.begin(), vast.end());
}

/// What is known of the face, when no tile will tell.
std::uint8_t CpuIvm::list_face(const ClassifyView& view, FaceId face, const FaceBounds& bounds, TileLists::Part& lists,
                               std::vector<FaceId>& vast) const {
  const PixelBox box = bounds.bounded ? pixel_centres(bounds, view.frame()) : covered_box(view, face);
  const std::int64_t tiles = grid_.touched(box);
  if (tiles == 0) {
    const QuickFace quick = view.quick(limits_, face, bounds);
    if (quick.facing() == Facing::edge_on) return kMarkUnsure;
    return static_cast<std::uint8_t>((quick.facing() == Facing::front ? kMarkFront : 0) |
                                     (limits_.inside(bounds) ? kMarkInside : 0));
  }
  if (tiles > kVast) {
    vast.push_back(face);
    return 0;
  }
  const QuickFace quick = tiles > 4 ? view.quick(limits_, face, bounds) : QuickFace();
  std::uint8_t marks = kMarkUnsure;
  grid_.for_each(box, quick, [&](std::size_t tile) {
    lists.add(tile, face);
    marks = 0;
  });
  return marks;
}

void CpuIvm::draw_tiles(const ClassifyView& view, std::span<FaceId> ivm, FaceScan& scan) {
  for (IvmTile& tile : tiles_) tile.start_view();
  tbb::parallel_for(std::size_t{0}, grid_.count(), [&](std::size_t number) {
    tiles_.local().draw(view, limits_, grid_.pixels(number), lists_.of(number), vast_, ivm, drawn_);
  });
  for (const IvmTile& tile : tiles_) {
    scan.claims.insert(scan.claims.end(), tile.doubts().begin(), tile.doubts().end());
    scan.counts.contested_samples += tile.hidden_samples();
  }
}

void CpuIvm::tell_codes(FaceScan& scan) const {
  tbb::enumerable_thread_specific<SampleCounts> counts;
  for_each_block(scan.codes.size(), [&](std::size_t, std::size_t first, std::size_t end) {
    SampleCounts& sum = counts.local();
    for (std::size_t f = first; f < end; ++f) {
      scan.codes[f] = code_of(drawn_.marks[f]);
      if (scan.codes[f] != FaceCode::full) continue;
      ++sum.processed_faces;
      sum.samples += drawn_.samples[f];
    }
  });
  for (const SampleCounts& sum : counts) scan.counts += sum;
}

}  // namespace gpvc::visibility
