#include <cmath>
#include <stdexcept>

#include "io/clock.h"
#include "visibility/classify/view_tester.h"
#include "visibility/device.h"
#include "visibility/gl/classify_gl.h"
#include "visibility/visibility.h"

namespace gpvc::visibility {
namespace {

template <class... Functions>
struct Overloaded : Functions... {
  using Functions::operator()...;
};
template <class... Functions>
Overloaded(Functions...) -> Overloaded<Functions...>;

Drawing drawing_of(const VisibilityOptions& options) {
  const auto of_baseline = [&](const auto& method) { return options.draw_ivm ? method.drawing : Drawing::native; };
  return std::visit(
      Overloaded{[](const Gpvc& method) {
                   return method.drawing == Drawing::automatic && method.classifier == Classifier::gpu ? Drawing::opengl
                                                                                                       : method.drawing;
                 },
                 [](const PaperGpvc&) { return Drawing::opengl; }, [](const ShadowMap&) { return Drawing::opengl; },
                 [&](const RayTracing& method) { return of_baseline(method); },
                 [&](const NoTest& method) { return of_baseline(method); }},
      options.method);
}

/// What needs OpenGL, as the subject of a sentence.
std::string opengl_user(const Method& method) {
  if (std::holds_alternative<PaperGpvc>(method)) return "gpvc without the exact coverage correction, or with spc,";
  if (std::holds_alternative<ShadowMap>(method)) return visibility_mode_name(method);
  const auto* gpvc = std::get_if<Gpvc>(&method);
  if (gpvc != nullptr && gpvc->classifier == Classifier::gpu) return "classifying in shaders";
  return "drawing with OpenGL, as asked for,";
}

struct ChosenDrawing {
  bool native = false;
  std::string note;
};

ChosenDrawing choose_drawing(const VisibilityOptions& options, const GraphicsDevice* device) {
  const Drawing drawing = drawing_of(options);
  if (drawing == Drawing::native) return {true, options.draw_ivm ? "native: asked for" : "native: nothing is drawn"};
  if (drawing == Drawing::opengl) {
    if (device == nullptr) throw GpuError(opengl_user(options.method) + " needs an OpenGL device, and none was given");
    return {false, "opengl: " + opengl_user(options.method) + " needs it"};
  }
  if (device == nullptr) return {true, "native: there is no graphics hardware"};
  const std::string& renderer = device->info().renderer;
  if (device->info().software) return {true, "native: " + renderer + " draws on the CPU too, and takes longer"};
  return {false, "opengl: " + renderer};
}

void check(const Method& method) {
  const auto check_bias = [](double epsilon) {
    if (!(epsilon > 0 && std::isfinite(epsilon)))
      throw std::invalid_argument("the bias of a visibility test must be above 0 and finite");
  };
  if (const auto* shadow_map = std::get_if<ShadowMap>(&method)) check_bias(shadow_map->epsilon);
  if (const auto* rays = std::get_if<RayTracing>(&method)) check_bias(rays->epsilon);
  const auto* gpvc = std::get_if<Gpvc>(&method);
  if (gpvc != nullptr && gpvc->drawing == Drawing::native && gpvc->classifier == Classifier::gpu)
    throw std::invalid_argument("shaders classify what OpenGL has drawn, not what is drawn natively");
}

SourceOptions source_options(const VisibilityOptions& options, const GraphicsDevice* device) {
  const bool gpvc = std::holds_alternative<Gpvc>(options.method) || std::holds_alternative<PaperGpvc>(options.method);
  SourceOptions source;
  source.native = device == nullptr;
  source.ivm = gpvc || options.draw_ivm;
  source.opengl.staged_reads = device != nullptr && !device->info().software;
  if (const auto* paper = std::get_if<PaperGpvc>(&options.method)) source.opengl.projection = paper->projection;
  if (const auto* shadow_map = std::get_if<ShadowMap>(&options.method)) {
    source.depths = true;
    source.opengl.projection = shadow_map->projection;
    source.opengl.near = kShadowMapNear;
  }
  return source;
}

}  // namespace

std::unique_ptr<GraphicsDevice> find_device(const VisibilityOptions& options, int device) {
  if (device >= 0) return std::make_unique<GraphicsDevice>(device);
  const Drawing drawing = drawing_of(options);
  if (drawing == Drawing::native) return nullptr;
  if (drawing == Drawing::automatic) return GraphicsDevice::find_hardware();
  try {
    return std::make_unique<GraphicsDevice>();
  } catch (const GpuError& error) {
    throw GpuError(opengl_user(options.method) + " needs an OpenGL device: " + error.what());
  }
}

struct VisibilityStage::State {
  State(const Mesh& mesh, const VisibilityOptions& options, GraphicsDevice* given)
      : drawing(choose_drawing(options, given)),
        device(current(drawing.native ? nullptr : given)),
        source(mesh, source_options(options, device)),
        tester(make_tester(options)) {}

  static GraphicsDevice* current(GraphicsDevice* device) {
    if (device != nullptr) device->make_current();
    return device;
  }

  std::unique_ptr<ViewTester> make_gpvc(const ClassifyOptions& options, Classifier classifier) {
    if (device == nullptr) return make_native_gpvc_tester(source, options);
    GpuLimits limits = gpu_limits();
    limits.staged_reads = !device->info().software;
    return make_gpvc_tester(source, device->info(), options, classifier, limits);
  }

  std::unique_ptr<ViewTester> make_tester(const VisibilityOptions& options) {
    const bool subpixel = options.subpixel;
    return std::visit(
        Overloaded{[&](const Gpvc& method) {
                     return make_gpvc({method.sampling, CoverageCorrection::exact, subpixel}, method.classifier);
                   },
                   [&](const PaperGpvc& method) {
                     return make_gpvc({method.sampling, method.correction, subpixel}, method.classifier);
                   },
                   [&](const ShadowMap& method) { return make_shadow_map_tester(source, method.epsilon, subpixel); },
                   [&](const RayTracing& method) { return make_ray_tester(source.mesh(), method, subpixel); },
                   [&](const NoTest&) { return make_no_test(subpixel); }},
        options.method);
  }

  ChosenDrawing drawing;
  GraphicsDevice* device;  ///< null: native drawing
  ViewSource source;
  std::unique_ptr<ViewTester> tester;
};

VisibilityStage::VisibilityStage(const Mesh& mesh, const VisibilityOptions& options, GraphicsDevice* device) {
  check(options.method);
  state_ = std::make_unique<State>(mesh, options, device);
}

VisibilityStage::~VisibilityStage() { State::current(state_->device); }

ViewVisibility VisibilityStage::classify(const View& view, ViewId id, const io::PhotoExclusion* excluded) {
  ViewVisibility result;
  classify(view, id, excluded, result);
  return result;
}

void VisibilityStage::classify(const View& view, ViewId id, const io::PhotoExclusion* excluded,
                               ViewVisibility& result) {
  State& state = *state_;
  State::current(state.device);
  const ClassifyView prepared = state.source.prepare(view, id, excluded, result);
  VisibilityStatistics& statistics = result.statistics;
  const auto other_s = [&] { return statistics.upload_s + statistics.render_s + statistics.readback_s; };
  const double before = other_s();
  const auto start = Clock::now();
  state.tester->classify(prepared, view, result);
  statistics.classify_s += seconds_since(start) - (other_s() - before);
}

std::string VisibilityStage::classifier_note() const { return state_->tester->note(); }
std::string VisibilityStage::drawing_note() const { return state_->drawing.note; }

}  // namespace gpvc::visibility
