// Coverage correction `exact`: the IVM proposes an owner for every pixel, and every face that covers a pixel centre
// contests it.
//
// A face covering the centre of pixel p claims p when the stored owner does not cover the centre, or lies behind the
// face there (precedes_at_equal_depth() on a tie); both decided exactly. If the stored owner is right, no face claims the pixel.
// If it is wrong, the right one does: it covers the centre, and it lies in front of the stored owner unless that one
// does not cover the centre at all. So the nearest of the claimants is the owner, and nothing is assumed about the
// rasterizer: neither its snapping nor its depth buffer needs an error bound.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "visibility/classify/face_scan.h"
#include "visibility/raster/exact.h"
#include "visibility/raster/prepared_view.h"

namespace gpvc::visibility {

/// A face that contests owners. What the tests need of it is computed when first needed.
class Contender {
 public:
  Contender(const PreparedView& view, FaceId face) : view_(view), face_(face), nearest_(view.depths(face).nearest) {}
  FaceId face() const { return face_; }
  double nearest() const { return nearest_; }
  const InverseDepth& inverse_depth() {
    if (!measured_) depth_ = view_.inverse_depth(view_.quick(face_, view_.bounds(face_)), face_);
    measured_ = true;
    return depth_;
  }
  const RasterFace& raster() {
    if (!prepared_) raster_ = view_.raster(face_);
    prepared_ = true;
    return raster_;
  }

 private:
  const PreparedView& view_;
  FaceId face_;
  double nearest_;
  bool measured_ = false, prepared_ = false;
  InverseDepth depth_;
  RasterFace raster_;
};

/// Compares contenders with stored owners and caches the latest of these; one a thread.
class OwnerContest {
 public:
  /// Drops what was cached of the last view.
  void start();
  /// True when the contender, which covers the run, certainly beats its stored owner nowhere in it. Both faces are
  /// convex and their 1 / z linear, so what is certain at both ends is certain between them.
  bool stored_owner_keeps_run(const PreparedView& view, Contender& contender, FaceId stored, const Span& run);
  /// Exactly: true when the contender, which covers the run, beats its stored owner in all of it, false when it does
  /// nowhere; nothing when pixels of the run may differ. One pixel is always decided.
  std::optional<bool> beats_stored_in(const PreparedView& view, Contender& contender, FaceId stored, const Span& run);
  /// Exactly: true when the stored owner covers the centre of pixel (x, y).
  bool stored_owner_covers(const PreparedView& view, FaceId stored, std::int32_t x, std::int32_t y);
  /// True when it certainly covers both ends of the run, and so all of it.
  bool stored_owner_covers_run(const PreparedView& view, FaceId stored, const Span& run);

 private:
  struct Owner {
    FaceId face = kNoFace;
    QuickFace quick;
    double farthest = 0;
    bool measured = false, prepared = false;  ///< depth, raster are set
    InverseDepth depth;
    RasterFace raster;
  };
  Owner& owner_of(const PreparedView& view, FaceId stored);
  static const RasterFace& raster_of(const PreparedView& view, Owner& owner);
  static bool covers_ends(const Owner& owner, const Span& run);

  std::array<Owner, 256> owners_;
};

/// The pixels whose owner is not the stored one.
class OwnerOverlay {
 public:
  /// Sorts the claims and keeps the nearest claimant of each pixel. O(claims log claims); claimants of whole runs are
  /// compared at their ends.
  void resolve(const PreparedView& view, std::vector<Claim>& claims);
  std::span<const Claim> entries() const { return entries_; }
  /// True when it holds any pixel from `first` up to `end`.
  bool touches(std::size_t first, std::size_t end) const;
  bool contains(std::size_t pixel) const { return (corrected_[pixel / 64] >> (pixel % 64)) & 1U; }
  /// \pre contains(pixel). O(log entries).
  FaceId owner(std::size_t pixel) const;

 private:
  void add_nearest(const PreparedView& view, std::span<const FaceId> claimants, const Span& run);

  std::vector<Claim> entries_;            ///< by pixel
  std::vector<std::uint64_t> corrected_;  ///< one bit a pixel
};

}  // namespace gpvc::visibility
