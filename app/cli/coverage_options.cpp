// The options of gpvc coverage.
#include "app/cli/command_options.h"
#include "app/cli/option_parts.h"
#include "app/cli/setting_options.h"

namespace gpvc::cli {

CLI::App* add_coverage(CLI::App& parent, CoverageOptions& options) {
  CLI::App* app = parent.add_subcommand("coverage", "map where photos cover a mesh too little: where to fly again");
  add_scene(*app, options.input);
  add_mesh(*app, options.input.mesh)->required();
  add_photos(*app, options.input);
  const OptionGroup input{*app, pipeline::kInput}, quality{*app, pipeline::kQuality}, size{*app, pipeline::kSize};
  input
      .add("--from", options.from, "DIR",
           "An editable result of gpvc texture (--editable): photos that show something else there (cars, sky) do not "
           "count. "
           "Nothing is rendered then")
      ->check(not_empty());
  add_output(*app, options);
  quality.number("--min-photos", options.wanted.photos, 1U, 1000U, "N", "Photos that have to see a face, 1 to 1000");
  quality
      .add("--gsd", options.wanted.gsd, "X",
           "Ground sampling distance that is wanted, in units of the scene; coarser areas are listed")
      ->check(in_range(1e-9, 1e9))
      ->default_str("twice the median over what photos see");
  quality.number("--max-angle", options.wanted.angle, 1.0, 90.0, "DEG",
                 "Degrees between a surface's normal and the line of sight up to which a photo is good, 1 to 90");
  size.add("--min-area", options.least_area, "X",
           "Leave smaller areas out of map and table, in squared units of the scene; arrays and picture have them")
      ->check(in_range(0.0, 1e12))
      ->default_str("what 50 x 50 pixels show at the median");
  size.number("--cells", options.cells, 64, 16384, "N",
              "Cells along the longer side of the picture and of the grid that areas are outlined in, 64 to 16384");
  add_settings(*app, options.visibility);
  add_common(*app, options.common, R"(Example:
  gpvc coverage SCENE MESH -o coverage --min-photos 3 --gsd 0.03

Writes to OUT:
  coverage.geojson     connected areas as polygons in longitude and latitude (RFC 7946); without a
                       reference system in the coordinates that it names
  coverage.csv         the same as a table: reason, surface, faces, middle, tilt, photos, best gsd
  coverage.png         from above, coloured by the number of photos, with a legend
  coverage_photos.npy  per face, uint32: photos that see at least half of it
  coverage_gsd.npy     float32: the least ground sampling distance (inf: none)
  coverage_angle.npy   float32: the least angle between normal and line of sight, degrees
  coverage_lack.npy    uint8: 0 nothing, 1 unseen, 2 few photos, 3 coarse, 4 grazing; the first that holds
and run.json. Areas are neighbouring faces that lack the same. They are outlined from above in cells:
a wall is a row of cells, and its tilt is 90 (0: flat ground; above 90: an underside, seen from below).

)");
  return app;
}

}  // namespace gpvc::cli
