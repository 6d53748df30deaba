#include "visibility/classify.h"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>

#include "visibility/face_sampler.h"

namespace gpvc {
namespace {

constexpr std::size_t kFacesPerBlock = 2048;

}  // namespace

/// What one block of consecutive faces yields; joined in face order at the end.
struct CpuClassifier::Block {
  CoverageTable coverage;
  SampleCounts counts;
  std::size_t full = 0;

  void clear() {
    coverage.entries.clear();
    coverage.words.clear();
    counts = {};
    full = 0;
  }
};

CpuClassifier::CpuClassifier(const VisibilityOptions& options) : options_(options) {}
CpuClassifier::~CpuClassifier() = default;

void CpuClassifier::find_candidates(const ClassifyView& view) {
  candidate_faces_.assign(view.mesh.faces.size(), 0);
  const auto width = static_cast<std::size_t>(view.camera.width);
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, static_cast<std::size_t>(view.camera.height), 16),
      [&](const tbb::blocked_range<std::size_t>& rows) {
        FaceId last = kNoFace;
        for (const FaceId face : view.ivm.subspan(rows.begin() * width, rows.size() * width)) {
          if (face == last) continue;
          last = face;
          if (face == kNoFace) continue;
          std::atomic_ref<std::uint8_t>(candidate_faces_[index(face)]).store(1, std::memory_order_relaxed);
        }
      });
}

void CpuClassifier::classify_block(const ClassifyView& view, std::size_t number, ViewVisibility& result) {
  static thread_local FaceSampler::Scratch scratch;
  Block& block = blocks_[number];
  block.clear();
  FaceSampler sampler(view, options_, scratch, block.coverage, block.counts);
  const std::size_t first = number * kFacesPerBlock;
  const std::size_t last = std::min(first + kFacesPerBlock, view.mesh.faces.size());
  for (std::size_t f = first; f < last; ++f) {
    const FaceId face{static_cast<std::uint32_t>(f)};
    const FaceClass found = sampler.classify(face, candidate_faces_[f] != 0);
    result.classes[f] = found;
    block.full += found == FaceClass::full;
  }
}

void CpuClassifier::classify(const ClassifyView& view, ViewVisibility& result) {
  result.classes.resize(view.mesh.faces.size());
  find_candidates(view);
  blocks_.resize((view.mesh.faces.size() + kFacesPerBlock - 1) / kFacesPerBlock);
  tbb::parallel_for(std::size_t{0}, blocks_.size(),
                    [&](std::size_t number) { classify_block(view, number, result); });
  result.coverage.entries.clear();
  result.coverage.words.clear();
  for (const Block& block : blocks_) {
    const std::size_t words = result.coverage.words.size();
    for (FaceCoverage entry : block.coverage.entries) {
      entry.first_word += words;
      result.coverage.entries.push_back(entry);
    }
    result.coverage.words.insert(result.coverage.words.end(), block.coverage.words.begin(),
                                 block.coverage.words.end());
    result.statistics.processed_faces += block.counts.processed_faces;
    result.statistics.samples += block.counts.samples;
    result.statistics.corrected_samples += block.counts.corrected_samples;
    result.statistics.full += block.full;
    result.statistics.partial += block.coverage.entries.size();
  }
}

}  // namespace gpvc
