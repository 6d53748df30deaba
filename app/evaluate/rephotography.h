// Virtual rephotography (Waechter et al. 2017): how close renders of a textured model come to photos of the same place.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "app/evaluate/json.h"
#include "app/pipeline/render_model.h"
#include "io/photos.h"
#include "io/scene.h"

namespace gpvc::evaluate {

struct RephotographyScore {
  double completeness = 0;  ///< textured pixels / pixels that the mesh covers, [0, 1]
  double psnr = 0;          ///< dB, over the three channels after the gain
  /// Mean CIEDE2000 over the pixels after the gain: photos of one scene differ in exposure, and the model has but one.
  double gained_color_error = 0;
  double ssim = 0;       ///< mean over windows, 11 x 11 Gaussian, sigma 1.5, on luma
  double ncc_error = 0;  ///< mean of 1 - NCC over 11 x 11 boxes, on luma; 0 best
  /// Mean absolute Laplacian of the render's luma, in whole pixels and relative to its mean, over that of the photo's: 1 is as
  /// sharp as the photo, more is noise or seams.
  double sharpness = 0;
  // Without the gain: what exposure, white balance and levelling leave.
  double raw_psnr = 0;                         ///< dB
  double color_error = 0, color_error_95 = 0;  ///< CIEDE2000 over the pixels: mean, and below which 95 % lie
  std::size_t covered = 0;                     ///< pixels that the mesh covers; 0: completeness means nothing
  std::size_t windows = 0;  ///< windows scored; 0: nothing could be compared, and only completeness means anything
};

/// Each figure's mean over the scores in which it means something; counts are summed up.
RephotographyScore mean_score(std::span<const RephotographyScore> scores);
/// The scores as evaluate's and compare's reports have them: null where they mean nothing.
Json score_json(const RephotographyScore& score);

/// A part of a picture: the sum of 1 - NCC over the windows whose centres lie in it.
struct TileError {
  double sum = 0;
  std::size_t windows = 0;
};
/// Pictures are divided into this many tiles in x and in y, to estimate how much of a difference is noise.
inline constexpr int kErrorTiles = 8;

struct Rephotography {
  RephotographyScore score;
  std::vector<TileError> tiles;         ///< kErrorTiles x kErrorTiles, row-major
  std::array<double, 3> gain{1, 1, 1};  ///< RGB, by which the render was multiplied to be compared
  Image photo, render;  ///< reduced; as taken and as the model is, since a gain may take a render past white
  Image error;          ///< 1 - NCC of the window around each pixel, black 0 to white 1; grey-blue where not scored
};

/// A photo as renders are compared with it: in the camera's own frame, with two marks per pixel, 0 or not.
struct ComparedPhoto {
  Image photo;
  std::vector<std::uint8_t> inside;   ///< the photo reaches here, and the view's mask does not exclude it
  std::vector<std::uint8_t> covered;  ///< the mesh covers the pixel's centre
};

/// \param excluded null: no pixel \param offset is to be added to the mesh's positions
ComparedPhoto photo_to_compare(const Image& photo, const io::PhotoExclusion* excluded, const View& view,
                               const Mesh& mesh, const WorldPoint& offset = {});
/// Per pixel of the view's frame: 255 where the mesh covers its centre, else 0.
std::vector<std::uint8_t> covered_pixels(const Mesh& mesh, const View& view, const WorldPoint& offset = {});
/// The model as the view shows it; `offset` is to be added to its positions.
pipeline::RenderResult render_view(const io::TexturedModel& model, const std::vector<Image>& pages, const View& view,
                                   const WorldPoint& offset);

/// Compares a render with a photo of the same frame. Both are reduced by `reduction` with area averaging, but no further
/// than to an edge of one pixel. A reduced pixel counts if all of its pixels are textured and inside; a window counts if
/// all of its pixels do. Each channel of the render is multiplied by one gain so that its mean equals the photo's.
Rephotography compare_with_photo(const ComparedPhoto& photo, const pipeline::RenderResult& render, int reduction);

}  // namespace gpvc::evaluate
