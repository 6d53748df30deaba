// What VisibilityStage puts before a view: one tester a method, all starting from the same drawn view.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "visibility/classify/classify.h"
#include "visibility/gl/ivm_gl.h"
#include "visibility/raster/photo_mask.h"
#include "visibility/raster/projection.h"

namespace gpvc::visibility {

/// One mesh on the device, drawn and projected view after view. Borrows the mesh.
class ViewSource {
 public:
  /// `staged_reads`: see IvmRenderer::Options. `opengl`: false leaves the drawing to the tester, and the mesh where it
  /// is.
  ViewSource(const Mesh& mesh, const VisibilityOptions& options, bool staged_reads = false, bool opengl = true);
  /// Draws the IVM into `result` (or makes room for it), starts its statistics, projects the vertices. What is returned
  /// borrows from both and from the view.
  ClassifyView prepare(const View& view, ViewId id, ViewVisibility& result);

  const Mesh& mesh() const { return mesh_; }
  /// \pre OpenGL draws
  const IvmRenderer& renderer() const { return *renderer_; }
  const PhotoMask& mask() const { return mask_; }
  /// Window depths of the last view, for Method::shadow_map; 0 or 1 where nothing is, whichever is farthest.
  std::span<const float> depths() const { return depths_; }

 private:
  const Mesh& mesh_;
  const VisibilityOptions options_;
  std::optional<IvmRenderer> renderer_;
  PhotoMask lens_mask_, mask_;
  std::optional<io::PhotoExclusion> exclusion_;
  ProjectedMesh projected_;
  std::vector<float> depths_;
};

class ViewTester {
 public:
  virtual ~ViewTester() = default;
  /// Fills classes, coverage and the counts of the statistics. The same for any number of threads.
  virtual void classify(const ClassifyView& view, const View& of, ViewVisibility& result) = 0;
  /// Which processor classifies, and why.
  virtual std::string note() const = 0;
};

struct GpuLimits;  // classify_gl.h

/// Whether Method::gpvc is to draw natively, and why, for the log. Throws std::invalid_argument when it is asked to and
/// cannot.
struct DrawingChoice {
  bool native = false;
  std::string note;
};
DrawingChoice choose_drawing(const DeviceInfo& device, const VisibilityOptions& options);

/// All borrow `source`. They throw GpuError.
std::unique_ptr<ViewTester> make_gpvc_tester(const ViewSource& source, const DeviceInfo& device,
                                             const VisibilityOptions& options, const GpuLimits& limits);
/// The same classes from what it draws itself; the source need not draw.
std::unique_ptr<ViewTester> make_native_gpvc_tester(const VisibilityOptions& options);
std::unique_ptr<ViewTester> make_shadow_map_tester(const ViewSource& source, const VisibilityOptions& options);
std::unique_ptr<ViewTester> make_ray_tester(const ViewSource& source, const VisibilityOptions& options);
std::unique_ptr<ViewTester> make_no_test(const VisibilityOptions& options);

}  // namespace gpvc::visibility
