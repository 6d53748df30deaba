// Bytes of what the stages of a run hold, as sums over its structures: what memory is planned with. What the sums leave out
// (the allocator's losses, threads' scratch) is one factor a stage, fitted to the peaks of eleven runs: facades, UAV blocks, table
// tops and synthetic cities of 40 thousand to 10 million faces and 20 to 300 megapixels, on two threads.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "../../io/scene.h"
#include "../../labeling/face_record.h"
#include "memory.h"

namespace gpvc::pipeline::held {

inline constexpr double kProgram = 150e6;  ///< with its libraries

// Of a face, a vertex, a pixel, a face that a view sees ("pair").
inline constexpr double kVertex = sizeof(WorldPoint), kFace = sizeof(Triangle), kIndex = sizeof(std::uint32_t);
/// A face of a closed mesh has one and a half pairs of neighbours; they are sorted from one array into another.
inline constexpr double kNeighbours = 2 * 1.5 * sizeof(std::array<std::uint32_t, 2>);
inline constexpr double kRecord = sizeof(labeling::FaceRecord), kCandidate = sizeof(std::uint32_t) + sizeof(float);
inline constexpr double kPhotoPixel = 3, kOwnerPixel = sizeof(FaceId);
/// A vertex as a view is drawn: in the camera's axes and in pixels.
inline constexpr double kDrawnVertex = sizeof(CameraPoint) + sizeof(PixelPoint);
/// A face while its view's statistics are summed: shape, sums of colours and gradients, and where they are.
inline constexpr double kSummedFace = 100;
/// Two photos at a time are decoded. Where they have bands, each has its samples while only the picture is wanted, and its file in memory
/// (PNG, EXR), or one band's file decoded beside them; most TIFFs take less.
inline double decoding_pixel(const Workload& work) { return 2 * work.sample_bytes; }
/// Two views are in work: each has item buffer and photo, and one more photo is decoded. The factor is for the strip along
/// silhouettes and the depths that are drawn.
inline double seen_pixel(const Workload& work) {
  return 1.53 * (2 * kOwnerPixel + 3 * kPhotoPixel) + 2 * decoding_pixel(work);
}
/// Where background is looked for: some 62 bytes for a square of 4 x 4 pixels, and two bits a pixel.
inline constexpr double kBackgroundPixel = 62.0 / 16 + 0.25;

inline double mesh(const Workload& work) { return kVertex * work.vertices + kFace * work.faces; }

/// Previews of the photos that are compared, one byte a pixel: see checks::SmallPhoto.
inline double previews(const Workload& work) {
  constexpr double kMostCompared = 96;
  const double reduction = std::max(1.0, std::floor(std::sqrt(4.0 / 3 * work.most_pixels) / 1000));
  return std::min(work.views, kMostCompared) * work.most_pixels / (reduction * reduction);
}

/// The program, the mesh and its graph of faces: in all stages but writing.
inline double run_of(const Workload& work) { return kProgram + mesh(work) + kNeighbours * work.faces; }

/// Beside what is known of views, while they are compared.
inline double while_judging(const Workload& work) { return run_of(work) + previews(work); }

/// While a view is looked at, beside the mesh.
inline double view(const Workload& work) {
  return (seen_pixel(work) + kBackgroundPixel) * work.most_pixels + kDrawnVertex * work.vertices +
         kSummedFace * work.pairs / std::max(work.views, 1.0);
}

}  // namespace gpvc::pipeline::held
