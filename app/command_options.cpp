#include "app/command_options.h"

#include <fmt/format.h>

#include <cstdio>
#include <functional>
#include <iterator>

namespace gpvc {
namespace {

constexpr const char* kVisibilityGroup = "Visibility";

template <class Value>
struct Choice {
  const char* name;
  Value value;
};

// A number of the type within bounds. Unlike CLI::Range it refuses NaN, says what it wanted, and keeps out of
// the help.
template <class Value>
CLI::Validator in_range(Value least, Value most) {
  const std::string kind = std::is_integral_v<Value> ? "a whole number" : "a number";
  return CLI::Validator(
      [least, most, kind](std::string& given) {
        Value value{};
        if (CLI::detail::lexical_cast(given, value) && value >= least && value <= most) return std::string();
        return fmt::format("'{}' is not {} from {} to {}", given, kind, least, most);
      },
      "");
}

CLI::Validator not_empty() {
  return CLI::Validator(
      [](std::string& given) { return given.empty() ? std::string("is empty") : std::string(); }, "");
}

// An option that takes one of a few words.
template <class Value, std::size_t kCount>
CLI::Option* add_choice(CLI::App& app, const std::string& name, const Choice<Value> (&choices)[kCount],
                        std::function<void(Value)> set, const std::string& fallback,
                        const std::string& text) {
  std::string words;
  for (const auto& choice : choices) words += (words.empty() ? "" : "|") + std::string(choice.name);
  const std::vector<Choice<Value>> known(std::begin(choices), std::end(choices));
  const auto parse = [known, set, words, name](const std::string& given) {
    for (const auto& choice : known)
      if (given == choice.name) return set(choice.value);
    throw CLI::ValidationError(name, fmt::format("'{}' is none of {}", given, words));
  };
  return app.add_option_function<std::string>(name, parse, text)->type_name(words)->default_str(fallback);
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
                 "COLMAP model: a folder with cameras and images as .bin or .txt (PINHOLE, SIMPLE_PINHOLE, "
                 "SIMPLE_RADIAL, "
                 "RADIAL, OPENCV)")
      ->required();
}

void add_photos(CLI::App& app, SceneInput& input) {
  constexpr const char* kGroup = "Input";
  app.add_option("--images", input.images_dir, "Folder of the photos")
      ->type_name("DIR")
      ->default_str("'images' beside the model")
      ->group(kGroup);
  app.add_option("--views", input.views,
                 "Use only these views: names or globs, separated by commas, or @FILE with one a line")
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
}

void add_output(CLI::App& app, std::filesystem::path& out, bool& force) {
  constexpr const char* kGroup = "Output";
  app.add_option("-o,--output", out, "Folder for the result; made when missing")
      ->type_name("OUT")
      ->required()
      ->check(not_empty())
      ->group(kGroup);
  app.add_flag("--force", force, "Replace an earlier result in OUT once the new one is complete")
      ->group(kGroup);
}

void add_visibility(CLI::App& app, VisibilityOptions& options) {
  constexpr Choice<Sampling> kSamplings[] = {
      {"gpvc", Sampling::hivers}, {"gpvc:ves", Sampling::ves}, {"gpvc:dense", Sampling::dense}};
  constexpr Choice<CoverageCorrection> kCorrections[] = {{"off", CoverageCorrection::off},
                                                         {"paper", CoverageCorrection::paper},
                                                         {"exact", CoverageCorrection::exact}};
  constexpr Choice<Classifier> kClassifiers[] = {
      {"auto", Classifier::automatic}, {"cpu", Classifier::cpu}, {"gpu", Classifier::gpu}};
  add_choice<Sampling>(
      app, "--visibility", kSamplings, [&](Sampling v) { options.sampling = v; }, "gpvc",
      "How faces are sampled: hierarchically (same classes as dense), at vertices and edges only, or at "
      "every pixel")
      ->group(kVisibilityGroup);
  std::string fallback;
  for (const auto& choice : kCorrections)
    if (choice.value == VisibilityOptions{}.correction) fallback = choice.name;
  add_choice<CoverageCorrection>(
      app, "--coverage-correction", kCorrections, [&](CoverageCorrection v) { options.correction = v; },
      fallback, "Repair of what the rasterizer's snapping and rounding got wrong")
      ->group(kVisibilityGroup);
  add_choice<Classifier>(
      app, "--classifier", kClassifiers, [&](Classifier v) { options.classifier = v; }, "auto",
      "Where faces are classified; the result is the same")
      ->group(kVisibilityGroup);
  app.add_flag("!--no-subpixel", options.subpixel, "Do not resolve faces smaller than a pixel")
      ->group(kVisibilityGroup);
}

void add_edge_weights(CLI::App& app, EdgeWeights& weights) {
  constexpr Choice<EdgeWeights> kWeights[] = {{"uniform", EdgeWeights::uniform},
                                              {"length", EdgeWeights::length},
                                              {"dihedral", EdgeWeights::dihedral},
                                              {"both", EdgeWeights::length_dihedral}};
  add_choice<EdgeWeights>(
      app, "--edge-weights", kWeights, [&](EdgeWeights v) { weights = v; }, "uniform",
      "What the smoothness counts: neighbours, the length of their edge, its flatness (seams hide in folds), "
      "or "
      "both")
      ->group("View selection");
}

void add_selection(CLI::App& app, TextureOptions& options) {
  constexpr const char* kGroup = "View selection";
  constexpr Choice<DataTerm> kTerms[] = {
      {"area", DataTerm::area}, {"gmi", DataTerm::gmi}, {"gmi-angle", DataTerm::gmi_angle}};
  constexpr Choice<Outliers> kOutliers[] = {
      {"none", Outliers::none}, {"damp", Outliers::damp}, {"clamp", Outliers::clamp}};
  constexpr const char* kTermNames[] = {"area", "gmi", "gmi-angle"};
  constexpr const char* kOutlierNames[] = {"none", "damp", "clamp"};
  add_choice<DataTerm>(
      app, "--data-term", kTerms, [&](DataTerm v) { options.costs.term = v; },
      kTermNames[static_cast<std::size_t>(CostOptions{}.term)],
      "What makes a view good for a face: its area in pixels, the image gradient integrated over it, or that "
      "weighted by "
      "the viewing angle")
      ->group(kGroup);
  add_choice<Outliers>(
      app, "--outliers", kOutliers, [&](Outliers v) { options.costs.outliers = v; },
      kOutlierNames[static_cast<std::size_t>(CostOptions{}.outliers)],
      "Views that disagree in colour with the others (cars, people): keep, make dearer, or drop")
      ->group(kGroup);
  app.add_option("--smoothness", options.solver.smoothness,
                 "Price of two neighbouring faces with different views; 0 and up")
      ->type_name("X")
      ->check(in_range(0.0, 1e6))
      ->default_str(fmt::format("{}", SolverOptions{}.smoothness))
      ->group(kGroup);
  add_edge_weights(app, options.edge_weights);
  app.add_option(
         "--margin", options.costs.margin_px,
         "Pixels along silhouettes in which a view costs more, as photo and mesh disagree there; 0 is off")
      ->type_name("PX")
      ->check(in_range(0, 64))
      ->default_str(std::to_string(CostOptions{}.margin_px))
      ->group(kGroup);
}

void add_texture_output(CLI::App& app, TextureOptions& options) {
  constexpr const char* kGroup = "Texture";
  constexpr Choice<SeamLeveling> kSeams[] = {
      {"none", SeamLeveling::none}, {"global", SeamLeveling::global}, {"full", SeamLeveling::full}};
  constexpr Choice<ImageFormat> kFormats[] = {{"jpg", ImageFormat::jpg}, {"png", ImageFormat::png}};
  constexpr Choice<std::optional<UpAxis>> kUps[] = {
      {"auto", std::nullopt}, {"+x", UpAxis::pos_x}, {"-x", UpAxis::neg_x}, {"+y", UpAxis::pos_y},
      {"-y", UpAxis::neg_y},  {"+z", UpAxis::pos_z}, {"-z", UpAxis::neg_z}};
  app.add_option("--page-size", options.atlas.page_size,
                 "Largest edge of a texture page, 256 to 32768 texels")
      ->type_name("N")
      ->check(in_range(256, 32768))
      ->default_str(std::to_string(AtlasOptions{}.page_size))
      ->group(kGroup);
  app.add_option("--padding", options.atlas.padding,
                 "Texels around a chart that carry its colours on, 1 to 64")
      ->type_name("N")
      ->check(in_range(1, 64))
      ->default_str(std::to_string(AtlasOptions{}.padding))
      ->group(kGroup);
  add_choice<SeamLeveling>(
      app, "--seams", kSeams, [&](SeamLeveling v) { options.atlas.seams = v; }, "full",
      "Levelling of colour across seams: none, one correction per chart and vertex, or that and a blend near "
      "the seam")
      ->group(kGroup);
  add_choice<ImageFormat>(
      app, "--texture", kFormats, [&](ImageFormat v) { options.texture = v; }, "jpg",
      "Format of the pages: jpg is what photos were and quick to write and load, png loses nothing more")
      ->group(kGroup);
  app.add_option("--quality", options.quality, "Of jpg pages, 1 to 100")
      ->type_name("N")
      ->check(in_range(1, 100))
      ->default_str("95")
      ->group(kGroup);
  add_choice<std::optional<UpAxis>>(
      app, "--up", kUps, [&](std::optional<UpAxis> v) { options.up = v; }, "auto",
      "Axis of the scene that points up in the GLB; auto: away from the cameras' mean viewing direction")
      ->group(kGroup);
}

}  // namespace

