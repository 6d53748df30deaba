// How visibility is found: GPVC, and the methods that it is compared with. visibility.h says what the terms mean.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <variant>

#include "../io/names.h"

namespace gpvc::visibility {

class GraphicsDevice;  // device.h

/// Which samples of a face gpvc looks at. dense looks at every pixel centre and gives the same classes as hivers; ves
/// looks at vertices and edges only and misses what hides the middle of a face.
enum class Sampling { hivers, ves, dense };
/// The names of their visibility modes.
inline constexpr Named<Sampling> kSamplingNames[] = {
    {"gpvc", Sampling::hivers}, {"gpvc:ves", Sampling::ves}, {"gpvc:dense", Sampling::dense}};

/// apc: reversed depth, near plane at zero (formula 5). spc: symmetric, with near and far planes adapted to the mesh
/// (formulas 3 and 4, figure 6).
enum class Projection { apc, spc };
inline constexpr Named<Projection> kProjectionNames[] = {{"apc", Projection::apc}, {"spc", Projection::spc}};

/// How errors of the drawn IVM are repaired. off: not at all. paper: by LPCC alone. exact: every face that covers a pixel
/// centre contests its stored owner in real arithmetic on the projected vertices; ties go to a face that shows its front,
/// then to the lower index.
enum class CoverageCorrection { off, paper, exact };
inline constexpr Named<CoverageCorrection> kCoverageCorrectionNames[] = {
    {"off", CoverageCorrection::off}, {"paper", CoverageCorrection::paper}, {"exact", CoverageCorrection::exact}};

/// Which processor classifies. gpu: compute shaders, what OpenGL has drawn; the CPU decides what they leave open, and
/// everything for meshes above the device's limits, with the same bits. automatic: the CPU if OpenGL is
/// software-rendered or the mesh is above those limits, else shaders.
enum class Classifier { automatic, cpu, gpu };
inline constexpr Named<Classifier> kClassifierNames[] = {
    {"auto", Classifier::automatic}, {"cpu", Classifier::cpu}, {"gpu", Classifier::gpu}};

/// What draws the IVM. native: a rasterizer on the CPU that needs no OpenGL and is faster than software-rendered OpenGL.
/// Its IVM may differ from OpenGL's where float depths tie or an edge passes within rounding of a pixel centre; the
/// classes do not. automatic: OpenGL on graphics hardware, native without.
enum class Drawing { automatic, opengl, native };
inline constexpr Named<Drawing> kDrawingNames[] = {
    {"auto", Drawing::automatic}, {"opengl", Drawing::opengl}, {"native", Drawing::native}};

/// The paper's method with the exact coverage correction, without a bias.
struct Gpvc {
  Sampling sampling = Sampling::hivers;
  Drawing drawing = Drawing::automatic;
  /// With Drawing::automatic, Classifier::gpu draws with OpenGL and Classifier::cpu natively, which is faster for it than
  /// to read back what OpenGL draws. Classifier::gpu with Drawing::native is refused.
  Classifier classifier = Classifier::automatic;
};

/// The paper's method step by step: drawn by OpenGL, whose snapping and rounding the corrections repair.
struct PaperGpvc {
  Sampling sampling = Sampling::hivers;
  Projection projection = Projection::apc;
  CoverageCorrection correction = CoverageCorrection::paper;
  Classifier classifier = Classifier::automatic;
};

/// What gpvc is compared with (section 1): a depth map drawn by OpenGL and compared with a bias.
struct ShadowMap {
  Projection projection = Projection::apc;
  double epsilon = 0;  ///< the bias, in window depth from 0 to 1; > 0, finite
};

/// Near plane N of formula 5 in units of the mesh for ShadowMap with Projection::apc: window depth is N / z, which gives
/// the bias its meaning. This value reproduces table 2. (gpvc compares no depths with a bias and draws with a smaller
/// one.)
inline constexpr double kShadowMapNear = 1e-6;

/// sparse: one ray per vertex; dense: one per covered pixel centre (figure 19).
enum class RaySampling { sparse, dense };
inline constexpr Named<RaySampling> kRaySamplingNames[] = {{"sparse", RaySampling::sparse},
                                                           {"dense", RaySampling::dense}};

/// What gpvc is compared with (section 3): rays from the camera. A sample is visible when the first intersection is
/// nearer than it by no more than the bias. One behind it counts, too: in floats a ray can miss the face that it was sent to.
struct RayTracing {
  RaySampling sampling = RaySampling::dense;
  double epsilon = 0;  ///< the bias, in world units; > 0, finite
  Drawing drawing = Drawing::automatic;
};

/// No test at all: every front face inside the image is fully visible.
struct NoTest {
  Drawing drawing = Drawing::automatic;
};

using Method = std::variant<Gpvc, PaperGpvc, ShadowMap, RayTracing, NoTest>;

struct VisibilityOptions {
  Method method;
  bool subpixel = true;  ///< resolve faces that cover no pixel centre
  /// false: RayTracing, NoTest and ShadowMap leave ViewVisibility::ivm empty, so that they can be measured on their own.
  bool draw_ivm = true;
};

/// Reads `gpvc`, `gpvc:ves`, `gpvc:dense`, `shadow-map:spc:EPS`, `shadow-map:apc:EPS`, `ray:sparse:EPS`,
/// `ray:dense:EPS` or `none`. Throws std::invalid_argument: one sentence that quotes the mode and says what was
/// expected.
Method parse_visibility_mode(std::string_view mode);

/// The name that parse_visibility_mode() reads, with the shortest epsilon that reads back exactly. PaperGpvc has the
/// name of Gpvc with its sampling.
std::string visibility_mode_name(const Method& method);

/// The device that these options draw on: number `device` of list_devices() if it is not negative, else the first one
/// if the options need OpenGL, else the first one that is graphics hardware. Null where native drawing serves. Throws
/// GpuError: one sentence that says what needs a device and what is missing.
std::unique_ptr<GraphicsDevice> find_device(const VisibilityOptions& options, int device = -1);

}  // namespace gpvc::visibility
