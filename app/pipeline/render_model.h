// Pictures of textured models.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "../../io/image.h"
#include "../../io/scene.h"
#include "../../io/textured_model.h"

namespace gpvc::pipeline {

struct RenderOptions {
  /// Trilinear lookup, by how fast texture coordinates change from pixel to pixel; without, pages are looked up
  /// bilinearly at their full size, as virtual rephotography scores them.
  bool mipmaps = false;
  bool cull_back_faces = false;
  std::array<std::uint8_t, 3> background{};  ///< RGB
};

struct RenderResult {
  Image image;                         ///< RGB
  std::vector<std::uint8_t> textured;  ///< per pixel: 255 where the nearest face has a page, else 0
};

/// Draws a textured model from an undistorted pinhole camera, on the CPU. A pixel shows the face over its centre; a face
/// without a page hides what is behind it and shows the background. Page images are RGB. O(faces + pixels), and
/// O(texels) with mipmaps; TBB.
RenderResult render_model(const io::TexturedModel& model, const std::vector<Image>& pages, const Camera& camera,
                          const Pose& pose, const RenderOptions& options = {});

}  // namespace gpvc::pipeline