CLI::App* add_texture(CLI::App& parent, TextureOptions& options) {
  CLI::App* app = parent.add_subcommand("texture", "texture a triangle mesh from calibrated photos");
  add_scene_input(*app, options.input);
  add_output(*app, options.out, options.force);
  add_texture_output(*app, options);
  add_selection(*app, options);
  add_visibility(*app, options.visibility);
  add_common(*app, options.common);
  app->footer(
      std::string(
          "Examples:\n"
          "  gpvc texture colmap/sparse/0 mesh.ply --images photos -o out\n"
          "  gpvc texture colmap mesh.ply -o look --downscale 4 --views 'DJI_00[12]*'\n"
          "  gpvc texture colmap mesh.ply -o out --texture png --page-size 4096 --force\n\n"
          "Writes to OUT: model.obj, model.mtl, model_N.jpg, model.glb, preview.png, views.json,\n"
          "labels.npy (view per face), tags.npy (0 seen, 1 partly, 2 filled), faces.npy (GLB triangle\n"
          "to input face), offset.txt where coordinates are large, run.json.\n\n") +
      kExitStatus);
  return app;
}

CLI::App* add_visibility_command(CLI::App& parent, VisibilityCommandOptions& options) {
  CLI::App* app = parent.add_subcommand("visibility", "say which faces of a mesh each photo sees");
  add_scene_input(*app, options.input);
  add_output(*app, options.out, options.force);
  app->add_flag(
         "--ivm", options.ivm,
         "Also write ivm/NAME.npy: per pixel the face drawn there, before any correction, 0xFFFFFFFF where "
         "none")
      ->group("Output");
  add_visibility(*app, options.visibility);
  add_common(*app, options.common);
  app->footer(std::string("Example:\n"
                          "  gpvc visibility colmap/sparse/0 mesh.ply --images photos -o seen --ivm\n\n"
                          "Writes to OUT: visibility/NAME.npy (uint8 per face: 0 hidden, 1 partial, 2 full,\n"
                          "3 unresolved), views.json, run.json; prints a line of figures per view.\n\n") +
              kExitStatus);
  return app;
}

