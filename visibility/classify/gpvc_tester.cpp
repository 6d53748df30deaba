// Gpvc and PaperGpvc: native drawing or shaders scan the faces, or nothing does, and the CPU finishes.
#include <optional>

#include "visibility/classify/view_tester.h"
#include "visibility/gl/classify_gl.h"

namespace gpvc::visibility {
namespace {

class GpvcTester : public ViewTester {
 public:
  GpvcTester(ViewSource& source, const ClassifyOptions& options, std::string note)
      : source_(source), options_(options), cpu_(options), note_(std::move(note)) {}
  void use_shaders(const GpuLimits& limits) { gpu_.emplace(source_.mesh(), *source_.renderer(), options_, limits); }
  void classify(const PreparedView& view, const View& of, ViewVisibility& result) override;
  std::string note() const override { return note_; }

 private:
  ViewSource& source_;
  ClassifyOptions options_;
  CpuClassifier cpu_;
  std::optional<GpuClassifier> gpu_;
  std::string note_;
};

void GpvcTester::classify(const PreparedView& view, const View& of, ViewVisibility& result) {
  FaceScan& scan = source_.scan();
  if (gpu_) gpu_->scan(view, of.pose, scan, result.statistics);
  cpu_.classify(view, scan, result);
  if (gpu_ && options_.correction != CoverageCorrection::exact) {
    // The shaders sampled all but the large faces.
    result.statistics.processed_faces = scan.counts.processed_faces;
    result.statistics.samples = scan.counts.samples;
    result.statistics.corrected_samples = scan.counts.corrected_samples;
  }
  if (!gpu_ && source_.renderer() != nullptr) result.statistics.claims_s = 0;
}

}  // namespace

std::unique_ptr<ViewTester> make_gpvc_tester(ViewSource& source, const ClassifyOptions& options, Classifier classifier,
                                             const DeviceInfo* device, const GpuLimits& limits) {
  const auto on_cpu = [&](const std::string& reason) {
    return std::make_unique<GpvcTester>(source, options, "cpu: " + reason);
  };
  if (device == nullptr) return on_cpu("it draws as well");
  if (classifier == Classifier::cpu) return on_cpu("asked for");
  if (classifier == Classifier::automatic && device->software)
    return on_cpu(device->renderer + " runs there too, and shaders are slower");
  if (const std::string obstacle = GpuClassifier::obstacle(source.mesh(), limits); !obstacle.empty())
    return on_cpu(obstacle);
  auto tester = std::make_unique<GpvcTester>(
      source, options, classifier == Classifier::gpu ? "gpu: asked for" : "gpu: " + device->renderer);
  tester->use_shaders(limits);
  return tester;
}

std::unique_ptr<ViewTester> make_tester(const PaperGpvc& method, const TesterInput& input) {
  GpuLimits limits;
  if (input.device != nullptr) {
    limits = gpu_limits();
    limits.staged_reads = !input.device->software;
  }
  return make_gpvc_tester(input.source, {method.sampling, method.correction, input.subpixel}, method.classifier,
                          input.device, limits);
}

std::unique_ptr<ViewTester> make_tester(const Gpvc& method, const TesterInput& input) {
  return make_tester(PaperGpvc{method.sampling, Projection::apc, CoverageCorrection::exact, method.classifier}, input);
}

}  // namespace gpvc::visibility
