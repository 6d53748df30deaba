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

void add_visibility(CLI::App& app, visibility::VisibilityOptions& options) {
  const auto set_mode = [&options](const std::string& mode) {
    try {
      visibility::set_visibility_mode(mode, options);
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
  // Options take effect in the order they are added here, so the mode is known.
  const auto check_projection = [&options](visibility::Projection) {
    if (options.method != visibility::Method::gpvc)
      throw CLI::ValidationError("--projection", fmt::format("belongs to the gpvc modes, not to {}",
                                                             visibility::visibility_mode_name(options)));
  };
  add_choice<visibility::Projection>(
      app, "--projection", visibility::kProjectionNames, options.projection,
      "Depth that gpvc draws with: reversed with the near plane at zero, or symmetric with planes that fit the mesh",
      check_projection)
      ->group(kVisibilityGroup);
  add_choice(app, "--coverage-correction", visibility::kCoverageCorrectionNames, options.correction,
             "Repair of what the rasterizer's snapping and rounding got wrong")
      ->group(kVisibilityGroup);
  add_choice(app, "--classifier", visibility::kClassifierNames, options.classifier,
             "Where faces are classified; the result is the same")
      ->group(kVisibilityGroup);
  const auto check_drawing = [&options](visibility::Drawing drawing) {
    if (const std::string obstacle = visibility::native_drawing_obstacle(options);
        drawing == visibility::Drawing::native && !obstacle.empty())
      throw CLI::ValidationError("--drawing", "native does not go with the other options: " + obstacle);
  };
  add_choice<visibility::Drawing>(
      app, "--drawing", visibility::kDrawingNames, options.drawing,
      "What draws the item buffer of gpvc. native: gpvc's own rasterizer, which auto takes where OpenGL would be "
      "drawn by the CPU as well, and more slowly; the classes are the same",
      check_drawing)
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