CLI::App* add_evaluate(CLI::App& parent, EvaluateCommandOptions& options) {
  constexpr const char* kGroup = "Input";
  CLI::App* app = parent.add_subcommand("evaluate", "compare renders of a textured model with photos");
  app->add_option("MODEL", options.model, "Textured model of any program, OBJ or GLB")->required();
  app->add_option("SCENE", options.input.scene, "COLMAP model whose photos the renders are compared with")
      ->required();
  app->add_option("--mesh", options.input.mesh, "Mesh that was to be textured, for completeness")
      ->type_name("MESH")
      ->default_str("the model's own faces")
      ->group(kGroup);
  app->add_option("--images", options.input.images_dir, "Folder of the photos")
      ->type_name("DIR")
      ->default_str("'images' beside the model")
      ->group(kGroup);
  app->add_option("--views", options.input.views, "Only these views: names or globs, separated by commas")
      ->type_name("LIST")
      ->group(kGroup);
  app->add_option("--reduction", options.reduction, "Compare at 1/N of the photos' size, 1 to 64")
      ->type_name("N")
      ->check(in_range(1, 64))
      ->default_str("4")
      ->group(kGroup);
  app->add_option("-o,--output", options.out,
                  "Folder for photo, render and error side by side, and evaluate.json")
      ->type_name("OUT")
      ->group("Output");
  add_common(*app, options.common);
  app->footer(
      std::string("Example, with views the texture was made without:\n"
                  "  gpvc texture colmap mesh.ply -o out --exclude-views a.jpg,b.jpg\n"
                  "  gpvc evaluate out/model.obj colmap --mesh mesh.ply --views a.jpg,b.jpg\n\n"
                  "Virtual rephotography (Waechter et al. 2017): completeness, PSNR after one gain per\n"
                  "channel, SSIM, and 1 - NCC, per view and in the mean.\n\n") +
      kExitStatus);
  return app;
}

