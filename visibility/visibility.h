// Which faces of a mesh a view sees: GPVC (Huang, Zhu, Jiang 2018) on OpenGL through EGL, without window or
// bias, or natively where OpenGL would run on the CPU as well.
//
// Words of the paper, used throughout:
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
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "../io/scene.h"
#include "../io/textured_model.h"

namespace gpvc::visibility {

/// An OpenGL or EGL call that failed: call, code, stage, driver log.
class GpuError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// --- device

struct DeviceInfo {
  int index = 0;          ///< what --device takes
  std::string renderer;   ///< GL_RENDERER
  std::string driver;     ///< GL_VERSION
  bool software = false;  ///< a CPU rasterizer (llvmpipe)
};

/// Every EGL device on which an OpenGL 4.5 core context can be made, hardware first. Never throws for "none": empty.
std::vector<DeviceInfo> list_devices();

/// An OpenGL 4.5 core context without a surface, current on the thread that made it. Movable between no threads.
class GraphicsDevice {
 public:
  /// `device` < 0: the first of list_devices(). Throws GpuError, with a sentence for each EGL step that can fail.
  explicit GraphicsDevice(int device = -1);
  ~GraphicsDevice();
  GraphicsDevice(const GraphicsDevice&) = delete;
  GraphicsDevice& operator=(const GraphicsDevice&) = delete;
  const DeviceInfo& info() const;
  /// Makes the context current again after another one was. Throws GpuError on any thread but its own.
  void make_current() const;

