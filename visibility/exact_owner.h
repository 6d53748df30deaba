// Coverage correction `exact`: the IVM proposes an owner for every pixel, and every face that covers a pixel
// centre contests it.
//
// A face covering the centre of pixel p claims p when the stored owner does not cover the centre, or lies
// behind the face there (the higher index on a tie); both decided exactly. If the stored owner is right,
// nobody claims. If it is wrong, the right one does: it covers the centre, and it lies in front of the stored
// owner unless that one does not cover the centre at all. So the nearest of the claimants is the owner, and
// nothing is assumed about the rasterizer: neither its snapping nor its depth buffer needs an error bound.
#pragma once

#include <cstdint>
#include <vector>

#include "visibility/classify.h"
#include "visibility/exact.h"

namespace gpvc {

struct Claim {
  std::uint32_t pixel;  ///< y * width + x
  FaceId face;
};

/// Contests stored owners, remembering the last few of them; one a thread.
class OwnerContest {
 public:
  /// Forgets the view before.
  void start();
  /// Whether `face`, which covers pixel (x, y), beats its stored owner there.
  bool wins(const ClassifyView& view, FaceId face, const RasterFace& raster, std::int32_t x, std::int32_t y);

 private:
  struct Owner {
    FaceId face = kNoFace;
    RasterFace raster;
  };
  std::array<Owner, 16> owners_;
};

/// The pixels whose owner is not the stored one.
class OwnerOverlay {
 public:
  /// Sorts the claims and keeps the nearest claimant of each pixel. O(claims log claims).
  void resolve(const ClassifyView& view, std::vector<Claim>& claims);
  std::span<const Claim> entries() const { return entries_; }
  bool contains(std::size_t pixel) const { return (corrected_[pixel / 64] >> (pixel % 64)) & 1U; }
  /// \pre contains(pixel). O(log entries).
  FaceId owner(std::size_t pixel) const;

 private:
  std::vector<Claim> entries_;            ///< by pixel
  std::vector<std::uint64_t> corrected_;  ///< a bit a pixel
};

}  // namespace gpvc