CLI::App* add_label(CLI::App& parent, LabelOptions& options) {
  CLI::App* app = parent.add_subcommand("label", "choose a view per face from stored costs");
  app->add_option("COSTS", options.costs,
                  "Folder with counts.npy, views.npy and costs.npy, or mvs-texturing's sparse table (.spt)")
      ->required();
  add_mesh(*app, options.mesh)->required();
  add_output(*app, options.out, options.force);
  app->add_option("--smoothness", options.solver.smoothness,
                  "Price of two neighbouring faces with different views; 0 and up")
      ->type_name("X")
      ->check(in_range(0.0, 1e6))
      ->default_str(fmt::format("{}", SolverOptions{}.smoothness))
      ->group("View selection");
  add_edge_weights(*app, options.edge_weights);
  app->add_option("--sweeps", options.solver.max_sweeps,
                  "Sweeps over all labels at most; it stops where none helps")
      ->type_name("N")
      ->check(in_range(1, 1000))
      ->default_str(std::to_string(SolverOptions{}.max_sweeps))
      ->group("View selection");
  add_common(*app, options.common);
  app->footer(
      std::string(
          "COSTS as a folder: counts.npy (uint32 per face: how many candidates), then views.npy (uint32) "
          "and\n"
          "costs.npy (float32, from 0, which is best), candidate after candidate in face order, views\n"
          "ascending within a face.\n\n"
          "Writes labels.npy (int32 per face: its view, -1 without candidates) and run.json to OUT; prints "
          "the\n"
          "energy: the sum of the chosen costs and of the smoothness over differing neighbours.\n\n") +
      kExitStatus);
  return app;
}

CLI::App* add_inspect(CLI::App& parent, InspectOptions& options) {
  CLI::App* app = parent.add_subcommand("inspect", "print what is understood of a scene and a mesh");
  add_scene(*app, options.input);
  add_mesh(*app, options.input.mesh);
  add_photos(*app, options.input);
  add_common(*app, options.common);
  app->footer(kExitStatus);
  return app;
}

namespace {

struct PhotoSize {
  int width = 0, height = 0;
};

PhotoSize parse_photo_size(const std::string& text) {
  PhotoSize size;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%dx%d%c", &size.width, &size.height, &rest) != 2 || size.width < 16 ||
      size.height < 16 || size.width > 20000 || size.height > 20000)
    throw CLI::ValidationError("--photo-size",
                               fmt::format("'{}' is not WIDTHxHEIGHT with edges of 16 to 20000", text));
  return size;
}

}  // namespace

CLI::App* add_synth_city(CLI::App& parent, SynthCityOptions& options) {
  constexpr const char* kGroup = "City";
  CLI::App* app = parent.add_subcommand(
      "city", "houses with eaves and balconies, trees, streets, and a flight over them");
  app->add_option("-o,--output", options.out, "Folder for the scene; made when missing")
      ->type_name("DIR")
      ->required()
      ->check(not_empty())
      ->group("Output");
  app->add_flag("--force", options.force, "Replace an earlier scene in DIR")->group("Output");
  app->add_option("--faces", options.city.faces,
                  "About so many triangles, as far as the shapes allow; 1000 to 20000000")
      ->type_name("N")
      ->check(in_range(1000, 20000000))
      ->default_str(std::to_string(CityOptions{}.faces))
      ->group(kGroup);
  app->add_option("--photos", options.city.photos, "A fifth of them nadir, the rest oblique from four sides")
      ->type_name("N")
      ->check(in_range(1, 5000))
      ->default_str(std::to_string(CityOptions{}.photos))
      ->group(kGroup);
  app->add_option_function<std::string>(
         "--photo-size",
         [&options](const std::string& text) {
           const PhotoSize size = parse_photo_size(text);
           options.city.width = size.width;
           options.city.height = size.height;
         },
         "Pixels")
      ->type_name("WxH")
      ->default_str(fmt::format("{}x{}", CityOptions{}.width, CityOptions{}.height))
      ->group(kGroup);
  app->add_option("--size", options.city.size_m, "Edge of the ground, 40 to 2000 metres")
      ->type_name("M")
      ->check(in_range(40.0, 2000.0))
      ->default_str(fmt::format("{}", CityOptions{}.size_m))
      ->group(kGroup);
  app->add_option("--seed", options.city.seed, "Another city for each number")
      ->type_name("N")
      ->default_str("1")
      ->group(kGroup);
  constexpr Choice<bool> kLenses[] = {{"opencv", true}, {"pinhole", false}};
  add_choice<bool>(
      *app, "--lens", kLenses, [&](bool v) { options.city.distorted = v; }, "opencv",
      "A mildly distorting lens with an off-centre principal point, or none")
      ->group(kGroup);
  app->add_option("--quality", options.quality, "Of the jpg photos, 1 to 100")
      ->type_name("N")
      ->check(in_range(1, 100))
      ->default_str("95")
      ->group(kGroup);
  add_common(*app, options.common);
  app->footer(
      std::string(
          "Example:\n"
          "  gpvc synth city -o city && gpvc texture city/colmap city/mesh.ply -o city-textured\n\n"
          "Writes to DIR: images/, mesh.ply, colmap/ (text model), surfaces.npy (surface per face) and\n"
          "surfaces.json (the true colours' parameters), run.json. The same options give the same "
          "bytes.\n\n") +
      kExitStatus);
  return app;
}

}  // namespace gpvc
