// Classifying one face after the other by testing its samples: the samples of front faces, the order in which they are
// looked at (dense or HIVERS), and the coverage of partial faces. Shared by gpvc and the methods it is compared with.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "visibility/classify/subpixel_positions.h"
#include "visibility/raster/prepared_view.h"

namespace gpvc::visibility {

/// True when all vertices are in front of the camera and in [0, W] x [0, H].
bool inside_frame(const Camera& camera, const RasterFace& face);

/// The runs of pixels in the walker's box whose centres the face covers. Exact where `exact`, else by edge values as
/// the shaders compute them.
void collect_spans(const RasterFace& face, const SpanWalker& walker, bool exact, std::vector<Span>& spans);

/// How find_samples() searches.
enum class SpanSearch {
  quick,    ///< for exact spans of faces that face or turn away; sets the raster only where the spans need it
  exact,    ///< for exact spans and the raster of front faces
  rounded,  ///< for the raster of front faces, and spans by edge values as the shaders compute them
};

/// A face and its samples in a view.
struct FaceSamples {
  FaceId face = kNoFace;
  SpanSearch search{};  ///< how the rest was found
  Facing facing = Facing::edge_on;
  RasterFace raster;
  std::vector<Span> spans;  ///< runs of samples; empty: no pixel centre of the frame, sub-pixel samples
  bool inside = false;      ///< inside_frame()
};

/// False when the face is edge-on or beside the frame, or is a back face that the search does not want. Fills `found`,
/// reusing its memory.
bool find_samples(const PreparedView& view, FaceId face, SpanSearch search, FaceSamples& found);

/// The order in which the spans of a face are tested against `sees(x, y)`, until one sample does not see the face.
/// Counts the samples that were looked at.
template <class Sees>
class SpanTest {
 public:
  SpanTest(const std::vector<Span>& spans, const Sees& sees, std::size_t& samples)
      : spans_(spans), sees_(sees), samples_(samples) {}

  bool sees_run(std::int32_t y, std::int32_t x0, std::int32_t x1) {
    for (std::int32_t x = x0; x < x1; ++x) {
      ++samples_;
      if (!sees_(x, y)) return false;
    }
    return true;
  }
  bool sees_all_dense() {
    return std::all_of(spans_.begin(), spans_.end(),
                       [&](const Span& span) { return sees_run(span.y, span.x0, span.x1); });
  }
  /// VVC and EVC on the ends of the rows and the whole of the first and the last row, then RVC on what lies between.
  /// Deviation from algorithm 2: a region is not cut into three at its barycentre but into blocks of rows, halved until
  /// one row is left. So every sample is read once and none needs to be marked; the conditions, and the class, are
  /// those of the paper.
  bool sees_all_hivers() {
    const Span &top = spans_.front(), &bottom = spans_.back();
    if (!sees_run(top.y, top.x0, top.x1)) return false;
    if (spans_.size() == 1) return true;
    if (!sees_run(bottom.y, bottom.x0, bottom.x1)) return false;
    for (std::size_t i = 1; i + 1 < spans_.size(); ++i) {
      const Span& span = spans_[i];
      if (!sees_run(span.y, span.x0, span.x0 + 1)) return false;
      if (span.x1 - span.x0 > 1 && !sees_run(span.y, span.x1 - 1, span.x1)) return false;
    }
    return sees_rows_between(1, spans_.size() - 1);
  }

 private:
  bool sees_rows_between(std::size_t first, std::size_t last) {
    if (first >= last) return true;
    const std::size_t middle = first + (last - first) / 2;
    const Span& span = spans_[middle];
    return sees_run(span.y, span.x0 + 1, span.x1 - 1) && sees_rows_between(first, middle) &&
           sees_rows_between(middle + 1, last);
  }

  const std::vector<Span>& spans_;
  const Sees& sees_;
  std::size_t& samples_;
};

/// Writes the coverage of one face behind the entries of a table: a bit for every sample that sees it.
class CoverageWriter {
 public:
  /// The entry's box is that of the face's spans.
  CoverageWriter(const PreparedView& view, const FaceSamples& front, CoverageTable& table);

  template <class SeesPixel>
  void add(const Span& span, const SeesPixel& sees) {
    const auto width = static_cast<std::size_t>(entry_.width);
    const std::size_t row = static_cast<std::size_t>(span.y - entry_.y0) * width;
    samples_ += static_cast<std::size_t>(span.x1 - span.x0);
    for (std::int32_t x = span.x0; x < span.x1; ++x) {
      if (!sees(x)) continue;
      const std::size_t bit = row + static_cast<std::size_t>(x - entry_.x0);
      table_.words[entry_.first_word + bit / 64] |= std::uint64_t{1} << (bit % 64);
      ++entry_.visible;
    }
  }
  /// The class of the face once all its spans were added; only a partial face keeps its entry.
  FaceClass finish();

