#include "app/cli/option_parts.h"

#include "app/cli/command_options.h"

namespace gpvc::cli {
namespace {

constexpr const char* kVisibilityGroup = "Visibility";

}  // namespace

CLI::Validator not_empty() {
  return CLI::Validator([](std::string& given) { return given.empty() ? std::string("is empty") : std::string(); }, "");
}

void add_common(CLI::App& app, CommonOptions& common) {
  app.add_option("--threads", common.threads, "Threads to use, 1 to 4096")
      ->type_name("N")
      ->check(in_range(1, 4096))
      ->default_str("all")
      ->group(kCommonGroup);
  app.add_option("--device", common.device, "EGL device to render on; --device list prints them and ends")
      ->type_name("N|list")
      ->check(in_range(0, 255))
      ->default_str("0, hardware first")
      ->group(kCommonGroup);
  app.add_option("--log", common.log, "Also write everything that happens, with times, to FILE")
      ->type_name("FILE")
      ->group(kCommonGroup);
  auto* quiet = app.add_flag("-q,--quiet", common.quiet, "Print warnings, errors and results alone");
  auto* verbose = app.add_flag("-v,--verbose", common.verbose, "Print more about each stage");
  quiet->excludes(verbose)->group(kCommonGroup);
  verbose->group(kCommonGroup);
  app.set_version_flag("--version", "gpvc " + program_version())
      ->description("Print the version and end")
      ->group(kCommonGroup);
  app.set_help_flag("-h,--help", "Print this help and end")->group(kCommonGroup);
}

CLI::Option* add_mesh(CLI::App& app, std::filesystem::path& mesh) {
  return app.add_option("MESH", mesh, "Triangle mesh in the cameras' frame, PLY or OBJ");
}

void add_scene(CLI::App& app, SceneInput& input) {
  app.add_option("SCENE", input.scene,
                 "Cameras and photos, told by what is there: a COLMAP model, an OpenSfM or OpenDroneMap "
                 "reconstruction, a ContextCapture BlocksExchange or Agisoft Metashape XML file, an OpenMVS scene "
                 "or a folder of photos with mvs-texturing's .cam files; the file or its folder")
      ->required();
}

void add_masks(CLI::App& app, SceneInput& input) {
  constexpr const char* kGroup = "Input";
  auto* masks_dir = app.add_option("--masks", input.masks_dir,
                                   "Folder of masks of the photos' size, black where a pixel must not be used: "
                                   "NAME.mask.png, NAME without its extension likewise, or NAME.png")
                        ->type_name("DIR")
                        ->default_str("NAME.mask.png beside the photos")
                        ->group(kGroup);
  app.add_flag("!--no-masks", input.masks, "Use every pixel, whatever masks and alpha channels say")
      ->excludes(masks_dir)
      ->group(kGroup);
}

void add_photos(CLI::App& app, SceneInput& input) {
  constexpr const char* kGroup = "Input";
  app.add_option("--images", input.images_dir,
                 "Folder of the photos, at any depth; matched by the longest common tail of their paths")
      ->type_name("DIR")
      ->default_str("where the scene says, or 'images' beside it")
      ->group(kGroup);
  app.add_option("--views", input.views,
                 "Use only these views: names or globs, separated by commas, or @FILE with one a line")
      ->check(not_empty())
      ->type_name("LIST")
      ->group(kGroup);
  app.add_option("--exclude-views", input.exclude_views, "Leave these views out; they keep their index")
      ->type_name("LIST")
      ->group(kGroup);
  app.add_option("--downscale", input.downscale,
                 "Reduce the photos N times in width and height, for a quick look; 1 to 64")
      ->type_name("N")
      ->check(in_range(1, 64))
      ->default_str("1")
      ->group(kGroup);
}

void add_scene_input(CLI::App& app, SceneInput& input) {
  add_scene(app, input);
  add_mesh(app, input.mesh)->required();
  add_photos(app, input);
  add_masks(app, input);
}

void add_output(CLI::App& app, std::filesystem::path& out, bool& force) {
  constexpr const char* kGroup = "Output";
  app.add_option("-o,--output", out, "Folder for the result; made when missing")
      ->type_name("OUT")
      ->required()
      ->check(not_empty())
      ->group(kGroup);
  app.add_flag("--force", force, "Replace an earlier result in OUT once the new one is complete")->group(kGroup);
}

namespace {

using visibility::CoverageCorrection, visibility::Gpvc, visibility::PaperGpvc;

// The gpvc mode step by step, for an option that only gpvc has. Throws what `option` belongs to when the mode is another.
PaperGpvc steps_of(const visibility::Method& method, const std::string& option) {
  if (const auto* paper = std::get_if<PaperGpvc>(&method)) return *paper;
  const auto* gpvc = std::get_if<Gpvc>(&method);
  if (gpvc == nullptr)
    throw CLI::ValidationError(
        option, fmt::format("belongs to the gpvc modes, not to {}", visibility::visibility_mode_name(method)));
  return {gpvc->sampling, visibility::Projection::apc, CoverageCorrection::exact, gpvc->classifier};
}

visibility::Method gpvc_of(const PaperGpvc& steps) {
  if (steps.projection != visibility::Projection::apc || steps.correction != CoverageCorrection::exact) return steps;
  return Gpvc{steps.sampling, visibility::Drawing::automatic, steps.classifier};
}

void set_drawing(visibility::Drawing drawing, visibility::Method& method) {
  const auto refuse = [](const std::string& reason) {
    throw CLI::ValidationError("--drawing", "native does not go with " + reason);
  };
  if (auto* rays = std::get_if<visibility::RayTracing>(&method)) {
    rays->drawing = drawing;
  } else if (auto* none = std::get_if<visibility::NoTest>(&method)) {
    none->drawing = drawing;
  } else if (auto* gpvc = std::get_if<Gpvc>(&method)) {
    if (drawing == visibility::Drawing::native && gpvc->classifier == visibility::Classifier::gpu)
      refuse("--classifier gpu: shaders classify what OpenGL has drawn");
    gpvc->drawing = drawing;
  } else if (drawing == visibility::Drawing::native) {
    const auto* paper = std::get_if<PaperGpvc>(&method);
    if (paper == nullptr) refuse(visibility::visibility_mode_name(method) + ": OpenGL draws its depth map");
    if (paper->correction != CoverageCorrection::exact)
      refuse(fmt::format("--coverage-correction {}: it is about what OpenGL rounds",
                         name_of(visibility::kCoverageCorrectionNames, paper->correction)));
    refuse("--projection spc: only OpenGL draws with it");
  }
}

}  // namespace

void add_visibility(CLI::App& app, visibility::VisibilityOptions& options) {
  visibility::Method& method = options.method;
  const auto set_mode = [&method](const std::string& mode) {
    try {
      method = visibility::parse_visibility_mode(mode);
    } catch (const std::invalid_argument& error) {
      throw CLI::ValidationError("--visibility", error.what());
    }
  };
  app.add_option_function<std::string>(
         "--visibility", set_mode,
         "How visibility is decided. gpvc: without a bias, faces sampled hierarchically, gpvc:ves at their vertices "
         "and "
         "edges only, gpvc:dense at every pixel (same classes as gpvc). For comparison: shadow-map:apc:EPS and "
         "shadow-map:spc:EPS, a depth map with a bias in window depth, 0 to 1 (apc: depth is " +
             fmt::format("{}", visibility::kShadowMapNear) +
             " / z); ray:sparse:EPS and ray:dense:EPS, rays to vertices or pixel centres with a bias in units of the "
             "mesh; none, all that is in the image")
      ->type_name("MODE")
      ->default_str("gpvc")
      ->group(kVisibilityGroup);
  // Options take effect in the order in which they are added, so each one sees the method that those above it chose.
  add_choice(
      app, "--projection", visibility::kProjectionNames,
      [&method](visibility::Projection projection) {
        PaperGpvc steps = steps_of(method, "--projection");
        steps.projection = projection;
        method = gpvc_of(steps);
      },
      "apc",
      "Depth that gpvc draws with: reversed with the near plane at zero, or symmetric with planes that fit the mesh")
      ->group(kVisibilityGroup);
  add_choice(
      app, "--coverage-correction", visibility::kCoverageCorrectionNames,
      [&method](CoverageCorrection correction) {
        PaperGpvc steps = steps_of(method, "--coverage-correction");
        steps.correction = correction;
        method = gpvc_of(steps);
      },
      "exact", "Repair of what the rasterizer's snapping and rounding got wrong in the gpvc modes")
      ->group(kVisibilityGroup);
  add_choice(
      app, "--classifier", visibility::kClassifierNames,
      [&method](visibility::Classifier classifier) {
        PaperGpvc steps = steps_of(method, "--classifier");
        steps.classifier = classifier;
        method = gpvc_of(steps);
      },
      "auto", "Where the gpvc modes classify faces that OpenGL has drawn; the result is the same")
      ->group(kVisibilityGroup);
  add_choice(
      app, "--drawing", visibility::kDrawingNames,
      [&method](visibility::Drawing drawing) { set_drawing(drawing, method); }, "auto",
      "What draws the item buffer. native: a rasterizer on the CPU, which auto takes without graphics hardware; the "
      "classes are the same")
      ->group(kVisibilityGroup);
  app.add_flag("!--no-subpixel", options.subpixel, "Do not resolve faces smaller than a pixel")
      ->group(kVisibilityGroup);
}

void add_edge_weights(CLI::App& app, labeling::EdgeWeights& weights) {
  add_choice(
      app, "--edge-weights", labeling::kEdgeWeightsNames, weights,
      "What the smoothness counts: neighbours, the length of their edge, its flatness (seams hide in folds), or both")
      ->group("View selection");
}

}  // namespace gpvc::cli
