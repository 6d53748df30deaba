// How VisibilityStage tests a view: ViewSource draws and projects it, then the method's ViewTester classifies the faces.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "visibility/classify/classify.h"
#include "visibility/device.h"
#include "visibility/gl/ivm_gl.h"
#include "visibility/native/ivm_cpu.h"
#include "visibility/raster/photo_mask.h"
#include "visibility/raster/projection.h"

namespace gpvc::visibility {

struct SourceOptions {
  bool native = true;   ///< draw without OpenGL
  bool ivm = true;      ///< draw the item buffer
  bool depths = false;  ///< read back window depths; not with native drawing
  IvmRenderer::Options opengl{};
};

/// Draws and projects one mesh, view after view. Borrows the mesh.
class ViewSource {
 public:
  ViewSource(const Mesh& mesh, const SourceOptions& options);
  /// Draws the IVM into `result` where it is wanted, resets the statistics and projects the vertices. The returned value
  /// borrows from this source, the view, `excluded` (may be null) and `result`.
  ClassifyView prepare(const View& view, ViewId id, const io::PhotoExclusion* excluded, ViewVisibility& result);

  const Mesh& mesh() const { return mesh_; }
  /// \pre OpenGL draws
  const IvmRenderer& renderer() const { return *renderer_; }
  const PhotoMask& mask() const { return mask_; }
  /// What native drawing found out about the faces of the last view; classifying uses it up. \pre native drawing
  FaceScan& scan() { return scan_; }
  /// Window depths of the last view: the far plane's depth where nothing is drawn. \pre SourceOptions::depths
  std::span<const float> depths() const { return depths_; }

 private:
  void draw_with_opengl(const View& view, ViewVisibility& result);

  const Mesh& mesh_;
  const SourceOptions options_;
  std::optional<IvmRenderer> renderer_;  ///< empty: native drawing
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
  virtual void classify(const ClassifyView& view, const View& of, ViewVisibility& result) = 0;
  /// "gpu" or "cpu", a colon and the reason.
  virtual std::string note() const = 0;
};

struct GpuLimits;  // gl/classify_gl.h

// The sources and the mesh are borrowed. \throw GpuError

/// \pre OpenGL draws
std::unique_ptr<ViewTester> make_gpvc_tester(const ViewSource& source, const DeviceInfo& device,
                                             const ClassifyOptions& options, Classifier classifier,
                                             const GpuLimits& limits);
/// \pre native drawing and CoverageCorrection::exact
std::unique_ptr<ViewTester> make_native_gpvc_tester(ViewSource& source, const ClassifyOptions& options);
/// \pre SourceOptions::depths
std::unique_ptr<ViewTester> make_shadow_map_tester(const ViewSource& source, double epsilon, bool subpixel);
std::unique_ptr<ViewTester> make_ray_tester(const Mesh& mesh, const RayTracing& rays, bool subpixel);
std::unique_ptr<ViewTester> make_no_test(bool subpixel);

}  // namespace gpvc::visibility
