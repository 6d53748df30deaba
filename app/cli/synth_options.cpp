// The options of gpvc synth.
#include <cmath>
#include <cstdio>

#include "app/cli/command_options.h"
#include "app/cli/option_parts.h"

namespace gpvc::cli {
namespace {

void parse_photo_size(const std::string& text, synth::FlightOptions& flight) {
  char rest = 0;
  if (std::sscanf(text.c_str(), "%dx%d%c", &flight.width, &flight.height, &rest) != 2 ||
      std::min(flight.width, flight.height) < 16 || std::max(flight.width, flight.height) > 20000)
    throw CLI::ValidationError("--photo-size", fmt::format("'{}' is not WIDTHxHEIGHT with edges of 16 to 20000", text));
}

void parse_offset(const std::string& text, WorldPoint& offset) {
  char rest = 0;
  if (std::sscanf(text.c_str(), "%lf,%lf,%lf%c", &offset.x, &offset.y, &offset.z, &rest) != 3 ||
      !(std::abs(offset.x) < 1e8 && std::abs(offset.y) < 1e8 && std::abs(offset.z) < 1e8))
    throw CLI::ValidationError("--offset", fmt::format("'{}' is not X,Y,Z in metres, below 1e8 each", text));
}

// The differences between the three kinds.
struct Kind {
  const char *what, *contents, *size_help;
  double least_m, most_m;
};

Kind kind_of(SynthKind kind) {
  switch (kind) {
    case SynthKind::city:
      return {"houses with eaves and balconies, trees, lamps, a bridge, and a flight over them",
              "Hard cases of visibility: thin poles and railings, tree crowns in the air, a bridge over a street.",
              "Edge of the ground, 40 to 2000 metres", 40, 2000};
    case SynthKind::terrain:
      return {"two uneven layers, hills and sheets above them, seen from afar",
              "Models A, B and C of the paper are --gap 0.01, 1 and 100.", "Edge of the ground, 10 to 16000 metres", 10,
              16000};
    default:
      return {"boards, roofs and walls under slats, from wide gaps to some micrometres",
              "The gap halves from one stand to the next: from a quarter of the size to a 65536th.",
              "Edge of the ground, 0.25 to 8 metres", 0.25, 8};
  }
}

void add_scene_options(const OptionGroup& group, const Kind& kind, SynthOptions& options) {
  synth::FlightOptions& flight = options.flight;
  group.number("--faces", options.faces, 1000, 20000000, "N",
               "Approximate number of triangles, as far as the shapes allow; 1000 to 20000000");
  group.number("--size", flight.size_m, kind.least_m, kind.most_m, "M", kind.size_help);
  if (options.kind == SynthKind::terrain)
    group.number("--gap", options.gap_m, 0.001, 1000.0, "M", "Distance of the layers, 0.001 to 1000 metres");
  group.add("--seed", flight.seed, "N", "Another scene for each number")->default_str("1");
  group.number("--photos", flight.photos, 1, 20000, "N",
               "Photos, a fifth of them nadir, the rest oblique from four sides");
  group.flag("--nadir", flight.all_nadir, "Let all photos look straight down");
  group.parsed(
      "--photo-size", [&flight](const std::string& text) { parse_photo_size(text, flight); }, "WxH",
      fmt::format("{}x{}", flight.width, flight.height), "Size of the photos in pixels");
  group.number("--range", flight.range, 0.3, 10.0, "X",
               "Distance from the cameras to what they look at, in edges of the ground");
  constexpr Named<bool> kLenses[] = {{"opencv", true}, {"pinhole", false}};
  group.choice("--lens", kLenses, flight.distorted,
               "opencv: mild distortion and an off-centre principal point; pinhole: neither");
  group
      .number("--bands", options.bands.count, std::size_t{1}, synth::kMostBands, "N",
              "Take reflectance in N bands, 1 to 10, as TIFF: 3 red, green, blue; 4 near infrared as well; 5 blue, "
              "green, red, "
              "near infrared, red edge")
      ->default_str("none: JPEG");
  constexpr Named<SampleType> kDepths[] = {{"8", SampleType::u8}, {"16", SampleType::u16}, {"float", SampleType::f32}};
  const auto take_depth = [&bands = options.bands](SampleType type) {
    bands.type = type;
    if (!bands.any()) bands.count = 3;
  };
  group.choice(
      "--depth", kDepths, take_depth, options.bands.type,
      "Bits of a sample of a TIFF, of three bands unless --bands says how many. White is the most of red, green and "
      "blue; else 200 of 8 bits, 32768 of 16; 1 of floats");
  group.flag("--band-files", options.bands.apart,
             "Write each band to a file of its own, NAME_1.tif, NAME_2.tif, taken by a lens a pixel or two aside");
  group.number("--quality", options.quality, 1, 100, "N", "JPEG quality of the photos, 1 to 100");
}

void add_blur(const OptionGroup& group, SynthOptions& options) {
  group.number("--aperture", options.aperture_m, 0.0, 1000.0, "M",
               "Diameter of a thin lens (focal length / f-number), 0 to 1000 metres; a point at depth z is spread to a "
               "disc of fx * M * |1 / focus - 1 / z| pixels; 0: sharp everywhere");
  group.add("--focus", options.focus_m, "M", "Depth of the plane in focus, 0.001 to 1000000 metres")
      ->check(in_range(0.001, 1e6))
      ->default_str("what cameras look at");
  group.number("--shake", options.shake_px, 0.0, 1000.0, "PX",
               "Turn the camera during the exposure, in each photo another way, so that its middle moves by up to PX "
               "pixels, 0 to 1000");
  group.number("--travel", options.travel_m, 0.0, 1000.0, "M",
               "Move the camera along the photo's width meanwhile, by up to M metres, 0 to 1000");
  group.parsed(
      "--rays",
      [&options](const std::string& text) {
        if (!CLI::detail::lexical_cast(text, options.rays) || options.rays < 4 || options.rays > 4096 ||
            options.rays % 4 != 0)
          throw CLI::ValidationError("--rays", fmt::format("'{}' is not a multiple of 4 from 4 to 4096", text));
      },
      "N", fmt::format("{}", options.rays), "Rays a pixel of a blurred photo, a multiple of 4, 4 to 4096");
  group.number("--haze", options.visibility_m, 0.0, 1e6, "M",
               "Visibility: colours keep a 50th of their contrast over M metres, 0 to 1000000; 0: clear air");
}

void add_imperfections(const OptionGroup& group, SynthOptions& options) {
  group.number("--mesh-noise", options.mesh_noise_m, 0.0, 100.0, "M",
               "Move each coordinate of each vertex of the written mesh by up to M metres; photos show the true mesh");
  group.number(
      "--pose-error", options.errors.pose_px, 0.0, 100.0, "PX",
      "Write poses by which the middle of each photo is off by PX pixels, each another way; true_colmap has the true "
      "ones");
  group.number("--lens-error", options.errors.lens_px, -100.0, 100.0, "PX",
               "Write a lens by which the corners of all photos are off by PX pixels");
  group.flag("--exposure", options.exposure,
             "Give each photo its own gain, 0.7 to 1.4, and all of them darker corners");
  group.number("--wander", options.wander, 0.0, 0.5, "SHARE",
               "Let gain and white balance wander along the flight: by up to SHARE from photo to photo, 0 to 0.5");
  group.flag("--exif", options.exif, "State how each photo was exposed in its EXIF data, as cameras do");
  group.number("--backscatter", options.backscatter, 0.0, 2.0, "SHARE",
               "Let all be brighter by SHARE where one looks straight away from the sun than across its rays, 0 to 2");
  if (options.kind == SynthKind::city) {
    synth::Unmodelled& what = options.unmodelled;
    group.number("--cars", what.cars, 0, 1000, "N", "Moving cars in each photo, none of them in the mesh");
    group.number("--people", what.people, 0, 10000, "N", "People in each photo, elsewhere in each, none in the mesh");
    group.flag("--fences", what.fences,
               "Put wire fences a metre before a wall of each building: photos show them, the mesh lacks them");
    group.flag("--trees", what.trees, "Put trees along the pavements, which photos show and the mesh lacks");
    group.flag("--wires", what.wires, "Put overhead wires along streets, which photos show and the mesh lacks");
    group.flag("--reflections", options.reflections,
               "Let window panes mirror sky, sun and houses, so that each photo shows them in another colour");
  }
  add_blur(group, options);
  group.parsed(
      "--offset", [&options](const std::string& text) { parse_offset(text, options.offset); }, "X,Y,Z", "0,0,0",
      "Added to all coordinates");
  const auto take_utm = [&options] { options.offset = {448192, 5411328, 256}; };
  group.app.add_flag_callback("--utm", take_utm, "The same as --offset 448192,5411328,256, exact in binary")
      ->group(group.heading);
}

}  // namespace

CLI::App* add_synth(CLI::App& parent, SynthOptions& options) {
  const Kind kind = kind_of(options.kind);
  const std::string name = synth_name(options.kind);
  CLI::App* app = parent.add_subcommand(name, kind.what);
  const OptionGroup output{*app, pipeline::kOutput};
  output.add("-o,--output", options.out, "DIR", "Folder for the scene; created if missing")
      ->required()
      ->check(not_empty());
  output.flag("--force", options.force, "Replace an earlier scene in DIR");
  output.flag("!--no-ids", options.ids, "Write neither ids/, which --truth needs, nor clean/");
  add_scene_options({*app, "Scene"}, kind, options);
  add_imperfections({*app, "Imperfections"}, options);
  add_common(*app, options.common,
             fmt::format(R"({0}

Example:
  gpvc synth {1} -o {1} && gpvc texture {1}/colmap {1}/mesh.ply -o {1}-textured
  gpvc evaluate {1}-textured/model.obj {1}/colmap --truth {1}

Writes to DIR: images/, mesh.ply, colmap/ (text model), run.json; and the truth: surfaces.npy
(surface per face), surfaces.json (parameters of the true colours), truth.json (gains, shakes),
ids/NAME.png (the surface that each pixel shows, one colour per surface), true_mesh.ply if
--mesh-noise is given, and clean/ if photos are imperfect: the same photos without blur, haze,
reflections, gains and what the mesh lacks, for gpvc evaluate --images; unmodelled/NAME.png, how
much of each pixel such things cover, if there are any. The same options give the same bytes.

)",
                         kind.contents, name));
  return app;
}

}  // namespace gpvc::cli
