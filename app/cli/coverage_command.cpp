// gpvc coverage: where photos cover a mesh too little.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/cli/scene_input.h"
#include "app/cli/setting_options.h"
#include "app/query/coverage_files.h"
#include "app/query/sharpness.h"
#include "io/images.h"
#include "io/npy.h"
#include "io/output_file.h"
#include "io/photos.h"

namespace gpvc::cli {
namespace {

namespace fs = std::filesystem;

// What 50 x 50 pixels show at the median: wanted.gsd is twice that where none is given.
double least_area(const CoverageOptions& options, const Mesh& mesh, const query::FaceCoverage& coverage) {
  if (options.least_area) return *options.least_area;
  query::Wanted found = options.wanted;
  found.gsd = 0;
  const double side = 25 * query::resolved(found, mesh, coverage).gsd;
  return std::isfinite(side) ? side * side : 0;
}

void report(const std::vector<query::Area>& areas, double whole, RunRecord& record) {
  for (const auto& known : query::kLackNames) {
    if (known.value == query::Lack::nothing) continue;
    double surface = 0;
    std::size_t faces = 0, count = 0;
    for (const query::Area& area : areas)
      if (area.lack == known.value) {
        surface += area.surface;
        faces += area.faces.size();
        ++count;
      }
    const double share = whole > 0 ? surface / whole : 0;
    record.counts[known.name] = {{"areas", count}, {"faces", faces}, {"surface", surface}, {"share", share}};
    record.console.result(fmt::format("{:8} {:>12.6g} squared units, {:5.2f} % of the mesh, {} faces in {} areas",
                                      known.name, surface, 100 * share, results::readable_count(faces),
                                      results::readable_count(count)));
  }
}

RunFacts coverage(const CoverageOptions& options, RunRecord& record, results::OutputFolder& folder) {
  const SceneInputData in = read_scene_input(options.input, record);
  std::set<fs::path> read = input_files(in);
  folder.protect(read);
  io::PhotoCache photos(in.scene);
  const checks::Input input = in.input();
  pipeline::Settings settings;
  settings.visibility = options.visibility;
  settings.device = options.common.device;
  const pipeline::Run run{input, settings, photos, record};
  std::optional<pipeline::Judgement> judgement;
  if (!options.from.empty()) {
    results::OutputFolder::finish_interrupted(options.from);
    judgement = pipeline::read_judgement(options.from, run);
  }
  std::optional<visibility::DeviceInfo> device;
  const query::FaceCoverage faces = query::cover_faces(run, judgement ? &*judgement : nullptr, &device);
  record.begin({"areas"});
  const query::Wanted wanted = query::resolved(options.wanted, in.mesh, faces);
  const std::vector<query::Lack> lacks = query::lacks_of(faces, wanted);
  std::vector<query::Area> areas = query::areas_of(in.mesh, faces, lacks);
  const query::Ground ground = query::ground_of(input);
  const query::CellGrid grid = query::grid_over(box_of(ground.mesh), options.cells);
  double whole = 0;
  for (std::uint32_t f = 0; f < in.mesh.faces.size(); ++f) whole += query::surface_of(in.mesh, FaceId{f});
  record.console.result(fmt::format("wanted   {} photos or more, gsd {:.4g} or less, {:.4g} degrees or less",
                                    wanted.photos, wanted.gsd, wanted.angle));
  report(areas, whole, record);
  const double least = least_area(options, in.mesh, faces);
  const std::size_t all = areas.size();
  std::erase_if(areas, [&](const query::Area& area) { return area.surface < least; });
  record.note(fmt::format("map and table have {} of {} areas, those of {:.4g} squared units or more; {}", areas.size(),
                          all, least, ground.name));
  evaluate::write_json(folder.file("coverage.geojson"), query::areas_geojson(areas, ground, grid));
  io::write_file(folder.file("coverage.csv"), query::areas_table(areas, input, ground));
  io::write_image(folder.file("coverage.png"), query::coverage_picture(ground, faces, lacks, wanted, grid),
                  io::ImageFormat::png, 0);
  io::write_npy_as<std::uint32_t>(folder.file("coverage_photos.npy"), faces.photos);
  io::write_npy_as<float>(folder.file("coverage_gsd.npy"), faces.gsd);
  io::write_npy_as<float>(folder.file("coverage_angle.npy"), faces.angle);
  io::write_npy_as<std::uint8_t>(folder.file("coverage_lack.npy"), lacks);
  record.end(fmt::format("{} listed", areas.size()));
  record.counts["wanted"] = {{"photos", wanted.photos}, {"gsd", wanted.gsd}, {"angle", wanted.angle}};
  record.counts["least_area"] = least;
  record.counts["listed_areas"] = areas.size();
  Json json = scene_json(options.input);
  json.update(settings_json(options.visibility));
  json["from"] = options.from.string();
  json["min_photos"] = options.wanted.photos;
  json["gsd"] = options.wanted.gsd;
  json["max_angle"] = options.wanted.angle;
  json["min_area"] = options.least_area ? Json(*options.least_area) : Json(nullptr);
  json["cells"] = options.cells;
  return {json, evaluate::device_json(device), (options.out / "coverage.png").string()};
}

}  // namespace

void run_coverage(const CoverageOptions& options, Console& console) {
  run_command("coverage", options, console,
              [&](RunRecord& record, results::OutputFolder& folder) { return coverage(options, record, folder); });
}

}  // namespace gpvc::cli