 private:
  const PreparedView& view_;
  const FaceSamples& front_;
  CoverageTable& table_;
  FaceCoverage entry_;
  std::size_t samples_ = 0;
};

/// A coverage entry that has a share but no pixels.
void add_share(const PreparedView& view, FaceId face, std::uint32_t visible, std::uint32_t samples,
               CoverageTable& table);

/// The results of a block of consecutive faces.
struct FaceBlock {
  CoverageTable coverage;
  VisibilityStatistics counts;
  FaceSamples front;  ///< scratch

  /// Keeps the memory.
  void clear();
  /// The class of the front face when `sees(x, y)` says which of its samples see it: hidden when none does, full when
  /// all do and the face is inside the frame, else partial, with its coverage.
  template <class Sees>
  FaceClass cover(const PreparedView& view, const Sees& sees) {
    CoverageWriter writer(view, front, coverage);
    for (const Span& span : front.spans) writer.add(span, [&](std::int32_t x) { return sees(x, span.y); });
    return writer.finish();
  }
  /// The same class, found in the order of HIVERS; the samples looked at are counted until one does not see the face.
  /// A partial face is then covered, sample by sample.
  template <class Sees>
  FaceClass sample(const PreparedView& view, const Sees& sees) {
    const bool sees_all = front.inside && SpanTest<Sees>(front.spans, sees, counts.samples).sees_all_hivers();
    return sees_all ? FaceClass::full : cover(view, sees);
  }
  /// The class of a front face without pixel centre when `visible` of its sub-pixel samples see it.
  FaceClass cover_subpixel(const PreparedView& view, FaceId face, bool inside, std::uint32_t visible);
  /// Appends the coverage and adds the counts to the statistics.
  void append_to(ViewVisibility& result) const;
};

/// Faces in blocks of a fixed size, so that the result of a block does not depend on the number of threads.
class FaceBlocks {
 public:
  /// classes[f] = classify(FaceId, FaceBlock&) for every face; joins the counts and the coverage of the blocks.
  template <class Classify>
  void run(const PreparedView& view, ViewVisibility& result, const Classify& classify) {
    const std::size_t faces = view.mesh.faces.size();
    result.classes.resize(faces);
    blocks_.resize(block_count(faces));
    for_each_block(faces, [&](std::size_t number, std::size_t first, std::size_t end) {
      FaceBlock& block = blocks_[number];
      block.clear();
      for (std::size_t f = first; f < end; ++f) {
        result.classes[f] = classify(FaceId{static_cast<std::uint32_t>(f)}, block);
        block.counts.full += result.classes[f] == FaceClass::full;
      }
    });
    result.coverage.entries.clear();
    result.coverage.words.clear();
    for (const FaceBlock& block : blocks_) block.append_to(result);
  }
  /// The same from the samples of front faces: `sees(x, y, inverse_depth)` tells whether the point of the surface at a
  /// pixel centre in the photo is visible, `visible(face)` how many of the sub-pixel samples are.
  template <class Sees, class Visible>
  void run_samples(const PreparedView& view, bool subpixel, ViewVisibility& result, const Sees& sees,
                   const Visible& visible) {
    run(view, result, [&](FaceId face, FaceBlock& block) {
      const FaceSamples& front = block.front;
      if (!find_samples(view, face, SpanSearch::exact, block.front)) return FaceClass::hidden;
      if (front.spans.empty() && !subpixel) return FaceClass::unresolved;
      ++block.counts.processed_faces;
      if (front.spans.empty()) {
        block.counts.samples += kSubpixelSamples;
        return block.cover_subpixel(view, face, front.inside, visible(face));
      }
      const Span& top = front.spans.front();
      const InverseDepth depth = inverse_depth_from(front.raster, top.x0 + 0.5, top.y + 0.5);
      const auto sees_bare = [&](std::int32_t x, std::int32_t y) { return sees(x, y, depth.at(x + 0.5, y + 0.5)); };
      if (view.mask.whole()) return block.sample(view, sees_bare);
      return block.sample(view,
                          [&](std::int32_t x, std::int32_t y) { return view.mask.contains(x, y) && sees_bare(x, y); });
    });
  }

 private:
  std::vector<FaceBlock> blocks_;
};

}  // namespace gpvc::visibility
