#include <fmt/format.h>

#include "app/city.h"
#include "app/interrupt.h"
#include "app/scene_input.h"

namespace gpvc {
namespace {

Json city_json(const SynthCityOptions& options) {
  const CityOptions& c = options.city;
  return {{"faces", c.faces},         {"photos", c.photos},        {"width", c.width},
          {"height", c.height},       {"size_m", c.size_m},        {"seed", c.seed},
          {"distorted", c.distorted}, {"quality", options.quality}};
}

void take_photos(CityRenderer& renderer, const std::vector<View>& views, const SynthCityOptions& options,
                 OutputFolder& folder, Console& console, RunRecord& record) {
  Stage stage(console, record, "photos", "photos");
  for (std::size_t v = 0; v < views.size(); ++v) {
    stage.progress(v, views.size());
    const Image photo = renderer.photo(views[v].camera, views[v].pose);
    write_image(folder.file("images/" + views[v].name), photo, ImageFormat::jpg, options.quality);
  }
  stage.finish(fmt::format("{} of {} x {}", views.size(), options.city.width, options.city.height));
}

}  // namespace

void run_synth_city(const SynthCityOptions& options, Console& console) {
  RunRecord record;
  OutputFolder folder(options.out, options.force);
  try {
    Stage building(console, record, "city");
    const City city = make_city(options.city);
    const std::vector<View> views = city_flight(options.city);
    CityRenderer renderer(city);
    record.counts = {{"faces", city.mesh.faces.size()},
                     {"vertices", city.mesh.positions.size()},
                     {"surfaces", city.surfaces.size()},
                     {"views", views.size()}};
    write_city_mesh(folder.file("mesh.ply"), city.mesh);
    for (const char* name : {"colmap/cameras.txt", "colmap/images.txt"}) folder.file(name);
    write_city_cameras(folder.file("colmap/points3D.txt").parent_path(), city, views, renderer);
    const std::size_t faces = city.face_surface.size();
    write_npy(folder.file("surfaces.npy"), city.face_surface, std::span(&faces, 1));
    write_city_surfaces(folder.file("surfaces.json"), city);
    building.finish(fmt::format("{} faces of {} surfaces", readable_count(faces), city.surfaces.size()));

    take_photos(renderer, views, options, folder, console, record);
    write_run_json(folder, {"synth city", options.common, city_json(options)}, record);
    folder.publish();
  } catch (const OutputError& e) {
    throw std::runtime_error(folder.with_final_names(e.what()));
  }
  console.result(fmt::format("scene   {}\nmesh    {}\nphotos  {}", (options.out / "colmap").string(),
                             (options.out / "mesh.ply").string(), (options.out / "images").string()));
}

}  // namespace gpvc
