#include "visibility/visibility.h"

#include <chrono>
#include <optional>

#include "visibility/classify.h"
#include "visibility/classify_gl.h"
#include "visibility/ivm_gl.h"

namespace gpvc {
namespace {

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

}  // namespace

struct VisibilityStage::State {
  State(GraphicsDevice& graphics, const Mesh& input, const VisibilityOptions& given)
      : device(graphics), mesh(input), options(given), renderer(input), cpu(given) {
    choose_classifier();
  }

  void choose_classifier();

  GraphicsDevice& device;
  const Mesh& mesh;
  VisibilityOptions options;
  IvmRenderer renderer;
  CpuClassifier cpu;
  std::optional<GpuClassifier> gpu;
  std::string note;
  PhotoMask mask;
  ProjectedMesh projected;
  std::vector<FaceCode> codes;
};

void VisibilityStage::State::choose_classifier() {
  if (options.classifier == Classifier::cpu) {
    note = "cpu: asked for";
  } else if (options.correction == CoverageCorrection::exact) {
    note = "cpu: the exact correction runs there only";
  } else if (options.classifier == Classifier::automatic && device.info().software) {
    note = "cpu: " + device.info().renderer + " runs there too, and shaders are slower";
  } else if (const std::string obstacle = GpuClassifier::obstacle(mesh); !obstacle.empty()) {
    note = "cpu: " + obstacle;
  } else {
    note = options.classifier == Classifier::gpu ? "gpu: asked for" : "gpu: " + device.info().renderer;
    gpu.emplace(mesh, renderer, options);
  }
}

VisibilityStage::VisibilityStage(GraphicsDevice& device, const Mesh& mesh, const VisibilityOptions& options) {
  device.make_current();
  state_ = std::make_unique<State>(device, mesh, options);
}

VisibilityStage::~VisibilityStage() { state_->device.make_current(); }

ViewVisibility VisibilityStage::classify(const View& view, ViewId id) {
  ViewVisibility result;
  classify(view, id, result);
  return result;
}

void VisibilityStage::classify(const View& view, ViewId id, ViewVisibility& result) {
  State& state = *state_;
  state.device.make_current();
  const auto pixels =
      static_cast<std::uint64_t>(view.camera.width) * static_cast<std::uint64_t>(view.camera.height);
  if (view.camera.width <= 0 || view.camera.height <= 0 || pixels > 0xFFFFFFFFU)
    throw GpuError("an image of " + std::to_string(view.camera.width) + " x " +
                   std::to_string(view.camera.height) + " pixels cannot be drawn");
  result.statistics = {};
  result.ivm.width = view.camera.width;
  result.ivm.height = view.camera.height;
  const IvmRenderer::Times times = state.renderer.render(view.camera, view.pose, result.ivm.faces);
  result.statistics.render_s = times.render_s;
  result.statistics.readback_s = times.readback_s;
  const Clock::time_point start = Clock::now();
  if (state.mask.camera() != view.camera) state.mask = PhotoMask(view.camera);
  state.mask.clear_outside(result.ivm.faces);
  project_vertices(state.mesh, view.camera, view.pose, state.projected);
  const ClassifyView prepared{state.mesh,
                              view.camera,
                              id,
                              state.mask,
                              state.projected,
                              result.ivm.faces,
                              projection_rounding(view.camera)};
  // Shaders see the last tile alone: an image of several tiles is classified on the CPU, with the same bits.
  if (state.gpu && state.renderer.tiles(view.camera) == 1) {
    state.gpu->classify(view.camera, view.pose, state.mask, state.codes, result.statistics);
    const VisibilityStatistics counted = result.statistics;
    state.cpu.complete(prepared, state.codes, result);
    result.statistics.processed_faces = counted.processed_faces;
    result.statistics.samples = counted.samples;
    result.statistics.corrected_samples = counted.corrected_samples;
  } else {
    state.cpu.classify(prepared, result);
  }
  result.statistics.classify_s = seconds_since(start);
}

std::string VisibilityStage::classifier_note() const { return state_->note; }

}  // namespace gpvc
