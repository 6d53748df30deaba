#include <cstdio>

#include "app/command_options.h"
#include "app/option_parts.h"

namespace gpvc {
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
