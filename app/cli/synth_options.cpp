#include <cmath>
#include <cstdio>

#include "app/cli/command_options.h"
#include "app/cli/option_parts.h"

namespace gpvc::cli {
namespace {

struct PhotoSize {
  int width = 0, height = 0;
};

PhotoSize parse_photo_size(const std::string& text) {
  PhotoSize size;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%dx%d%c", &size.width, &size.height, &rest) != 2 || size.width < 16 ||
      size.height < 16 || size.width > 20000 || size.height > 20000)
    throw CLI::ValidationError("--photo-size", fmt::format("'{}' is not WIDTHxHEIGHT with edges of 16 to 20000", text));
  return size;
}

WorldPoint parse_offset(const std::string& text) {
  WorldPoint offset;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%lf,%lf,%lf%c", &offset.x, &offset.y, &offset.z, &rest) != 3 ||
      !(std::abs(offset.x) < 1e8 && std::abs(offset.y) < 1e8 && std::abs(offset.z) < 1e8))
    throw CLI::ValidationError("--offset", fmt::format("'{}' is not X,Y,Z in metres, below 1e8 each", text));
  return offset;
}

constexpr const char* kSceneGroup = "Scene";

// The differences between the three kinds.
struct Kind {
  const char *what, *contents, *size_help;
  double least_m, most_m;
};

Kind kind_of(SynthKind kind) {
  switch (kind) {
    case SynthKind::city:
      return {"houses with eaves and balconies, trees, lamps, a bridge, and a flight over them",
              "Needles for visibility: thin poles and railings, crowns that float, a bridge over a street.",
              "Edge of the ground, 40 to 2000 metres", 40, 2000};
    case SynthKind::terrain:
      return {"two uneven layers, hills and sheets above them, seen from afar",
              "As models A, B and C of the paper: --gap 0.01, 1 and 100.", "Edge of the ground, 10 to 16000 metres", 10,
              16000};
    default:
      return {"boards, roofs and walls under slats, from wide gaps to some micrometres",
              "From stand to stand the gap halves: from a quarter of the size to a 65536th.",
              "Edge of the ground, 0.25 to 8 metres", 0.25, 8};
  }
}

void add_spoilers(CLI::App& app, SynthOptions& options) {
  constexpr const char* kSpoilers = "Imperfections";
  app.add_option(
         "--mesh-noise", options.mesh_noise_m,
         "The written mesh is off by up to so many metres in each coordinate of each vertex; photos show the true "
         "one")
      ->type_name("M")
      ->check(in_range(0.0, 100.0))
      ->default_str("0")
      ->group(kSpoilers);
  app.add_flag("--exposure", options.exposure, "Each photo has a gain of its own, 0.7 to 1.4, and darker corners")
      ->group(kSpoilers);
  if (options.kind == SynthKind::city)
    app.add_option("--cars", options.cars, "Moving cars: so many in each photo, none of them in the mesh")
        ->type_name("N")
        ->check(in_range(0, 1000))
        ->default_str("0")
        ->group(kSpoilers);
  app.add_option_function<std::string>(
         "--offset", [&options](const std::string& text) { options.offset = parse_offset(text); },
         "Added to all coordinates")
      ->type_name("X,Y,Z")
      ->default_str("0,0,0")
      ->group(kSpoilers);
  app.add_flag_callback(
         "--utm",
         [&options] {
           options.offset = {448192, 5411328, 256};
         },
         "The same as --offset 448192,5411328,256, exact in binary")
      ->group(kSpoilers);
}

void add_photo_options(CLI::App& app, SynthOptions& options) {
  synth::FlightOptions& flight = options.flight;
  app.add_option("--photos", flight.photos, "A fifth of them nadir, the rest oblique from four sides")
      ->type_name("N")
      ->check(in_range(1, 5000))
      ->default_str(std::to_string(flight.photos))
      ->group(kSceneGroup);
  app.add_option_function<std::string>(
         "--photo-size",
         [&flight](const std::string& text) {
           const PhotoSize size = parse_photo_size(text);
           flight.width = size.width;
           flight.height = size.height;
         },
         "Pixels")
      ->type_name("WxH")
      ->default_str(fmt::format("{}x{}", flight.width, flight.height))
      ->group(kSceneGroup);
  app.add_option("--range", flight.range, "From cameras to what they look at, in edges of the ground")
      ->type_name("X")
      ->check(in_range(0.3, 10.0))
      ->default_str(fmt::format("{}", flight.range))
      ->group(kSceneGroup);
  constexpr Named<bool> kLenses[] = {{"opencv", true}, {"pinhole", false}};
  add_choice(app, "--lens", kLenses, flight.distorted,
             "A mildly distorting lens with an off-centre principal point, or none")
      ->group(kSceneGroup);
  app.add_option("--quality", options.quality, "Of the jpg photos, 1 to 100")
      ->type_name("N")
      ->check(in_range(1, 100))
      ->default_str("95")
      ->group(kSceneGroup);
}

}  // namespace

CLI::App* add_synth(CLI::App& parent, SynthOptions& options) {
  const Kind kind = kind_of(options.kind);
  const std::string name = synth_name(options.kind);
  CLI::App* app = parent.add_subcommand(name, kind.what);
  app->add_option("-o,--output", options.out, "Folder for the scene; made when missing")
      ->type_name("DIR")
      ->required()
      ->check(not_empty())
      ->group("Output");
  app->add_flag("--force", options.force, "Replace an earlier scene in DIR")->group("Output");
  app->add_flag("!--no-ids", options.ids, "Leave ids/ out, which --truth needs")->group("Output");
  app->add_option("--faces", options.faces, "About so many triangles, as far as the shapes allow; 1000 to 20000000")
      ->type_name("N")
      ->check(in_range(1000, 20000000))
      ->default_str(std::to_string(options.faces))
      ->group(kSceneGroup);
  app->add_option("--size", options.flight.size_m, kind.size_help)
      ->type_name("M")
      ->check(in_range(kind.least_m, kind.most_m))
      ->default_str(fmt::format("{}", options.flight.size_m))
      ->group(kSceneGroup);
  if (options.kind == SynthKind::terrain)
    app->add_option("--gap", options.gap_m, "Between the layers, 0.001 to 1000 metres")
        ->type_name("M")
        ->check(in_range(0.001, 1000.0))
        ->default_str(fmt::format("{}", options.gap_m))
        ->group(kSceneGroup);
  app->add_option("--seed", options.flight.seed, "Another scene for each number")
      ->type_name("N")
      ->default_str("1")
      ->group(kSceneGroup);
  add_photo_options(*app, options);
  add_spoilers(*app, options);
  add_common(*app, options.common);
  app->footer(
      fmt::format("{0}\n\n"
                  "Example:\n"
                  "  gpvc synth {1} -o {1} && gpvc texture {1}/colmap {1}/mesh.ply -o {1}-textured\n"
                  "  gpvc evaluate {1}-textured/model.obj {1}/colmap --truth {1}\n\n"
                  "Writes to DIR: images/, mesh.ply, colmap/ (text model), run.json; and the truth: surfaces.npy\n"
                  "(surface per face), surfaces.json (the true colours' parameters), truth.json (gains),\n"
                  "ids/NAME.png (the surface that each pixel shows, a colour each), true_mesh.ply under noise.\n"
                  "The same options give the same bytes.\n\n{2}",
                  kind.contents, name, kExitStatus));
  return app;
}

}  // namespace gpvc::cli
