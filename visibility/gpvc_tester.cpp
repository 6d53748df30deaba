// Method::gpvc: the IVM sampled, in shaders or on the CPU.
#include <optional>

#include "visibility/classify_gl.h"
#include "visibility/view_tester.h"

namespace gpvc {
namespace {

class GpvcTester : public ViewTester {
 public:
  GpvcTester(const ViewSource& source, const DeviceInfo& device, const VisibilityOptions& options)
      : source_(source), cpu_(options) {
    choose_classifier(device, options);
  }
  void classify(const ClassifyView& view, const View& of, ViewVisibility& result) override;
  std::string note() const override { return note_; }

 private:
  void choose_classifier(const DeviceInfo& device, const VisibilityOptions& options);

  const ViewSource& source_;
  CpuClassifier cpu_;
  std::optional<GpuClassifier> gpu_;
  std::string note_;
  std::vector<FaceCode> codes_;
};

void GpvcTester::choose_classifier(const DeviceInfo& device, const VisibilityOptions& options) {
  if (options.classifier == Classifier::cpu) {
    note_ = "cpu: asked for";
  } else if (options.correction == CoverageCorrection::exact) {
    note_ = "cpu: the exact correction runs there only";
  } else if (options.classifier == Classifier::automatic && device.software) {
    note_ = "cpu: " + device.renderer + " runs there too, and shaders are slower";
  } else if (const std::string obstacle = GpuClassifier::obstacle(source_.mesh()); !obstacle.empty()) {
    note_ = "cpu: " + obstacle;
  } else {
    note_ = options.classifier == Classifier::gpu ? "gpu: asked for" : "gpu: " + device.renderer;
    gpu_.emplace(source_.mesh(), source_.renderer(), options);
  }
}

void GpvcTester::classify(const ClassifyView& view, const View& of, ViewVisibility& result) {
  // Shaders see the last tile alone: an image of several tiles is classified on the CPU, with the same bits.
  if (!gpu_ || source_.renderer().tiles(of.camera) != 1) return cpu_.classify(view, result);
  gpu_->classify(of.camera, of.pose, source_.mask(), codes_, result.statistics);
  const VisibilityStatistics counted = result.statistics;
  cpu_.complete(view, codes_, result);
  result.statistics.processed_faces = counted.processed_faces;
  result.statistics.samples = counted.samples;
  result.statistics.corrected_samples = counted.corrected_samples;
}

}  // namespace

std::unique_ptr<ViewTester> make_gpvc_tester(const ViewSource& source, const DeviceInfo& device,
                                             const VisibilityOptions& options) {
  return std::make_unique<GpvcTester>(source, device, options);
}

}  // namespace gpvc
