// What the methods that test samples one by one share: the samples of the front faces of a view, and the coverage of
// the partial ones.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "visibility/classify/classify.h"
#include "visibility/classify/face_sampler.h"
#include "visibility/classify/subpixel.h"

namespace gpvc::visibility {

/// A front face before a view.
struct FrontFace {
  FaceId face = kNoFace;
  RasterFace raster;
  std::vector<Span> spans;  ///< runs of samples on the frame; empty: no pixel centre, sub-pixel samples
  bool inside = false;      ///< all vertices in front of the camera and in [0, W] x [0, H]
};

/// Whether the face faces the camera and has a sample on the frame. Fills `found`, whose memory is used again.
bool find_front_face(const ClassifyView& view, FaceId face, FrontFace& found);

/// 1 / z of a face's plane at pixel centres, which is linear over the image: with e the edge values of a centre, z =
/// (sum of e z) / (sum of e), and the numerator is the same everywhere.
struct InverseDepth {
  InverseDepth(const RasterFace& raster, const Span& near);
  double at(std::int32_t x, std::int32_t y) const { return first_ + per_x_ * (x - x0_) + per_y_ * (y - y0_); }

 private:
  std::int32_t x0_, y0_;
  double first_, per_x_, per_y_;
};

/// Where the sub-pixel samples of a face lie: the centroid last, the midpoints from it to the vertices first.
struct SubpixelSample {
  double x = 0, y = 0, z = 0;
  bool in_image = false;
};
std::array<SubpixelSample, kSubpixelSamples> subpixel_samples(const ClassifyView& view, const RasterFace& raster);

/// Faces in blocks of a fixed size, so that what a block yields does not depend on the number of threads.
struct FaceBlock : BlockYield {
  FrontFace front;  ///< scratch

  /// The class of the front face when `sees(x, y)` says which of its samples see it: hidden when none, full when all
  /// and the face is inside, else partial, with its coverage.
  template <class Sees>
  FaceClass cover(const ClassifyView& view, const Sees& sees);
  /// The same class, found as HIVERS finds it: ends of the rows first, until a sample does not see the face; those
  /// looked at are counted. What is partial is then covered, sample by sample.
  template <class Sees>
  FaceClass sample(const ClassifyView& view, const Sees& sees);
  /// Likewise without pixel centre, `visible` of the sub-pixel samples seeing it.
  FaceClass cover_subpixel(const ClassifyView& view, std::uint32_t visible);

 private:
  template <class Sees>
  bool sees_run(const Sees& sees, std::int32_t y, std::int32_t x0, std::int32_t x1);
  template <class Sees>
  bool sees_all(const Sees& sees);
  template <class Sees>
  bool sees_rows_between(const Sees& sees, std::size_t first, std::size_t last);
  FaceCoverage empty_entry(const ClassifyView& view);
  FaceClass finish(const ClassifyView& view, FaceCoverage entry);
};

class FaceBlocks {
 public:
  /// classes[f] = classify(FaceId, FaceBlock&) for every face; joins what the blocks counted and covered.
  template <class Classify>
  void run(const ClassifyView& view, ViewVisibility& result, const Classify& classify) {
    const std::size_t faces = view.mesh.faces.size();
    result.classes.resize(faces);
    blocks_.resize(block_count(faces));
    for_each_block(faces, [&](std::size_t number, std::size_t first, std::size_t end) {
      FaceBlock& block = blocks_[number];
      block.clear();
      for (std::size_t f = first; f < end; ++f) {
        result.classes[f] = classify(FaceId{static_cast<std::uint32_t>(f)}, block);
        block.full += result.classes[f] == FaceClass::full;
      }
    });
    join(blocks_, result);
  }

 private:
  std::vector<FaceBlock> blocks_;
};

template <class Sees>
FaceClass FaceBlock::cover(const ClassifyView& view, const Sees& sees) {
  FaceCoverage entry = empty_entry(view);
  const auto width = static_cast<std::size_t>(entry.width);
  for (const Span& span : front.spans)
    for (std::int32_t x = span.x0; x < span.x1; ++x) {
      if (!sees(x, span.y)) continue;
      const std::size_t bit =
          static_cast<std::size_t>(span.y - entry.y0) * width + static_cast<std::size_t>(x - entry.x0);
      coverage.words[entry.first_word + bit / 64] |= std::uint64_t{1} << (bit % 64);
      ++entry.visible;
    }
  return finish(view, entry);
}

template <class Sees>
FaceClass FaceBlock::sample(const ClassifyView& view, const Sees& sees) {
  return front.inside && sees_all(sees) ? FaceClass::full : cover(view, sees);
}

template <class Sees>
bool FaceBlock::sees_run(const Sees& sees, std::int32_t y, std::int32_t x0, std::int32_t x1) {
  for (std::int32_t x = x0; x < x1; ++x) {
    ++counts.samples;
    if (!sees(x, y)) return false;
  }
  return true;
}

template <class Sees>
bool FaceBlock::sees_all(const Sees& sees) {
  const std::vector<Span>& spans = front.spans;
  const Span &top = spans.front(), &bottom = spans.back();
  if (!sees_run(sees, top.y, top.x0, top.x1)) return false;
  if (spans.size() == 1) return true;
  if (!sees_run(sees, bottom.y, bottom.x0, bottom.x1)) return false;
  for (std::size_t i = 1; i + 1 < spans.size(); ++i) {
    const Span& span = spans[i];
    if (!sees_run(sees, span.y, span.x0, span.x0 + 1)) return false;
    if (span.x1 - span.x0 > 1 && !sees_run(sees, span.y, span.x1 - 1, span.x1)) return false;
  }
  return sees_rows_between(sees, 1, spans.size() - 1);
}

template <class Sees>
bool FaceBlock::sees_rows_between(const Sees& sees, std::size_t first, std::size_t last) {
  if (first >= last) return true;
  const std::size_t middle = first + (last - first) / 2;
  const Span& span = front.spans[middle];
  return sees_run(sees, span.y, span.x0 + 1, span.x1 - 1) && sees_rows_between(sees, first, middle) &&
         sees_rows_between(sees, middle + 1, last);
}

}  // namespace gpvc::visibility
