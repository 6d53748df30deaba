// The initial visibility map (section 2.1): an item buffer drawn by the graphics pipeline.
#pragma once

#include <vector>

#include "io/box.h"
#include "visibility/gl/gl_objects.h"
#include "visibility/method.h"
#include "visibility/raster/raster.h"

namespace gpvc::visibility {

/// Window depth as a function of z: at_infinity + per_inverse_z / z.
struct WindowDepth {
  double at_infinity = 0, per_inverse_z = 0;
};

/// The depth mapping of a view. apc (formula 5): reversed, N / z. spc (formulas 1 and 2, figure 6): 0 at the near plane
/// and 1 at the far plane, both fitted to the mesh's bounding box along the view direction. If the camera lies inside or
/// beside that box, the near plane lies at 2^-14 of the far plane's distance, and nearer parts are not drawn: symmetric
/// depth lacks the resolution for more.
struct DepthMapping {
  Projection projection = Projection::apc;
  WindowDepth window;
};

/// The bounding box of a mesh; without vertices, the origin.
Box box_around(const Mesh& mesh);

/// `near`: N of formula 5, for apc.
DepthMapping depth_mapping(Projection projection, double near, const Box& box, const Pose& pose);

/// Holds a mesh and a render target on the current device. All calls on the device's thread.
class IvmRenderer {
 public:
  struct Options {
    Projection projection = Projection::apc;
    /// N of formula 5. Depth is N / z in a float, whose relative precision is the same at any scale, so N can be as small
    /// as the exponent range allows: nothing farther than 2^-64 m from the camera plane is clipped, and depths up to
    /// 2^62 m stay normal numbers.
    double near = 0x1p-64;
    int largest_tile = 0;       ///< pixels in width and height; 0: what the driver allows
    bool staged_reads = false;  ///< read back through a GlReadBuffer
  };
  /// Uploads the mesh, which is borrowed. Throws GpuError.
  IvmRenderer(const Mesh& mesh, const Options& options);

  /// The first view includes the upload of the mesh.
  struct Times {
    double upload_s = 0, render_s = 0, readback_s = 0;
  };
  /// Where to read back to, row-major from the top-left; nullptr: not wanted.
  struct Output {
    std::vector<FaceId>* faces = nullptr;  ///< kNoFace where nothing is
    std::vector<float>* depths = nullptr;  ///< window depths, see mapping()
  };
  /// Draws every face, front and back, in order; at equal depths the lower face index wins. Ignores distortion.
  Times render(const Camera& camera, const Pose& pose, const Output& output);

  /// The depth mapping of the last view drawn.
  const DepthMapping& mapping() const { return mapping_; }

  /// The number of tiles for an image of this camera.
  int tiles(const Camera& camera) const;

  // For compute shaders; the texture holds the last tile drawn.
  GLuint ivm_texture() const { return color_.name(); }
  GLuint positions() const { return positions_.name(); }
  GLuint faces() const { return faces_.name(); }

 private:
  void make_target(int width, int height);
  void set_view(const Camera& camera, const Pose& pose);
  void draw_tile(int x0, int y0);
  void set_depth_state() const;
  void draw_faces();
  void read_tile(const Camera& camera, int x0, int y0, const Output& output);
  void read_pixels(GLenum format, GLenum type, const PixelBox& tile, int stride, void* pixels);

  const Mesh& mesh_;
  Options options_;
  Box box_;
  DepthMapping mapping_;
  int tile_width_ = 0, tile_height_ = 0;
  double pending_upload_s_ = 0;
  GlBuffer positions_, faces_;
  GlVertexArray vertices_;
  GlProgram program_;
  GLint tile_origin_ = -1, clip_from_pixel_ = -1, clip_from_depth_ = -1, first_face_ = -1;
  GlTexture color_, depth_;
  GlFramebuffer target_;
  GlReadBuffer staging_;
};

}  // namespace gpvc::visibility
