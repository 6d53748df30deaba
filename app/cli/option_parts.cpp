#include "app/cli/option_parts.h"

#include <nlohmann/json.hpp>
#include <optional>

#include "app/cli/command_options.h"
#include "app/results/observer.h"

namespace gpvc::cli {

CLI::Validator not_empty() {
  return CLI::Validator([](std::string& given) { return given.empty() ? std::string("is empty") : std::string(); }, "");
}

std::size_t bytes_from(const std::string& option, const std::string& given) {
  const std::optional<std::size_t> bytes = results::bytes_from_text(given);
  if (!bytes) throw CLI::ValidationError(option, fmt::format("'{}' is no amount of memory such as 600M or 4G", given));
  return *bytes;
}

void add_common(CLI::App& app, CommonOptions& common, const std::string& footer) {
  const OptionGroup machine{app, pipeline::kMachine}, group{app, kCommonGroup};
  machine.number("--threads", common.threads, 1, 4096, "N", "Threads to use, 1 to 4096")->default_str("all");
  machine
      .number("--device", common.device, 0, 255, "N|list",
              "EGL device to render on; --device list prints them and ends")
      ->default_str("0, hardware first");
  group.add("--log", common.log, "FILE", "Also write every message and progress report, with its time, to FILE");
  CLI::Option* quiet = group.flag("-q,--quiet", common.quiet, "Print only warnings, errors and results");
  group.flag("-v,--verbose", common.verbose, "Print more about each stage")->excludes(quiet);
  app.set_version_flag("--version", "gpvc " + program_version())
      ->description("Print the version and end")
      ->group(kCommonGroup);
  app.set_help_flag("-h,--help", "Print this help and end")->group(kCommonGroup);
  app.footer(footer + kExitStatus);
}

void add_scene(CLI::App& app, SceneInput& input) {
  app.add_option(
         "SCENE", input.scene,
         "Cameras and photos, a file or its folder; the format is recognized: a COLMAP model, an OpenSfM or "
         "OpenDroneMap reconstruction, WebODM's all.zip, a ContextCapture BlocksExchange XML or XMLZ or Agisoft "
         "Metashape XML file, MicMac's orientations, Pix4Dmapper's calibrated_camera_parameters.txt, an OPF project, "
         "RealityCapture's camera parameters .csv, a Meshroom or OpenMVG scene, a transforms.json of nerfstudio or "
         "instant-ngp, a VisualSFM .nvm, a Bundler .out, an MVE or OpenMVS scene, or a folder of photos with "
         "RealityCapture's .xmp or mvs-texturing's .cam files")
      ->required();
}

CLI::Option* add_mesh(CLI::App& app, std::filesystem::path& mesh) {
  return app.add_option(
      "MESH", mesh,
      "Triangle mesh (PLY, OBJ, STL, OFF, GLB, glTF) or a folder of tiles, in the cameras' coordinates or in a "
      "reference system (--mesh-crs)");
}

void add_masks(CLI::App& app, SceneInput& input) {
  const OptionGroup group{app, pipeline::kInput};
  CLI::Option* masks_dir =
      group
          .add("--masks", input.masks_dir, "DIR",
               "Folder of masks as large as the photos, black where a pixel must not be used (darker than half is "
               "black): NAME.mask.png, NAME_mask.png, NAME.png or NAME, with or without the photo's extension, also "
               "JPEG or TIFF")
          ->default_str("NAME.mask.png beside the photos, or ../masks/NAME.EXT.png");
  group.flag("!--no-masks", input.masks, "Use every pixel: ignore masks and alpha channels")->excludes(masks_dir);
}

void add_bands(CLI::App& app, SceneInput& input) {
  const OptionGroup group{app, pipeline::kInput};
  const auto take = [&input](const std::vector<std::string>& given) {
    for (const std::string& each : given) {
      const std::size_t equals = each.find('=');
      if (given.size() == 1 && each == "none") {
        input.bands_by_name = false;
      } else if (equals == std::string::npos || equals == 0 || equals + 1 == each.size()) {
        throw CLI::ValidationError("--bands", fmt::format("'{}' is no NAME=DIR, nor none", each));
      } else {
        input.bands.push_back({each.substr(0, equals), each.substr(equals + 1)});
      }
    }
  };
  app.add_option_function<std::vector<std::string>>(
         "--bands", take,
         "Take the photos' band NAME from the files in DIR that are called like the photos; once for each band. What "
         "they "
         "show registers them to the photos. none: each photo's file holds all of its bands")
      ->type_name("NAME=DIR")
      ->default_str("files beside the photos that are called like them but for a band, as cameras name them")
      ->allow_extra_args(false)
      ->group(pipeline::kInput);
  group
      .add("--composite", input.composite, "R,G,B",
           "Bands that are looked at as red, green and blue, by name or number, or one as grey, of photos that hold "
           "more "
           "than colours of 8 bits")
      ->delimiter(',')
      ->default_str("bands called red, green, blue; else near infrared, red, green; else the first three")
      ->allow_extra_args(false);
}

void add_skipping(CLI::App& app, SceneInput& input) {
  OptionGroup{app, pipeline::kInput}.flag(
      "--skip-bad-photos", input.skip_bad_photos,
      "Go on without photos that are missing, damaged or of another shape; decodes all of them beforehand");
}

void add_mesh_crs(const OptionGroup& group, SceneInput& input, const std::string& meaning) {
  group.add("--mesh-crs", input.mesh_crs, "CRS", meaning)
      ->default_str("the scene's, or what fits it")
      ->check(not_empty());
}

void add_photos(CLI::App& app, SceneInput& input) {
  const OptionGroup group{app, pipeline::kInput};
  group
      .add("--images", input.images_dir, "DIR",
           "Folder of the photos with its sub-folders. Photos are found by name; where names repeat, by their folders, "
           "too")
      ->default_str("where the scene says, or 'images' beside it");
  group
      .add("--views", input.views, "LIST",
           "Use only these views: names or globs, separated by commas, or @FILE with one on each line")
      ->check(not_empty());
  group.add("--exclude-views", input.exclude_views, "LIST",
            "Leave these views out; the numbers of the others stay as they are");
  if (app.get_option_no_throw("MESH") != nullptr)
    add_mesh_crs(
        group, input,
        "Reference system of the mesh (EPSG:25832, a WKT or PROJ string), if it is not the cameras'. Models keep the "
        "mesh's coordinates, tilesets have the cameras'. Heights may be above either ellipsoid: the one that "
        "fits is taken");
  add_skipping(app, input);
  group.number("--downscale", input.downscale, 1, 64, "N",
               "Reduce the photos N times in width and height, for a quick look; 1 to 64");
  add_masks(app, input);
  add_bands(app, input);
}

void add_output(CLI::App& app, CommandOptions& options) {
  const OptionGroup group{app, pipeline::kOutput};
  group.add("-o,--output", options.out, "OUT", "Folder for the result; created if missing")
      ->required()
      ->check(not_empty());
  group.flag("--force", options.force, "Replace an earlier result in OUT once the new one is complete");
}

namespace {

using visibility::CoverageCorrection, visibility::Gpvc, visibility::PaperGpvc;

// The gpvc mode step by step, for an option that only gpvc has. Throws an error about `option` for another mode.
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

// An option that sets one step of the gpvc mode.
template <class Value, std::size_t kCount>
void add_step(const OptionGroup& group, const std::string& name, const Named<Value> (&names)[kCount],
              Value PaperGpvc::*step, visibility::Method& method, const std::string& text) {
  const auto set = [&method, name, step](Value value) {
    PaperGpvc steps = steps_of(method, name);
    steps.*step = value;
    method = gpvc_of(steps);
  };
  group.choice(name, names, set, steps_of(Gpvc{}, name).*step, text);
}

void set_drawing(visibility::Drawing drawing, visibility::Method& method) {
  const auto refuse = [](const std::string& reason) {
    throw CLI::ValidationError("--drawing", "native does not go with " + reason);
  };
  const bool native = drawing == visibility::Drawing::native;
  const auto* gpvc = std::get_if<Gpvc>(&method);
  if (native && gpvc != nullptr && gpvc->classifier == visibility::Classifier::gpu)
    refuse("--classifier gpu: shaders classify what OpenGL has drawn");
  const auto* paper = std::get_if<PaperGpvc>(&method);
  if (native && paper != nullptr && paper->correction != CoverageCorrection::exact)
    refuse(fmt::format("--coverage-correction {}: it is about what OpenGL rounds",
                       name_of(visibility::kCoverageCorrectionNames, paper->correction)));
  if (native && paper != nullptr) refuse("--projection spc: only OpenGL draws with it");
  std::visit(
      [&](auto& any) {
        if constexpr (requires { any.drawing; })
          any.drawing = drawing;
        else if (native)
          refuse(visibility::visibility_mode_name(method) + ": OpenGL draws its depth map");
      },
      method);
}

}  // namespace

void add_method(CLI::App& app, visibility::Method& method) {
  const OptionGroup group{app, pipeline::kResearch};
  const auto set_mode = [&method](const std::string& mode) {
    try {
      method = visibility::parse_visibility_mode(mode);
    } catch (const std::invalid_argument& error) {
      throw CLI::ValidationError("--visibility", error.what());
    }
  };
  group.parsed(
      "--visibility", set_mode, "MODE", "gpvc",
      fmt::format("How visibility is decided. gpvc: without a bias, with hierarchical sampling of faces; gpvc:ves "
                  "samples only their vertices and edges, gpvc:dense every pixel (the same classes as gpvc). "
                  "For comparison: shadow-map:apc:EPS and shadow-map:spc:EPS, a depth map with a bias in "
                  "window depth, 0 to 1 (apc: depth is {} / z); ray:sparse:EPS and ray:dense:EPS, rays to "
                  "vertices or pixel centres with a bias in units of the mesh; none, every face in the frame",
                  visibility::kShadowMapNear));
  // Options take effect in the order in which they are added, so each one sees the method that those above it chose.
  add_step(
      group, "--projection", visibility::kProjectionNames, &PaperGpvc::projection, method,
      "Depth that gpvc draws with: apc is reversed with the near plane at zero, spc symmetric with planes that fit "
      "the mesh");
  add_step(group, "--coverage-correction", visibility::kCoverageCorrectionNames, &PaperGpvc::correction, method,
           "How the gpvc modes correct pixels that the rasterizer's snapping and rounding gave to the wrong face");
  add_step(group, "--classifier", visibility::kClassifierNames, &PaperGpvc::classifier, method,
           "What classifies faces in the gpvc modes. gpu: shaders, what OpenGL has drawn; cpu: draws natively, too, "
           "unless --drawing opengl; the classes are the same");
  group.choice(
      "--drawing", visibility::kDrawingNames, [&method](visibility::Drawing drawing) { set_drawing(drawing, method); },
      visibility::Drawing::automatic,
      "What draws the item buffer. native: a rasterizer on the CPU, which auto takes without graphics hardware; the "
      "classes are the same");
}

evaluate::Json method_json(const visibility::Method& method) {
  visibility::PaperGpvc steps{{}, {}, visibility::CoverageCorrection::exact, {}};
  auto drawing = visibility::Drawing::automatic;
  std::visit(
      [&](const auto& any) {
        if constexpr (requires { any.projection; }) steps.projection = any.projection;
        if constexpr (requires { any.correction; }) steps.correction = any.correction;
        if constexpr (requires { any.classifier; }) steps.classifier = any.classifier;
        if constexpr (requires { any.drawing; }) drawing = any.drawing;
      },
      method);
  return {{"visibility", visibility::visibility_mode_name(method)},
          {"projection", name_of(visibility::kProjectionNames, steps.projection)},
          {"coverage_correction", name_of(visibility::kCoverageCorrectionNames, steps.correction)},
          {"classifier", name_of(visibility::kClassifierNames, steps.classifier)},
          {"drawing", name_of(visibility::kDrawingNames, drawing)}};
}

void add_rules(CLI::App& app, std::filesystem::path& allow) {
  OptionGroup{app, pipeline::kQuality}
      .add("--allow", allow, "FILE",
           "Rules (JSON, GeoJSON or CSV): which photos alone may texture a part of the mesh, or may not; see below")
      ->check(not_empty());
}

void add_earlier_names(CLI::App& app, pipeline::Settings& settings, CommonOptions& common) {
  const auto keep_views = [&settings, &common] {
    settings.costs.keep_odd_views = settings.allow_misfit = true;
    common.notes.emplace_back(
        "--keep-views is now --keep-odd-photos and --allow-misfit, and does both for this version");
  };
  app.add_flag_callback("--keep-views", keep_views)->group("");
}

const char* const kRulesHelp =
    R"(A line of --allow FILE is one of (about faces whose middle lies inside; several rules all apply):
  box,X Y Z X Y Z,forbid,PHOTO;PHOTO...        polygon,X Y X Y X Y...,allow,PHOTO;PHOTO...
  faces,7 100-120 ...,forbid,PHOTO...          PHOTO: a name or glob, as in --views
  faces,@LIST,forbid,PHOTO...  LIST: a text file of such numbers, beside FILE
  photo,PHOTO X Y X Y          what PHOTO shows in that rectangle of its pixels: not from PHOTO
or the file is {"rules": [{"polygon": [[X, Y], ...], "z": [LOW, HIGH], "forbid": [PHOTO, ...]}, ...]},
or GeoJSON whose polygons have a property "allow" or "forbid". Coordinates are those of MESH.

)";

}  // namespace gpvc::cli
