// Tests views one after the other with the tester of the chosen method.
#include <cmath>
#include <optional>
#include <stdexcept>

#include "io/clock.h"
#include "io/validate.h"
#include "visibility/classify/view_tester.h"
#include "visibility/device.h"
#include "visibility/gl/classify_gl.h"
#include "visibility/raster/copies.h"
#include "visibility/visibility.h"

namespace gpvc::visibility {
namespace {

Drawing drawing_of(const VisibilityOptions& options) {
  return std::visit(
      [&](const auto& method) {
        if constexpr (!requires { method.drawing; }) {
          return Drawing::opengl;  // the method is about what OpenGL draws
        } else if constexpr (requires { method.classifier; }) {
          if (method.drawing != Drawing::automatic) return method.drawing;
          return method.classifier == Classifier::gpu   ? Drawing::opengl
                 : method.classifier == Classifier::cpu ? Drawing::native
                                                        : Drawing::automatic;
        } else {
          return options.draw_ivm ? method.drawing : Drawing::native;
        }
      },
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

ChosenDrawing choose_drawing(const Mesh& mesh, const VisibilityOptions& options, const GraphicsDevice* device) {
  const Drawing drawing = drawing_of(options);
  if (drawing == Drawing::native) {
    const auto* gpvc = std::get_if<Gpvc>(&options.method);
    if (gpvc != nullptr && gpvc->drawing == Drawing::automatic) return {true, "native: the CPU classifies"};
    return {true, options.draw_ivm ? "native: asked for" : "native: nothing is drawn"};
  }
  if (drawing == Drawing::opengl) {
    if (device == nullptr) throw GpuError(opengl_user(options.method) + " needs an OpenGL device, and none was given");
    return {false, "opengl: " + opengl_user(options.method) + " needs it"};
  }
  if (device == nullptr) return {true, "native: there is no graphics hardware"};
  const std::string& renderer = device->info().renderer;
  if (device->info().software) return {true, "native: " + renderer + " draws on the CPU too, and takes longer"};
  if (std::holds_alternative<Gpvc>(options.method)) {
    device->make_current();
    const std::string obstacle = GpuClassifier::obstacle(mesh, gpu_limits());
    if (!obstacle.empty()) return {true, "native: " + obstacle};
  }
  return {false, "opengl: " + renderer};
}

void check(const Method& method) {
  std::visit(
      [](const auto& any) {
        if constexpr (requires { any.epsilon; })
          if (!(any.epsilon > 0 && std::isfinite(any.epsilon)))
            throw std::invalid_argument("the bias of a visibility test must be above 0 and finite");
      },
      method);
  const auto* gpvc = std::get_if<Gpvc>(&method);
  if (gpvc != nullptr && gpvc->drawing == Drawing::native && gpvc->classifier == Classifier::gpu)
    throw std::invalid_argument("shaders classify what OpenGL has drawn, not what is drawn natively");
}

SourceOptions source_options(const VisibilityOptions& options, const GraphicsDevice* device,
                             std::span<const std::uint8_t> doubled) {
  const bool gpvc = std::holds_alternative<Gpvc>(options.method) || std::holds_alternative<PaperGpvc>(options.method);
  SourceOptions source;
  source.native = device == nullptr;
  source.doubled = doubled;
  source.ivm = gpvc || options.draw_ivm;
  source.opengl.staged_reads = device != nullptr && !device->info().software;
  std::visit(
      [&](const auto& method) {
        if constexpr (requires { method.projection; }) source.opengl.projection = method.projection;
      },
      options.method);
  if (std::holds_alternative<ShadowMap>(options.method)) {
    source.depths = true;
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

VisibilityStatistics& VisibilityStatistics::operator+=(const VisibilityStatistics& other) {
  using S = VisibilityStatistics;
  for (const auto count : {&S::processed_faces, &S::samples, &S::rays, &S::corrected_samples, &S::contested_samples,
                           &S::full, &S::partial})
    this->*count += other.*count;
  for (const auto seconds :
       {&S::render_s, &S::build_s, &S::upload_s, &S::readback_s, &S::classify_s, &S::shader_s, &S::claims_s})
    this->*seconds += other.*seconds;
  return *this;
}

struct VisibilityStage::State {
  State(const Mesh& mesh, const VisibilityOptions& options, GraphicsDevice* given)
      : drawing(choose_drawing(mesh, options, given)),
        device(current(drawing.native ? nullptr : given)),
        repeats(std::holds_alternative<Gpvc>(options.method) ? find_repeats(mesh) : Repeats()),
        source(repeats.collapsed ? *repeats.collapsed : mesh, source_options(options, device, repeats.doubled)) {
    const TesterInput input{source, device != nullptr ? &device->info() : nullptr, options.subpixel};
    tester = std::visit([&](const auto& method) { return make_tester(method, input); }, options.method);
  }

  static GraphicsDevice* current(GraphicsDevice* device) {
    if (device != nullptr) device->make_current();
    return device;
  }

  ChosenDrawing drawing;
  GraphicsDevice* device;  ///< null: native drawing
  Repeats repeats;
  ViewSource source;
  std::unique_ptr<ViewTester> tester;
};

VisibilityStage::VisibilityStage(const Mesh& mesh, const VisibilityOptions& options, GraphicsDevice* device) {
  check(options.method);
  validate_faces(mesh);
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
  const PreparedView prepared = state.source.prepare(view, id, excluded, result);
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
