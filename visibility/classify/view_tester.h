// How VisibilityStage tests a view: ViewSource draws and projects it, then the method's ViewTester classifies the faces.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "visibility/classify/classify.h"
#include "visibility/device.h"
#include "visibility/gl/ivm_gl.h"
#include "visibility/native/face_hulls.h"
#include "visibility/native/ivm_cpu.h"
#include "visibility/raster/photo_mask.h"
#include "visibility/raster/projection.h"

namespace gpvc::visibility {

struct SourceOptions {
  bool native = true;                       ///< draw without OpenGL
  bool ivm = true;                          ///< draw the item buffer
  bool depths = false;                      ///< read back window depths; not with native drawing
  std::span<const std::uint8_t> doubled{};  ///< Repeats::doubled, for native drawing
  IvmRenderer::Options opengl{};
};

/// Draws and projects one mesh, view after view. Borrows the mesh.
class ViewSource {
 public:
  ViewSource(const Mesh& mesh, const SourceOptions& options);
  /// Draws the IVM into `result` where it is wanted, resets the statistics and projects the vertices. The returned value
  /// borrows from this source, the view, `excluded` (may be null) and `result`.
  PreparedView prepare(const View& view, ViewId id, const io::PhotoExclusion* excluded, ViewVisibility& result);

  const Mesh& mesh() const { return mesh_; }
  /// Null with native drawing.
  const IvmRenderer* renderer() const { return renderer_ ? &*renderer_ : nullptr; }
  /// What drawing found out about the faces of the last view: nothing where OpenGL draws. Classifying uses it up.
  FaceScan& scan() { return scan_; }
  /// Window depths of the last view: the far plane's depth where nothing is drawn. \pre SourceOptions::depths
  std::span<const float> depths() const { return depths_; }

 private:
  void draw_with_opengl(const View& view, ViewVisibility& result);

  const Mesh& mesh_;
  const SourceOptions options_;
  std::optional<IvmRenderer> renderer_;  ///< empty: native drawing
  FaceHulls hulls_;
  std::vector<std::uint8_t> beside_;  ///< per box of hulls_
  CpuIvm ivm_;
  FaceScan scan_;
  PhotoMask lens_mask_, mask_;
  ProjectedMesh projected_;
  std::vector<float> depths_;
};

class ViewTester {
 public:
  virtual ~ViewTester() = default;
  /// Fills classes, coverage and the counts of the statistics. The same for any number of threads.
  virtual void classify(const PreparedView& view, const View& of, ViewVisibility& result) = 0;
  /// "gpu" or "cpu", a colon and the reason.
  virtual std::string note() const = 0;
};

/// What testers are made from; source and device are borrowed.
struct TesterInput {
  ViewSource& source;
  const DeviceInfo* device;  ///< null: native drawing
  bool subpixel;
};

// Method by method. \throw GpuError

std::unique_ptr<ViewTester> make_tester(const Gpvc& method, const TesterInput& input);
std::unique_ptr<ViewTester> make_tester(const PaperGpvc& method, const TesterInput& input);
/// \pre SourceOptions::depths
std::unique_ptr<ViewTester> make_tester(const ShadowMap& method, const TesterInput& input);
std::unique_ptr<ViewTester> make_tester(const RayTracing& method, const TesterInput& input);
std::unique_ptr<ViewTester> make_tester(const NoTest& method, const TesterInput& input);

struct GpuLimits;  // gl/classify_gl.h

/// With shaders if `classifier`, device and limits allow them. \pre native drawing only for CoverageCorrection::exact
std::unique_ptr<ViewTester> make_gpvc_tester(ViewSource& source, const ClassifyOptions& options, Classifier classifier,
                                             const DeviceInfo* device, const GpuLimits& limits);

}  // namespace gpvc::visibility
