// The initial visibility map (section 2.1): an item buffer drawn by the graphics pipeline.
#pragma once

#include <vector>

#include "visibility/gl_objects.h"
#include "visibility/visibility.h"

namespace gpvc {

/// Holds a mesh and a render target on the current device. All calls on the device's thread.
class IvmRenderer {
 public:
  /// Uploads the mesh, which is borrowed. Tiles are at most `largest_tile` pixels wide and high (0: what the
  /// driver allows). Throws GpuError.
  explicit IvmRenderer(const Mesh& mesh, int largest_tile = 0);

  struct Times {
    double render_s = 0, readback_s = 0;
  };
  /// Draws every face, front and back, in order; depth ties keep the lower face. `faces` (width * height,
  /// row-major from the top-left) receives face indices and kNoFace. Distortion is not looked at.
  Times render(const Camera& camera, const Pose& pose, std::vector<FaceId>& faces);

  /// How many tiles an image of this camera takes.
  int tiles(const Camera& camera) const;

  /// Of the last tile drawn, for compute shaders.
  GLuint ivm_texture() const { return colour_.name(); }
  GLuint positions() const { return positions_.name(); }
  GLuint faces() const { return faces_.name(); }

 private:
  void make_target(int width, int height);
  void draw_tile(int x0, int y0);

  const Mesh& mesh_;
  int largest_tile_ = 0;
  int tile_width_ = 0, tile_height_ = 0;
  GlBuffer positions_, faces_;
  GlVertexArray vertices_;
  GlProgram program_;
  GLint pose_ = -1, intrinsics_ = -1, tile_origin_ = -1, clip_from_pixel_ = -1, first_face_ = -1;
  GlTexture colour_, depth_;
  GlFramebuffer target_;
};

}  // namespace gpvc
