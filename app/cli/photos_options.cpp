// The options of gpvc photos.
#include "app/cli/command_options.h"
#include "app/cli/option_parts.h"
#include "app/cli/setting_options.h"
#include "io/mesh.h"

namespace gpvc::cli {
namespace {

// What says which photo is good for a face, and which is an outlier.
bool judges_photos(const pipeline::OptionInfo& info) {
  constexpr std::string_view kNames[] = {"data-term",       "outliers",     "background",  "margin",
                                         "keep-odd-photos", "allow-misfit", "allow-unseen"};
  return std::ranges::find(kNames, std::string_view(info.name)) != std::end(kNames);
}

WorldPoint point_from(const std::string& option, const std::string& given) {
  double at[3] = {};
  std::size_t from = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t comma = i < 2 ? given.find(',', from) : given.size();
    const std::string word = comma == std::string::npos ? "" : given.substr(from, comma - from);
    const bool is_number = !word.empty() && CLI::detail::lexical_cast(word, at[i]);
    if (!is_number || !(std::abs(at[i]) <= io::kMostCoordinate))
      throw CLI::ValidationError(option, fmt::format("'{}' is not made of three numbers X,Y,Z", given));
    from = comma + 1;
  }
  return {at[0], at[1], at[2]};
}

}  // namespace

CLI::App* add_photos_command(CLI::App& parent, PhotosOptions& options) {
  CLI::App* app = parent.add_subcommand("photos", "say which photos show a point of a mesh, and why the others do not");
  add_scene(*app, options.input);
  add_mesh(*app, options.input.mesh)->required();
  add_photos(*app, options.input);
  const OptionGroup input{*app, pipeline::kInput}, output{*app, pipeline::kOutput};
  const auto take_points = [&points = options.points](const std::vector<std::string>& given) {
    for (const std::string& each : given) points.push_back(point_from("--at", each));
  };
  app->add_option_function<std::vector<std::string>>(
         "--at", take_points,
         "A point, in the coordinates of the mesh's file or, where the scene writes large ones from an origin, in "
         "those of its "
         "reference system; the nearest point of the surface is taken. May be given several times")
      ->type_name("X,Y,Z")
      ->allow_extra_args(false)
      ->group(pipeline::kInput);
  input
      .add("--crs", options.crs, "CRS",
           "Reference system of the points of --at (EPSG:25832, OGC:CRS84 for longitude,latitude)")
      ->check(not_empty())
      ->needs(app->get_option("--at"));
  app->add_option("--face", options.faces, "A face by its number in the mesh: its centroid. May be given several times")
      ->type_name("N")
      ->allow_extra_args(false)
      ->group(pipeline::kInput);
  input
      .add("--geojson", options.geojson, "FILE",
           "Points of a GeoJSON file: longitude and latitude, or in the system that the file names. Those without a "
           "height are "
           "the highest surface there")
      ->check(not_empty());
  CLI::Option* from = input
                          .add("--from", options.from, "DIR",
                               "An editable result of gpvc texture (--editable), which knows the outliers and what "
                               "each photo costs. Nothing is "
                               "rendered then")
                          ->check(not_empty());
  input
      .flag("--judge", options.judge,
            "Compare all photos with each other first, as gpvc texture does, to know outliers and costs; takes as long "
            "as its "
            "first stages")
      ->excludes(from);
  add_rules(*app, options.allow);
  output.add("--json", options.json, "FILE", "Write the answers to FILE as JSON; - for standard output")
      ->check(not_empty());
  output
      .add("--crops", options.crops, "DIR",
           "Write what each photo shows around the point, at full size, as DIR/POINT/PHOTO.png; the point is within "
           "the cross")
      ->check(not_empty());
  output.number("--crop-size", options.crop_size, 16, 4096, "N", "Pixels of a cut-out's edge, 16 to 4096");
  output
      .add("--index", options.index, "FILE",
           "Write which photos see each face of the mesh, in full or in part, to FILE as compressed NumPy arrays "
           "(.npz); "
           "renders all views")
      ->check(not_empty());
  add_settings(*app, options.settings, judges_photos);
  add_common(*app, options.common, R"(Examples:
  gpvc photos SCENE MESH --at 448123.2,5411302.7,212.4 --from textured
  gpvc photos SCENE MESH --geojson points.geojson --json answers.json --crops crops

Prints for each point the photos that show it, best first: pixel, ground sampling distance,
angle to the surface, class of the face and what the labeling would charge for the photo; then the
others with the reason. A photo shows a point if the point projects into it, no mask excludes the
pixel, the surface faces the camera, and no other face lies in between: decided exactly, by the
rules of gpvc visibility. Outliers and the costs of silhouettes are known with --from or --judge.
Pixels are those of the photo as taken, distorted, from its top-left corner, whose first pixel has
its centre at (0.5, 0.5).

--index writes, of the views that see face F in entries first[F] to first[F + 1] - 1: views (numbers
into names.tobytes().decode().split("\n")), classes (1 partial, 2 full), shares (of the face that is
seen), gsd and angle at its centroid; with --from or --judge also costs (NaN: no candidate) and
fates (0 candidate, 1 refused, 2 outlier, 3 background, 4 mixed, 5 not needed, 255 has no say).

)");
  return app;
}

}  // namespace gpvc::cli
