// Method::gpvc: the IVM sampled, in shaders or on the CPU.
#include <optional>

#include "visibility/classify_gl.h"
#include "visibility/view_tester.h"

namespace gpvc {
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
  } else if (const std::string obstacle = GpuClassifier::obstacle(source_.mesh(), limits);
             !obstacle.empty()) {
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
  cpu_.complete(view, scan_, result);
}

/// Statistics are those of the shaders, which have looked at the samples.
void GpvcTester::classify_codes(const ClassifyView& view, const View& of, ViewVisibility& result) {
  gpu_->classify(view, of.pose, codes_, result.statistics);
  const VisibilityStatistics counted = result.statistics;
  cpu_.complete(view, codes_, result);
  result.statistics.processed_faces = counted.processed_faces;
  result.statistics.samples = counted.samples;
  result.statistics.corrected_samples = counted.corrected_samples;
}

}  // namespace

std::unique_ptr<ViewTester> make_gpvc_tester(const ViewSource& source, const DeviceInfo& device,
                                             const VisibilityOptions& options, const GpuLimits& limits) {
  return std::make_unique<GpvcTester>(source, device, options, limits);
}

}  // namespace gpvc
