#include "app/cli/band_notes.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "io/number_text.h"
#include "io/photo_pixel.h"

namespace gpvc::cli {
namespace {

std::string band_text(const Band& band) {
  std::string more;
  if (band.wavelength_nm) more = io::shortest_text(*band.wavelength_nm) + " nm";
  if (!band.unit.empty()) more += (more.empty() ? "" : ", ") + band.unit;
  return more.empty() ? band.name : band.name + " (" + more + ")";
}

std::string composite_text(const BandSet& set) {
  const auto& [red, green, blue] = set.composite;
  if (red == green && green == blue) return set.bands[red].name + " as grey";
  return fmt::format("{}, {}, {} as red, green, blue", set.bands[red].name, set.bands[green].name,
                     set.bands[blue].name);
}

/// The first view whose bands lie in several files.
const View* view_of_files(const Scene& scene) {
  for (const View& view : scene.views)
    if (!view.band_files.empty()) return &view;
  return nullptr;
}

std::string place_text(const Scene& scene, const View& view, std::size_t file) {
  const BandPlace& place = scene.band_places[file];
  const double x = view.camera.width * view.reduction / 2.0, y = view.camera.height * view.reduction / 2.0;
  const std::string name = view.band_files[file].filename().string();
  if (!view.band_cameras.empty()) {
    const auto at = io::place_in_file(view.band_cameras[file], place.nearness, {x, y});
    std::string text = name + " lies over its photo by the cameras of the scene";
    if (at) text += fmt::format(", {:.2f} px right and {:.2f} px down in its middle", at->x - x, at->y - y);
    if (place.nearness > 0) text += fmt::format(", of what is {:.4g} away", 1 / place.nearness);
    return place.error_px ? fmt::format("{}; to {:.2f} px in the median of what was compared", text, *place.error_px)
                          : text;
  }
  const auto& m = place.file_from_photo;
  const double right = m[0] * x + m[1] * y + m[2] - x, down = m[3] * x + m[4] * y + m[5] - y;
  const bool turns = m[0] != 1 || m[1] != 0 || m[3] != 0 || m[4] != 1;
  std::string text = fmt::format("{} shows the same {:.2f} px right and {:.2f} px down in its middle{}", name, right,
                                 down, turns ? ", turned or scaled" : "");
  if (place.error_px) text += fmt::format(", to {:.2f} px in the median of what was compared", *place.error_px);
  return text;
}

}  // namespace

std::vector<std::string> band_notes(const Scene& scene) {
  if (!scene.bands) return {};
  const BandSet& set = *scene.bands;
  std::string bands;
  for (const Band& band : set.bands) bands += (bands.empty() ? "" : ", ") + band_text(band);
  std::vector<std::string> notes{
      fmt::format("{} of {}: {}", set.bands.size(), name_of(kSampleTypeNames, set.type), bands),
      fmt::format("looked at: {}, from {} (black) to {} (white) in all photos", composite_text(set),
                  io::shortest_text(set.black), io::shortest_text(set.white))};
  const View* view = view_of_files(scene);
  for (std::size_t file = 0; view != nullptr && file < scene.band_places.size(); ++file)
    if (view->band_files[file] != view->photo) notes.push_back(place_text(scene, *view, file));
  return notes;
}

Json bands_json(const Scene& scene) {
  if (!scene.bands) return nullptr;
  const BandSet& set = *scene.bands;
  Json bands = Json::array(), composite = Json::array(), files = Json::array();
  for (const Band& band : set.bands)
    bands.push_back({{"name", band.name},
                     {"wavelength_nm", band.wavelength_nm ? Json(*band.wavelength_nm) : Json(nullptr)},
                     {"unit", band.unit}});
  for (const std::size_t band : set.composite) composite.push_back(set.bands[band].name);
  for (const BandPlace& place : scene.band_places)
    files.push_back({{"file_from_photo", place.file_from_photo},
                     {"nearness", place.nearness},
                     {"error_px", place.error_px ? Json(*place.error_px) : Json(nullptr)}});
  return {{"type", name_of(kSampleTypeNames, set.type)},
          {"bands", bands},
          {"composite", composite},
          {"black", set.black},
          {"white", set.white},
          {"radiometric", set.radiometric},
          {"files", files}};
}

}  // namespace gpvc::cli
