#include "visibility/visibility.h"

#include <chrono>

#include "visibility/classify.h"
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
      : device(graphics), mesh(input), options(given), renderer(input), classifier(given) {}

  GraphicsDevice& device;
  const Mesh& mesh;
  VisibilityOptions options;
  IvmRenderer renderer;
  CpuClassifier classifier;
  PhotoMask mask;
  std::vector<ProjectedVertex> projected;
};

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
  result.statistics = {};
  result.ivm.width = view.camera.width;
  result.ivm.height = view.camera.height;
  const IvmRenderer::Times times = state.renderer.render(view.camera, view.pose, result.ivm.faces);
  result.statistics.render_s = times.render_s;
  result.statistics.transfer_s = times.transfer_s;
  const Clock::time_point start = Clock::now();
  if (state.mask.camera() != view.camera) state.mask = PhotoMask(view.camera);
  state.mask.clear_outside(result.ivm.faces);
  project_vertices(state.mesh, view.camera, view.pose, state.projected);
  state.classifier.classify({state.mesh, view.camera, id, state.mask, state.projected, result.ivm.faces},
                            result);
  result.statistics.classify_s = seconds_since(start);
}

std::string VisibilityStage::classifier_note() const { return "cpu: the only classifier so far"; }

}  // namespace gpvc
