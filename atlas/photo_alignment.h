// Small shifts that bring the photos of a scene into line with each other on the mesh.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "../io/members.h"
#include "../io/names.h"
#include "../io/scene.h"

namespace gpvc::atlas {

/// none: colours are taken from where poses, lens and mesh have them. local: photos are compared with each other all over the mesh,
/// and each is shifted a little, smoothly from place to place, so that they show the same things at the same places. Not where
/// they fit each other already.
enum class PhotoAlignment { none, local };
inline constexpr Named<PhotoAlignment> kPhotoAlignmentNames[] = {{"none", PhotoAlignment::none},
                                                                 {"local", PhotoAlignment::local}};

/// What two photos show of each other around a place on the mesh.
struct PhotoMatch {
  std::array<std::uint32_t, 2> views{};  ///< index(ViewId)
  std::array<float, 4> at{};             ///< of the place, px: x and y in the frame of the first, then of the second
  /// The second shows at the place plus this, in pixels of the frame of the first, what the first shows at the place.
  std::array<float, 2> shift{};
  std::array<float, 3> information{};  ///< xx, xy and yy of the inverse of its covariance, 1 / px^2
  std::array<float, 4>
      second_from_first{};  ///< row-major: how positions of the second frame move with those of the first
  bool operator==(const PhotoMatch&) const = default;
};
GPVC_MEMBERS(PhotoMatch, views, at, shift, information, second_from_first)
/// True if the match can come from match_photos(): views of the scene, finite numbers, an information matrix that is not negative.
bool is_sound(const PhotoMatch& match, const Scene& scene);

/// True of a field that a fit may give: two columns and rows at least, and shifts of 16 pixels at most; or none.
bool is_sound(const ShiftField& field);

struct AlignmentStatistics {
  std::size_t matches = 0;  ///< none where fields were given
  /// The median of how far apart photos are at places that had no part in a fit, px: without it and with it.
  double before_px = 0, after_px = 0;
  double shift_px = 0;  ///< root mean square of the shifts at the places
  double affine_share =
      0;  ///< of their squares: what one affine map a photo explains, as errors of poses and focal lengths make
};
GPVC_MEMBERS(AlignmentStatistics, matches, before_px, after_px, shift_px, affine_share)

/// How far apart the photos of two charts are in what they show along the cut between them, in pixels of one of the photos: by
/// correlating squares of 32 pixels around places on the cut that have texture. Along a straight edge only what is across counts.
struct CutMisfit {
  struct Place {
    FaceId face{};
    float px = 0;
  };
  std::size_t places = 0;  ///< with texture, that both photos show
  std::size_t matched =
      0;  ///< of them, those where the photos agree within 8 pixels: at the others they show different things
  double median_px = 0, px_90 = 0;                      ///< of those: the middle, and below which 90 % lie
  double unaligned_median_px = 0, unaligned_px_90 = 0;  ///< the same as it would be without alignment
  std::vector<Place> where{};                           ///< the matched places
};
GPVC_MEMBERS(CutMisfit::Place, face, px)
GPVC_MEMBERS(CutMisfit, places, matched, median_px, px_90, unaligned_median_px, unaligned_px_90, where)

struct AlignmentFit {
  std::vector<ShiftField> fields;  ///< one a view, all without nodes where they would explain no more than noise does
  AlignmentStatistics statistics;
};

/// Fields that explain matches: smooth, robust to wrong ones, and no larger than it takes, so that their mean over the photos of a
/// place is about zero. Robust least squares (iteratively reweighted, Holland and Welsch 1977) by conjugate gradients. The
/// same for any number of threads; matches in another order give other last digits. O(matches + nodes) a step, TBB.
AlignmentFit fit_alignment(const Scene& scene, std::span<const PhotoMatch> matches);

/// Fields for photos that are reduced by this factor.
std::vector<ShiftField> reduced(std::vector<ShiftField> fields, double reduction);

}  // namespace gpvc::atlas
