// Which faces of a mesh a view sees: GPVC (Huang, Zhu, Jiang 2018), without a bias, drawn by OpenGL without a window or
// natively on the CPU; and the methods that it is compared with.
//
// Terms of the paper, used throughout:
//   IVM     initial visibility map: per pixel the index of the face drawn there (section 2.1)
//   LEF     linear edge function (formula 6); TLR: top-left rule (figure 10)
//   LPCC    lazy-projection coverage correction (algorithm 1)
//   HIVERS  hierarchical iterative vertex-edge-region sampling (algorithm 2); VES: vertices and edges only
//   APC     asymmetric projection configuration: reversed depth, near plane at zero (formula 5)
// Deviation from formula 12: clip coordinates keep w = z, so the rasterizer clips at the camera plane.
// result.h says what the results mean, method.h what there is to choose from.
#pragma once

#include <memory>
#include <string>

#include "../io/scene.h"
#include "method.h"
#include "result.h"

namespace gpvc::io {
struct PhotoExclusion;  // photos.h
}

namespace gpvc::visibility {

/// Visibility of one mesh, view after view. With a device it holds the mesh there and must be used on the device's
/// thread. Uses all TBB threads inside; the result does not depend on their number or on the classifier.
class VisibilityStage {
 public:
  /// Borrows mesh and device. Without a device, as find_device() gives it, everything is drawn natively. Throws InputError for a
  /// mesh that validate_faces() refuses, GpuError
  /// when the options need OpenGL and there is no device, or when it cannot hold the mesh; std::invalid_argument when a
  /// bias is not positive and finite, or when Gpvc asks for native drawing and shaders.
  VisibilityStage(const Mesh& mesh, const VisibilityOptions& options, GraphicsDevice* device = nullptr);
  ~VisibilityStage();
  /// O(faces + pixels). Coverage entries carry `id`. `excluded`: pixels of the photo that count as outside it, at the
  /// camera's size, as io::PhotoSource::exclusion() gives them; null where all may be used. Images above the GL viewport
  /// limit are drawn in tiles. Throws std::invalid_argument when `excluded` has another size than the camera.
  ViewVisibility classify(const View& view, ViewId id, const io::PhotoExclusion* excluded);
  /// Does the same and reuses the memory of `result`.
  void classify(const View& view, ViewId id, const io::PhotoExclusion* excluded, ViewVisibility& result);
  /// "gpu" or "cpu", a colon and the reason, for the log.
  std::string classifier_note() const;
  /// "opengl" or "native", a colon and the reason, for the log.
  std::string drawing_note() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace gpvc::visibility