 private:
  struct Context;
  std::unique_ptr<Context> context_;
};

// --- visibility

enum class FaceClass : std::uint8_t {
  hidden = 0,      ///< back-facing, or no in-image sample sees the face
  partial = 1,     ///< everything else
  full = 2,        ///< front-facing, all vertices in front of the camera and in [0,W] x [0,H], every sample sees it
  unresolved = 3,  ///< no pixel centre of the frame in the projection, and sub-pixel resolution is off
};

/// How visibility is decided. gpvc: the paper, without a bias. The others are what it is compared with (sections 1 and
/// 3): a depth map compared with a bias, rays with a bias, and no test at all (every front face inside the image is
/// fully visible).
enum class Method { gpvc, shadow_map, ray, none };
enum class Sampling { hivers, ves, dense };
/// sparse: one ray per vertex; dense: one per covered pixel centre (figure 19).
enum class Rays { sparse, dense };
/// apc: reversed depth, near plane at zero (formula 5). spc: symmetric, with near and far planes adapted to the mesh
/// (formulas 3 and 4, figure 6).
enum class Projection { apc, spc };

/// Near plane N of formula 5 in units of the mesh for Method::shadow_map with Projection::apc: window depth is N / z,
/// which gives the bias its meaning. The value that reproduces table 2. (gpvc, which compares no depths with a bias,
/// draws with a smaller one.)
inline constexpr double kShadowMapNear = 1e-6;

/// off: the IVM as drawn. paper: LPCC alone. exact: every face that covers a pixel centre contests its stored owner, in
/// real arithmetic on the projected vertices; ties go to the lower face index.
enum class CoverageCorrection { off, paper, exact };
/// gpu: compute shaders; what they cannot tell for certain, and meshes above the device's limits, the CPU decides, with
/// the same bits. automatic: the CPU beside a software renderer, shaders on hardware.
enum class Classifier { automatic, cpu, gpu };

/// What draws the IVM. native: a rasterizer of ours, which takes less time than OpenGL does where that runs on the CPU
/// as well. It snaps nothing, and errs where faces are too close to each other for floats or rounding hides on which
/// side of a pixel centre an edge runs; the classes are the same. automatic: that beside a software renderer, where it
/// can be had; OpenGL otherwise.
enum class Drawing { automatic, opengl, native };

struct VisibilityOptions {
  Method method = Method::gpvc;
  Sampling sampling = Sampling::hivers;     ///< gpvc
  Rays rays = Rays::dense;                  ///< ray
  Projection projection = Projection::apc;  ///< gpvc and shadow_map
  /// The bias. shadow_map: of window depth in [0, 1]; ray: world units, a sample is visible when the first intersection
  /// from the camera lies within it of the tested point (or behind that point, where a ray of floats slipped past the
  /// edge of its own face). > 0, finite.
  double epsilon = 0;
  CoverageCorrection correction = CoverageCorrection::exact;
  Classifier classifier = Classifier::automatic;
  Drawing drawing = Drawing::automatic;
  bool subpixel = true;
  /// false: methods that can do without leave ViewVisibility::ivm empty, to be measured on their own.
  bool draw_ivm = true;
};

/// `gpvc`, `gpvc:ves`, `gpvc:dense`, `shadow-map:spc:EPS`, `shadow-map:apc:EPS`, `ray:sparse:EPS`, `ray:dense:EPS` or
/// `none` into `options` (method, sampling, rays, epsilon, and a shadow map's projection; the rest stays). Throws
/// std::invalid_argument: one sentence that quotes the mode and says what was expected.
void set_visibility_mode(std::string_view mode, VisibilityOptions& options);

/// The inverse: epsilon as short as reads back exactly.
std::string visibility_mode_name(const VisibilityOptions& options);

/// Why Drawing::native does not go with the other options; empty when it does.
std::string native_drawing_obstacle(const VisibilityOptions& options);

/// The item buffer of one view. Row-major from the top-left; kNoFace where nothing (or no photo) is.
struct Ivm {
  int width = 0, height = 0;
  std::vector<FaceId> faces;
  FaceId at(int x, int y) const {
    return faces[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
  }
};

/// Where a partially visible face is seen: one bit a pixel over its box of in-image samples.
struct FaceCoverage {
  FaceId face{};
  ViewId view{};
  std::int32_t x0 = 0, y0 = 0;         ///< first pixel of the box
  std::int32_t width = 0, height = 0;  ///< of the box, in pixels
  std::uint32_t visible = 0;           ///< samples that see the face
  float visible_share = 0;     ///< of all its samples, (0, 1]; those outside the image count as hidden, as far as one
                               ///< frame away
  std::size_t first_word = 0;  ///< of its bits in CoverageTable::words; bit y * width + x
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
  std::size_t processed_faces = 0;    ///< faces classified by sampling (recorded by the fragment shader, paper table 9)
  std::size_t samples = 0;            ///< IVM look-ups made (paper: sampling count)
  std::size_t rays = 0;               ///< ray: traced; samples that lie on the same ray share it
  std::size_t corrected_samples = 0;  ///< samples whose stored owner LPCC overruled
  std::size_t contested_samples = 0;  ///< exact: samples of any face compared with a stored owner
  std::size_t full = 0, partial = 0;
  double render_s = 0;    ///< IVM
  double build_s = 0;     ///< ray: the hierarchy around the mesh, built once and counted for the first view
  double upload_s = 0;    ///< to the device; of the mesh once, counted for the first view
  double readback_s = 0;  ///< from the device
  double classify_s = 0;
  double shader_s = 0;  ///< of classify_s: until the compute shaders are done
  double claims_s = 0;  ///< exact, of classify_s: deciding on the CPU what shaders leave open, but for sub-pixel
                        ///< samples and coverage
};

struct ViewVisibility {
  Ivm ivm;                         ///< as rendered, pixels outside the photo cleared; never corrected in place
  std::vector<FaceClass> classes;  ///< per face
  CoverageTable coverage;          ///< of the partial faces
  VisibilityStatistics statistics;
};

/// Visibility of one mesh, view after view. Holds the mesh on the device, unless it draws natively. Must be used on the
/// device's thread; uses all TBB threads inside. The result does not depend on the number of threads or on the
/// classifier.
class VisibilityStage {
 public:
  /// Borrows both. Throws GpuError when the device cannot hold the mesh, std::invalid_argument for options that do not
  /// go together.
  VisibilityStage(GraphicsDevice& device, const Mesh& mesh, const VisibilityOptions& options);
  ~VisibilityStage();
  VisibilityStage(const VisibilityStage&) = delete;
  VisibilityStage& operator=(const VisibilityStage&) = delete;
  /// O(faces + pixels). `view` is stamped into the coverage entries. Images above the GL viewport limit are tiled.
  /// Reads the view's mask or alpha channel, if it has one: throws InputError.
  ViewVisibility classify(const View& view, ViewId id);
  /// The same into `result`, whose memory is used again.
  void classify(const View& view, ViewId id, ViewVisibility& result);
  /// "gpu" or "cpu": what Classifier::automatic chose, and why, for the log.
  std::string classifier_note() const;
  /// Likewise what draws: "opengl" or "native".
  std::string drawing_note() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// --- the oracle

/// What the definition above says, by brute force: every sample of every face against every triangle that covers it, in
/// doubles with error bounds and in exact arithmetic where these cannot tell. No OpenGL, no code shared with the stage.
struct OracleView {
  std::vector<FaceClass> classes;  ///< per face
  std::vector<std::uint8_t> tied;  ///< per face: 1 when an exact tie had a say: a sample within 1e-9 px of an edge, or
                                   ///< two depths within 1e-12 relative (design: reported apart)
  std::size_t samples = 0;         ///< pixel centres and sub-pixel samples decided
};

/// O(faces + the pixels that their projections cover), TBB, about 16 bytes a pixel. Deterministic for any number of
/// threads.
OracleView oracle_visibility(const Mesh& mesh, const View& view);

}  // namespace gpvc::visibility
