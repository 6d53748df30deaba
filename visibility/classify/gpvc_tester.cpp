// Gpvc and PaperGpvc: the IVM is sampled, in shaders or on the CPU.
#include <optional>

#include "visibility/classify/view_tester.h"
#include "visibility/gl/classify_gl.h"

namespace gpvc::visibility {
namespace {

class GpvcTester : public ViewTester {
 public:
  GpvcTester(const ViewSource& source, const DeviceInfo& device, const ClassifyOptions& options, Classifier classifier,
             const GpuLimits& limits)
      : source_(source), options_(options), cpu_(options) {
    choose_classifier(device, classifier, limits);
  }
  void classify(const ClassifyView& view, const View& of, ViewVisibility& result) override;
  std::string note() const override { return note_; }

 private:
  void choose_classifier(const DeviceInfo& device, Classifier classifier, const GpuLimits& limits);
  void classify_codes(const ClassifyView& view, const View& of, ViewVisibility& result);

  const ViewSource& source_;
  ClassifyOptions options_;
  CpuClassifier cpu_;
  std::optional<GpuClassifier> gpu_;
  std::string note_;
  std::vector<FaceCode> codes_;
  FaceScan scan_;
};

void GpvcTester::choose_classifier(const DeviceInfo& device, Classifier classifier, const GpuLimits& limits) {
  if (classifier == Classifier::cpu) {
    note_ = "cpu: asked for";
  } else if (classifier == Classifier::automatic && device.software) {
    note_ = "cpu: " + device.renderer + " runs there too, and shaders are slower";
  } else if (const std::string obstacle = GpuClassifier::obstacle(source_.mesh(), limits); !obstacle.empty()) {
    note_ = "cpu: " + obstacle;
  } else {
    note_ = classifier == Classifier::gpu ? "gpu: asked for" : "gpu: " + device.renderer;
    gpu_.emplace(source_.mesh(), source_.renderer(), options_, limits);
  }
}

void GpvcTester::classify(const ClassifyView& view, const View& of, ViewVisibility& result) {
  if (!gpu_) return cpu_.classify(view, result);
  if (options_.correction != CoverageCorrection::exact) return classify_codes(view, of, result);
  if (!gpu_->scan(view, of.pose, scan_, result.statistics)) return cpu_.classify(view, result);
  cpu_.finish_exact_scan(view, scan_, result);
}

/// Keeps the statistics of the shaders, which sampled all but the large faces.
void GpvcTester::classify_codes(const ClassifyView& view, const View& of, ViewVisibility& result) {
  gpu_->classify(view, of.pose, codes_, result.statistics);
  const VisibilityStatistics counted = result.statistics;
  cpu_.finish_codes(view, codes_, result);
  result.statistics.processed_faces = counted.processed_faces;
  result.statistics.samples = counted.samples;
  result.statistics.corrected_samples = counted.corrected_samples;
}

/// Classifies what ViewSource drew natively.
class NativeGpvcTester : public ViewTester {
 public:
  NativeGpvcTester(ViewSource& source, const ClassifyOptions& options) : source_(source), cpu_(options) {}
  void classify(const ClassifyView& view, const View&, ViewVisibility& result) override {
    cpu_.finish_exact_scan(view, source_.scan(), result);
  }
  std::string note() const override { return "cpu: it draws as well"; }

 private:
  ViewSource& source_;
  CpuClassifier cpu_;
};

}  // namespace

std::unique_ptr<ViewTester> make_native_gpvc_tester(ViewSource& source, const ClassifyOptions& options) {
  return std::make_unique<NativeGpvcTester>(source, options);
}

std::unique_ptr<ViewTester> make_gpvc_tester(const ViewSource& source, const DeviceInfo& device,
                                             const ClassifyOptions& options, Classifier classifier,
                                             const GpuLimits& limits) {
  return std::make_unique<GpvcTester>(source, device, options, classifier, limits);
}

}  // namespace gpvc::visibility
