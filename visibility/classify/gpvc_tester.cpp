// Method::gpvc: the IVM sampled, in shaders or on the CPU.
#include <optional>
#include <stdexcept>

#include "io/clock.h"
#include "visibility/gl/classify_gl.h"
#include "visibility/native/ivm_cpu.h"
#include "visibility/view_tester.h"

namespace gpvc::visibility {
namespace {

class GpvcTester : public ViewTester {
 public:
  GpvcTester(const ViewSource& source, const DeviceInfo& device, const VisibilityOptions& options,
             const GpuLimits& limits)
      : source_(source), options_(options), cpu_(options) {
    choose_classifier(device, limits);
  }
  void classify(const ClassifyView& view, const View& of, ViewVisibility& result) override;
  std::string note() const override { return note_; }

 private:
  void choose_classifier(const DeviceInfo& device, const GpuLimits& limits);
  void classify_codes(const ClassifyView& view, const View& of, ViewVisibility& result);

  const ViewSource& source_;
  VisibilityOptions options_;
  CpuClassifier cpu_;
  std::optional<GpuClassifier> gpu_;
  std::string note_;
  std::vector<FaceCode> codes_;
  FaceScan scan_;
};

void GpvcTester::choose_classifier(const DeviceInfo& device, const GpuLimits& limits) {
  if (options_.classifier == Classifier::cpu) {
    note_ = "cpu: asked for";
  } else if (options_.classifier == Classifier::automatic && device.software) {
    note_ = "cpu: " + device.renderer + " runs there too, and shaders are slower";
  } else if (const std::string obstacle = GpuClassifier::obstacle(source_.mesh(), limits); !obstacle.empty()) {
    note_ = "cpu: " + obstacle;
  } else {
    note_ = options_.classifier == Classifier::gpu ? "gpu: asked for" : "gpu: " + device.renderer;
    gpu_.emplace(source_.mesh(), source_.renderer(), options_, limits);
  }
}

void GpvcTester::classify(const ClassifyView& view, const View& of, ViewVisibility& result) {
  if (!gpu_) return cpu_.classify(view, result);
  if (options_.correction != CoverageCorrection::exact) return classify_codes(view, of, result);
  if (!gpu_->scan(view, of.pose, scan_, result.statistics)) return cpu_.classify(view, result);
  cpu_.finish_exact_scan(view, scan_, result);
}

/// The shaders have counted the samples, except those of large faces; what the CPU counts again is dropped.
void GpvcTester::classify_codes(const ClassifyView& view, const View& of, ViewVisibility& result) {
  gpu_->classify(view, of.pose, codes_, result.statistics);
  const VisibilityStatistics counted = result.statistics;
  cpu_.finish_codes(view, codes_, result);
  result.statistics.processed_faces = counted.processed_faces;
  result.statistics.samples = counted.samples;
  result.statistics.corrected_samples = counted.corrected_samples;
}

/// Draws as well as classifies.
class NativeGpvcTester : public ViewTester {
 public:
  explicit NativeGpvcTester(const VisibilityOptions& options) : cpu_(options) {}
  void classify(const ClassifyView& view, const View& of, ViewVisibility& result) override;
  std::string note() const override { return "cpu: it draws as well"; }

 private:
  CpuClassifier cpu_;
  CpuIvm ivm_;
  FaceScan scan_;
};

void NativeGpvcTester::classify(const ClassifyView& view, const View&, ViewVisibility& result) {
  const auto start = Clock::now();
  ivm_.draw(view, result.ivm.faces, scan_);
  result.statistics.render_s += seconds_since(start);
  cpu_.finish_exact_scan(view, scan_, result);
}

}  // namespace

std::string native_drawing_obstacle(const VisibilityOptions& options) {
  if (options.method != Method::gpvc) return visibility_mode_name(options) + " draws with OpenGL";
  if (options.correction != CoverageCorrection::exact)
    return "what the other coverage corrections repair is what OpenGL rounds";
  if (options.projection != Projection::apc) return "a symmetric projection is OpenGL's alone";
  if (options.classifier == Classifier::gpu) return "shaders classify what OpenGL draws";
  return {};
}

DrawingChoice choose_drawing(const DeviceInfo& device, const VisibilityOptions& options) {
  const std::string obstacle = native_drawing_obstacle(options);
  if (options.drawing == Drawing::native) {
    if (!obstacle.empty()) throw std::invalid_argument("native drawing: " + obstacle);
    return {true, "native: asked for"};
  }
  if (options.drawing == Drawing::opengl) return {false, "opengl: asked for"};
  if (!device.software) return {false, "opengl: " + device.renderer};
  if (!obstacle.empty()) return {false, "opengl: " + obstacle};
  return {true, "native: " + device.renderer + " draws on the CPU too, and takes longer"};
}

std::unique_ptr<ViewTester> make_native_gpvc_tester(const VisibilityOptions& options) {
  return std::make_unique<NativeGpvcTester>(options);
}

std::unique_ptr<ViewTester> make_gpvc_tester(const ViewSource& source, const DeviceInfo& device,
                                             const VisibilityOptions& options, const GpuLimits& limits) {
  return std::make_unique<GpvcTester>(source, device, options, limits);
}

}  // namespace gpvc::visibility
