#include "app/evaluate/scene_json.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>

#include "io/lens_terms.h"

namespace gpvc::evaluate {
namespace {

Json rows_json(const std::array<double, 9>& m) {
  Json rows = Json::array();
  for (std::size_t i = 0; i < 9; i += 3) rows.push_back(Json::array({m[i], m[i + 1], m[i + 2]}));
  return rows;
}

/// Motion of scene.h, or null.
Json motion_json(const Motion& motion) {
  if (!motion.moves()) return nullptr;
  return {{"across", motion.across},
          {"down", motion.down},
          {"turn", motion.turn},
          {"step", motion.step},
          {"nearness", motion.nearness}};
}

}  // namespace

Json point_json(const WorldPoint& p) { return Json::array({p.x, p.y, p.z}); }

Json lens_json(const Distortion& lens) {
  Json json = {{"model", name_of(kLensModelNames, lens.model)}};
  for (const LensTerm& term : terms_of(lens.model)) json[term.name] = lens.*term.term;
  return json;
}

std::string lens_text(const Distortion& lens) {
  std::string text;
  for (const LensTerm& term : terms_of(lens.model))
    if (const double value = lens.*term.term; value != 0)
      text += fmt::format("{}{} {:.5g}", text.empty() ? "" : " ", term.name, value);
  return text;
}

Json camera_json(const Camera& camera, const Pose& pose) {
  return {{"width", camera.width},
          {"height", camera.height},
          {"fx", camera.fx},
          {"fy", camera.fy},
          {"cx", camera.cx},
          {"cy", camera.cy},
          {"distortion", lens_json(camera.distortion)},
          {"rolling_shutter", motion_json(camera.distortion.motion)},
          {"lens_from_frame", rows_json(camera.distortion.lens_from_frame)},
          {"rotation", rows_json(pose.rotation)},
          {"centre", point_json(pose.centre)}};
}

Json device_json(const std::optional<visibility::DeviceInfo>& device) {
  if (!device) return nullptr;
  return {{"index", device->index},
          {"renderer", device->renderer},
          {"driver", device->driver},
          {"software", device->software}};
}

void write_views_json(const std::filesystem::path& file, const Scene& scene, std::span<const ViewId> used,
                      std::span<const ViewId> held_out) {
  Json views = Json::array();
  for (std::uint32_t v = 0; v < scene.views.size(); ++v) {
    const View& view = scene.views[v];
    Json json = {{"index", v},
                 {"name", view.name},
                 {"photo", view.photo.string()},
                 {"used", std::binary_search(used.begin(), used.end(), ViewId{v})},
                 {"held_out", std::binary_search(held_out.begin(), held_out.end(), ViewId{v})}};
    json.update(camera_json(view.camera, view.pose));
    views.push_back(std::move(json));
  }
  write_json(file, {{"scene", scene.source.string()},
                    {"convention",
                     "x_camera = rotation * (x_world - centre); x right, y down, z forward; pixels from the top-left "
                     "corner, first centre at (0.5, 0.5); distortion as in OpenCV, further models as in io/scene.h"},
                    {"format", scene.format},
                    {"srs", scene.srs.empty() ? Json(nullptr) : Json(scene.srs)},
                    {"srs_offset", point_json(scene.offset)},
                    {"views", views}});
}

}  // namespace gpvc::evaluate
