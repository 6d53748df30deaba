// Which faces of a mesh a view sees: GPVC (Huang, Zhu, Jiang 2018), without a bias, drawn by OpenGL without a window or
// natively on the CPU; and the methods that it is compared with.
//
// Terms of the paper, used throughout:
//   IVM     initial visibility map: per pixel the index of the face drawn there (section 2.1)
//   LEF     linear edge function (formula 6); TLR: top-left rule (figure 10)
//   LPCC    lazy-projection coverage correction (algorithm 1)
//   HIVERS  hierarchical iterative vertex-edge-region sampling (algorithm 2); VES: vertices and edges only
//   APC     asymmetric projection configuration: reversed depth, near plane at zero (formula 5)
// Deviation from formula 12: clip coordinates keep w = z, so the rasterizer clips at the camera plane.
//
// Samples of a face in a view: the pixels of the frame whose centres lie in its projection (TLR for centres exactly on
// an edge), after clipping at z > 0. A face that reaches the frame but covers no pixel centre of it takes, when sub-pixel
// resolution is on, the centroid and the midpoints from the centroid to the three vertices; those that project outside
// the frame see nothing. A pixel is in the image when its centre, distorted, lies in the photo, on a pixel that neither
// the view's mask nor the photo's alpha excludes.
// A degenerate face, or one seen edge-on to the accuracy of doubles (thinner than about 1e-11 px), is hidden
// and hides nothing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "../io/names.h"
#include "../io/photos.h"
#include "../io/scene.h"

namespace gpvc::visibility {

class GraphicsDevice;  // device.h

enum class FaceClass : std::uint8_t {
  hidden = 0,      ///< back-facing, or no in-image sample sees the face
  partial = 1,     ///< everything else
  full = 2,        ///< front-facing, all vertices in front of the camera and in [0,W] x [0,H], every sample sees it
  unresolved = 3,  ///< no pixel centre of the frame in the projection, and sub-pixel resolution is off
};

// --- methods

/// Which samples of a face gpvc looks at. dense looks at every pixel centre and gives the same classes as hivers; ves
/// looks at vertices and edges only and misses what hides the middle of a face.
enum class Sampling { hivers, ves, dense };
/// The visibility modes of these.
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

/// What gpvc is compared with (section 3): rays from the camera. A sample is visible when the first intersection lies
/// within the bias of it, or behind it, where a ray of floats slipped past the edge of its own face.
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

// --- results

/// The item buffer of one view. Row-major from the top-left; kNoFace where nothing (or no photo) is.
struct Ivm {
  int width = 0, height = 0;
  std::vector<FaceId> faces;
  FaceId at(int x, int y) const {
    return faces[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
  }
};

/// The pixels in which a partially visible face is seen: one bit per pixel of the bounding box of its in-image samples.
struct FaceCoverage {
  FaceId face{};
  ViewId view{};
  std::int32_t x0 = 0, y0 = 0;         ///< first pixel of the box
  std::int32_t width = 0, height = 0;  ///< of the box, in pixels
  std::uint32_t visible = 0;           ///< samples in which the face is seen
  float visible_share = 0;  ///< of all its samples, in (0, 1]; those outside the image, up to one frame away, count as
                            ///< hidden
  std::size_t first_word = 0;  ///< in CoverageTable::words; pixel (x, y) of the box is bit y * width + x
};

/// Faces of class partial, in face order within a view.
struct CoverageTable {
  std::vector<FaceCoverage> entries;
  std::vector<std::uint64_t> words;
  bool sees(const FaceCoverage& entry, int x, int y) const {
    const std::int64_t column = std::int64_t{x} - entry.x0, row = std::int64_t{y} - entry.y0;
    if (column < 0 || row < 0 || column >= entry.width || row >= entry.height) return false;
    const std::size_t bit = static_cast<std::size_t>(row * entry.width + column);
    return (words[entry.first_word + bit / 64] >> (bit % 64)) & 1u;
  }
};

struct VisibilityStatistics {
  std::size_t processed_faces = 0;    ///< faces classified by sampling (paper table 9)
  std::size_t samples = 0;            ///< IVM look-ups (paper: sampling count)
  std::size_t rays = 0;               ///< rays traced; samples on the same ray share it
  std::size_t corrected_samples = 0;  ///< samples whose stored owner LPCC corrected
  std::size_t contested_samples = 0;  ///< exact correction: comparisons of a sample with a stored owner
  std::size_t full = 0, partial = 0;
  double render_s = 0;    ///< drawing the IVM
  double build_s = 0;     ///< rays: building the hierarchy of the mesh; once, counted for the first view
  double upload_s = 0;    ///< to the device; the mesh once, counted for the first view
  double readback_s = 0;  ///< from the device
  double classify_s = 0;
  double shader_s = 0;  ///< part of classify_s: the compute shaders
  double claims_s = 0;  ///< part of classify_s: CPU time for what shaders or native drawing left undecided, without
                        ///< sub-pixel samples and coverage

  VisibilityStatistics& operator+=(const VisibilityStatistics& other);
};

struct ViewVisibility {
  /// Pixels outside the photo are cleared. Gpvc: the face that each pixel centre sees, in real arithmetic, whatever drew
  /// it. Other methods: as drawn.
  Ivm ivm;
  std::vector<FaceClass> classes;  ///< per face
  CoverageTable coverage;          ///< the pixels of the partial faces
  VisibilityStatistics statistics;
};

/// Visibility of one mesh, view after view. With a device it holds the mesh there and must be used on the device's
/// thread. Uses all TBB threads inside; the result does not depend on their number or on the classifier.
class VisibilityStage {
 public:
  /// Borrows mesh and device. Without a device, as find_device() gives it, everything is drawn natively. Throws GpuError
  /// when the options need OpenGL and there is no device, or when it cannot hold the mesh; std::invalid_argument when a
  /// bias is not positive and finite, or when Gpvc asks for native drawing and shaders.
  VisibilityStage(const Mesh& mesh, const VisibilityOptions& options, GraphicsDevice* device = nullptr);
  ~VisibilityStage();
  VisibilityStage(const VisibilityStage&) = delete;
  VisibilityStage& operator=(const VisibilityStage&) = delete;
  /// O(faces + pixels). Coverage entries carry `id`. `excluded`: pixels of the photo that count as outside it, at the
  /// camera's size, as io::PhotoSource::exclusion() gives them; null where all may be used. Images above the GL viewport
  /// limit are drawn in tiles. Throws std::invalid_argument when `excluded` has another size than the camera.
  ViewVisibility classify(const View& view, ViewId id, const io::PhotoExclusion* excluded);
  /// Does the same and reuses the memory of `result`.
  void classify(const View& view, ViewId id, const io::PhotoExclusion* excluded, ViewVisibility& result);
  /// "gpu" or "cpu", a colon and the reason, for the log.
  std::string classifier_note() const;
  /// "opengl" or "native", a colon and the reason, for the log.
  std::string drawing_note() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace gpvc::visibility
