// Scenes as JSON; the formats' conventions are stated where they are read: transforms_scene.cpp, opensfm_scene.cpp.
#include <algorithm>
#include <nlohmann/json.hpp>
#include <vector>

#include "io/error.h"
#include "io/files/text_scan.h"
#include "io/lens_terms.h"
#include "io/output_file.h"
#include "io/scenes/scene_file.h"
#include "io/scenes/scene_writer.h"

namespace gpvc::io {
namespace {

using OrderedJson = nlohmann::ordered_json;

/// What a format states of the lenses of a projection, under these names.
struct StatedLens {
  const char* name;
  std::vector<LensTerm> terms;
};

const StatedLens& chosen_lens(const StatedLens& perspective, const StatedLens& equidistant, LensModel model) {
  return model == LensModel::equidistant ? equidistant : perspective;
}

std::optional<std::string> lost_beyond(const StatedLens& (*lens)(LensModel), const Distortion& d) {
  if (!is_perspective(d.model) && d.model != LensModel::equidistant) return projection_name(d.model);
  std::vector<DistortionTerm> terms;
  for (const LensTerm& term : lens(d.model).terms) terms.push_back(term.term);
  return first_term_beyond(d, terms);
}

constexpr LensTerm kK1{"k1", &Distortion::k1}, kK2{"k2", &Distortion::k2}, kK3{"k3", &Distortion::k3},
    kK4{"k4", &Distortion::k4}, kP1{"p1", &Distortion::p1}, kP2{"p2", &Distortion::p2};

// nerfstudio's OPENCV has four radial terms, instant-ngp's the first two.
const StatedLens& transforms_lens(LensModel model) {
  static const StatedLens kPerspective{"OPENCV", {kK1, kK2, kK3, kK4, kP1, kP2}};
  static const StatedLens kEquidistant{"OPENCV_FISHEYE", {kK1, kK2, kK3, kK4}};
  return chosen_lens(kPerspective, kEquidistant, model);
}

const StatedLens& opensfm_lens(LensModel model) {
  static const StatedLens kPerspective{"brown", {kK1, kK2, kK3, kP1, kP2}};
  static const StatedLens kEquidistant{"fisheye_opencv", {kK1, kK2, kK3, kK4}};
  return chosen_lens(kPerspective, kEquidistant, model);
}

void add_terms(const StatedLens& lens, const Distortion& d, OrderedJson& out) {
  for (const LensTerm& term : lens.terms) out[term.name] = d.*term.term;
}

OrderedJson transforms_camera(const Camera& c) {
  const StatedLens& lens = transforms_lens(c.distortion.model);
  OrderedJson out = {{"camera_model", lens.name},
                     {"w", c.width},
                     {"h", c.height},
                     {"fl_x", c.fx},
                     {"fl_y", c.fy},
                     {"cx", c.cx},
                     {"cy", c.cy}};
  add_terms(lens, c.distortion, out);
  return out;
}

/// Camera to world, of a camera whose y points up and z back.
OrderedJson transform_matrix(const Pose& pose) {
  const auto& r = pose.rotation;
  const std::array<double, 3> centre{pose.centre.x, pose.centre.y, pose.centre.z};
  OrderedJson rows = OrderedJson::array();
  for (std::size_t i = 0; i < 3; ++i) rows.push_back({r[i], -r[3 + i], -r[6 + i], centre[i]});
  rows.push_back({0, 0, 0, 1});
  return rows;
}

/// Lengths are divided by the longer side, positions relative to the middle.
OrderedJson opensfm_camera(const Camera& c) {
  const StatedLens& lens = opensfm_lens(c.distortion.model);
  const double longer = std::max(c.width, c.height);
  OrderedJson out = {{"projection_type", lens.name},
                     {"width", c.width},
                     {"height", c.height},
                     {"focal_x", c.fx / longer},
                     {"focal_y", c.fy / longer},
                     {"c_x", (c.cx - c.width / 2.0) / longer},
                     {"c_y", (c.cy - c.height / 2.0) / longer}};
  add_terms(lens, c.distortion, out);
  return out;
}

/// The reference of a scene in east, north and up; null for other systems.
OrderedJson reference_lla(const Scene& scene) {
  std::string_view srs = scene.srs;
  if (!srs.starts_with("ENU:")) return nullptr;
  srs.remove_prefix(4);
  const std::size_t comma = std::min(srs.find(','), srs.size());
  const auto latitude = number_from(srs.substr(0, comma));
  const auto longitude = number_from(srs.substr(std::min(comma + 1, srs.size())));
  if (!latitude || !longitude || scene.offset.x != 0 || scene.offset.y != 0) return nullptr;
  return {{"latitude", *latitude}, {"longitude", *longitude}, {"altitude", scene.offset.z}};
}

void write_json(const fs::path& folder, const char* name, const OrderedJson& json) {
  try {
    write_file(folder / name, json.dump(2) + '\n');
  } catch (const OrderedJson::type_error&) {
    throw OutputError(folder, "a photo's name is not UTF-8, which JSON has to be");
  }
}

}  // namespace

std::optional<std::string> lost_in_transforms(const Camera& c) { return lost_beyond(transforms_lens, c.distortion); }
std::optional<std::string> lost_in_opensfm(const Camera& c) { return lost_beyond(opensfm_lens, c.distortion); }

void write_transforms(const PlacedScene& scene) {
  const bool one_camera = scene.cameras.size() == 1;
  OrderedJson root = one_camera ? transforms_camera(scene.cameras[0]) : OrderedJson::object();
  OrderedJson frames = OrderedJson::array();
  for (const PlacedView& placed : scene.views) {
    OrderedJson frame = {{"file_path", placed.place.generic_string()}};
    const fs::path mask = mask_in_folder(placed.place);
    if (is_file(scene.folder / mask)) frame["mask_path"] = mask.generic_string();
    if (!one_camera) frame.update(transforms_camera(placed.view.camera));
    frame["transform_matrix"] = transform_matrix(placed.view.pose);
    frames.push_back(std::move(frame));
  }
  root["frames"] = std::move(frames);
  write_json(scene.folder, "transforms.json", root);
}

/// OpenSfM looks for masks by the photos' names.
void write_opensfm(const PlacedScene& scene) {
  OrderedJson cameras = OrderedJson::object(), shots = OrderedJson::object();
  const auto name_of_camera = [](std::size_t camera) { return "camera " + std::to_string(camera + 1); };
  for (std::size_t c = 0; c < scene.cameras.size(); ++c) cameras[name_of_camera(c)] = opensfm_camera(scene.cameras[c]);
  for (const auto& [view, place, camera] : scene.views) {
    const WorldPoint t = translation(view.pose);
    shots[place.lexically_relative("images").generic_string()] = {
        {"rotation", angle_axis_from_rotation(view.pose.rotation)},
        {"translation", {t.x, t.y, t.z}},
        {"camera", name_of_camera(camera)},
        {"orientation", 1}};
  }
  OrderedJson reconstruction = {
      {"cameras", std::move(cameras)}, {"shots", std::move(shots)}, {"points", OrderedJson::object()}};
  if (OrderedJson reference = reference_lla(scene.scene); !reference.is_null())
    reconstruction["reference_lla"] = std::move(reference);
  write_json(scene.folder, "reconstruction.json", OrderedJson::array({std::move(reconstruction)}));
}

}  // namespace gpvc::io
