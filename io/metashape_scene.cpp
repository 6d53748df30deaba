// Agisoft Metashape's cameras.xml (File > Export > Export Cameras): Metashape User Manual, Professional
// Edition, appendix "Camera models" for lenses and axes.
//
// Pixels   the centre of the upper left pixel is (0.5, 0.5), x right, y down: ours. cx, cy are counted from
// the
//          middle of the photo.
// Camera   x right, y down, z forward: ours.
// Pose     a camera's transform takes camera to chunk coordinates, the chunk's (or its component's) transform
// takes
//          those to the world: rotation, scale, translation. In a chunk that is georeferenced the world is
//          geocentric; otherwise local.
// Lens     on the normalized plane (frame) or on it bent to theta / r (fisheye, equidistant_fisheye) or
//          2 sin(theta / 2) / r (equisolid_fisheye; the manual of 2.3 has both, and for the first the formula
//          that earlier ones have for "fisheye"):
//          x' = x (1 + K1 r2 + .. + K4 r8) + (P1 (r2 + 2 x x) + 2 P2 x y) (1 + P3 r2 + P4 r4),
//          and y' likewise: P1 and P2 in the other order than OpenCV's;
//          u = w / 2 + cx + x' f + x' B1 + y' B2, v = h / 2 + cy + y' f.
//          Files of PhotoScan before 1.2 state fx, fy, skew, cx and cy from the corner, and P1, P2 as OpenCV
//          does.
#include <cmath>
#include <map>

#include "io/file_bytes.h"
#include "io/scene_file.h"
#include "io/text_scan.h"
#include "io/xml_file.h"

namespace gpvc {

namespace {

namespace fs = std::filesystem;

/// world = scale * rotation * local + translation
struct Placement {
  Matrix3 rotation{1, 0, 0, 0, 1, 0, 0, 0, 1};
  WorldPoint translation{};
  double scale = 1;
};

class MetashapeReader {
 public:
  MetashapeReader(const fs::path& file, std::string_view text) : xml_(file, text) { scene_.listing = file; }

  SceneFile read() {
    const pugi::xml_node root = xml_.root();
    if (std::string_view(root.name()) != "document")
      xml_.fail(root, "expected <document>, found " + in_quotes(root.name()));
    const pugi::xml_node chunk = chunk_of(root);
    for (const pugi::xml_node sensor : chunk.child("sensors").children("sensor"))
      sensors_[sensor.attribute("id").as_string()] = sensor;
    read_placements(chunk);
    read_cameras(chunk);
    read_reference(chunk);
    return std::move(scene_);
  }

 private:
  /// Cameras with their groups opened, in the file's order.
  static std::vector<pugi::xml_node> cameras_of(const pugi::xml_node& chunk) {
    std::vector<pugi::xml_node> cameras, open{chunk.child("cameras")};
    while (!open.empty()) {
      const pugi::xml_node folder = open.back();
      open.pop_back();
      for (const pugi::xml_node node : folder.children()) {
        if (std::string_view(node.name()) == "camera") cameras.push_back(node);
        if (std::string_view(node.name()) == "group") open.push_back(node);
      }
    }
    return cameras;
  }

  static bool is_placed(const pugi::xml_node& camera) { return camera.child("transform").first_child(); }

  pugi::xml_node chunk_of(const pugi::xml_node& root) {
    pugi::xml_node best;
    std::size_t most = 0, chunks = 0;
    std::vector<pugi::xml_node> candidates;
    for (const pugi::xml_node chunk : root.children("chunk")) candidates.push_back(chunk);
    for (const pugi::xml_node chunk : root.child("chunks").children("chunk")) candidates.push_back(chunk);
    for (const pugi::xml_node& chunk : candidates) {
      ++chunks;
      std::size_t placed = 0;
      for (const pugi::xml_node& camera : cameras_of(chunk)) placed += is_placed(camera) ? 1 : 0;
      if (placed > most) best = chunk, most = placed;
    }
    if (most == 0) xml_.fail(root, "no camera has a transform: align the photos before the export");
    if (chunks > 1)
      scene_.warnings.push_back("the file holds " + std::to_string(chunks) + " chunks; '" +
                                best.attribute("label").as_string() + "' is read, it has the most cameras");
    return best;
  }

  /// `count` numbers of the node's text.
  std::vector<double> numbers(const pugi::xml_node& node, std::size_t count) const {
    std::string_view text = node.child_value();
    std::vector<double> values;
    for (std::string_view word = next_word(text); !word.empty(); word = next_word(text)) {
      const std::optional<double> value = number_from(word);
      if (!value || !std::isfinite(*value))
        xml_.fail(node,
                  "expected finite numbers in " + std::string(node.name()) + ", found " + in_quotes(word));
      if (values.size() == count) xml_.fail(node, "more than " + std::to_string(count) + " numbers");
      values.push_back(*value);
    }
    if (values.size() != count)
      xml_.fail(node, "expected " + std::to_string(count) + " numbers in " + node.name() + ", found " +
                          std::to_string(values.size()));
    return values;
  }

  Matrix3 rotation_of(const pugi::xml_node& node, const Matrix3& m) const {
    const auto rotation = rotation_near(m);
    if (!rotation) xml_.fail(node, "the matrix in " + std::string(node.name()) + " is no rotation");
    return *rotation;
  }

  Placement placement_of(const pugi::xml_node& transform) const {
    Placement out;
    if (const pugi::xml_node node = transform.child("rotation")) {
      const std::vector<double> m = numbers(node, 9);
      Matrix3 matrix{};
      std::copy(m.begin(), m.end(), matrix.begin());
      out.rotation = rotation_of(node, matrix);
    }
    if (const pugi::xml_node node = transform.child("translation")) {
      const std::vector<double> t = numbers(node, 3);
      out.translation = {t[0], t[1], t[2]};
    }
    if (const pugi::xml_node node = transform.child("scale")) {
      out.scale = numbers(node, 1)[0];
      if (!(out.scale > 0)) xml_.fail(node, "the scale is not positive");
    }
    return out;
  }

  void read_placements(const pugi::xml_node& chunk) {
    if (const pugi::xml_node transform = chunk.child("transform")) {
      of_chunk_ = placement_of(transform);
      referenced_ = true;
    }
    for (const pugi::xml_node component : chunk.child("components").children("component"))
      if (const pugi::xml_node transform = component.child("transform")) {
        of_component_[component.attribute("id").as_string()] = placement_of(transform);
        referenced_ = true;
      }
  }

  void read_cameras(const pugi::xml_node& chunk) {
    std::map<std::string, std::size_t> components;
    std::vector<pugi::xml_node> placed;
    std::size_t unplaced = 0, disabled = 0;
    for (const pugi::xml_node& camera : cameras_of(chunk)) {
      if (!camera.attribute("enabled").as_bool(true)) {
        ++disabled;
      } else if (!is_placed(camera)) {
        ++unplaced;
      } else {
        placed.push_back(camera);
        ++components[camera.attribute("component_id").as_string()];
      }
    }
    if (placed.empty()) xml_.fail(chunk, "every camera with a transform is disabled");
    std::string main = components.begin()->first;
    for (const auto& [id, count] : components)
      if (count > components[main]) main = id;
    for (const pugi::xml_node& camera : placed)
      if (camera.attribute("component_id").as_string() == main) read_camera(camera);
    warn("cameras without a transform are left out", unplaced);
    warn("disabled cameras are left out", disabled);
    warn("cameras of other components than the largest are left out", placed.size() - components[main]);
  }

  void warn(const char* what, std::size_t count) {
    if (count > 0) scene_.warnings.push_back(std::to_string(count) + " " + what);
  }

  void read_camera(const pugi::xml_node& node) {
    View view;
    view.name = slashed(node.attribute("label").as_string());
    if (view.name.empty()) xml_.fail(node, "a camera without a label");
    const std::string sensor = node.attribute("sensor_id").as_string();
    const auto found = sensors_.find(sensor);
    if (found == sensors_.end()) xml_.fail(node, "sensor " + in_quotes(sensor) + " is not in the file");
    const auto [camera, fresh] = cameras_.try_emplace(sensor);
    if (fresh) camera->second = camera_of(found->second);
    view.camera = camera->second;

    const auto component = of_component_.find(node.attribute("component_id").as_string());
    const Placement& place = component == of_component_.end() ? of_chunk_ : component->second;
    const pugi::xml_node transform = node.child("transform");
    const std::vector<double> m = numbers(transform, 16);
    const Matrix3 chunk_from_camera =
        rotation_of(transform, {m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]});
    const WorldPoint c = product(place.rotation, WorldPoint{m[3], m[7], m[11]});
    view.pose =
        finish_pose(xml_.path(), xml_.place(node), transposed(product(place.rotation, chunk_from_camera)),
                    {place.scale * c.x + place.translation.x, place.scale * c.y + place.translation.y,
                     place.scale * c.z + place.translation.z});
    scene_.views.push_back(std::move(view));
  }

  pugi::xml_node calibration_of(const pugi::xml_node& sensor) const {
    pugi::xml_node best;
    for (const pugi::xml_node calibration : sensor.children("calibration"))
      if (!best || std::string_view(calibration.attribute("class").as_string()) == "adjusted")
        best = calibration;
    if (!best) xml_.fail(sensor, "the sensor of a camera has no calibration");
    return best;
  }

  Camera camera_of(const pugi::xml_node& sensor) const {
    const pugi::xml_node node = calibration_of(sensor);
    const std::string_view type =
        node.attribute("type").as_string(sensor.attribute("type").as_string("frame"));
    Camera camera;
    Distortion& d = camera.distortion;
    if (type == "frame")
      d.model = LensModel::perspective;
    else if (type == "fisheye" || type == "equidistant_fisheye")
      d.model = LensModel::equidistant;
    else if (type == "equisolid_fisheye")
      d.model = LensModel::equisolid;
    else
      xml_.fail(node, "a camera of type " + in_quotes(type) + " is not supported, frame and fisheye are");
    const pugi::xml_node resolution =
        node.child("resolution") ? node.child("resolution") : sensor.child("resolution");
    camera.width = side_of(sensor, resolution, "width");
    camera.height = side_of(sensor, resolution, "height");
    const auto term = [&](const char* name) { return xml_.number(node, name).value_or(0); };
    d.k1 = term("k1");
    d.k2 = term("k2");
    d.k3 = term("k3");
    d.k4 = term("k4");
    d.p3 = term("p3");
    d.p4 = term("p4");
    double skew = 0;
    if (node.child("fx")) {
      camera.fx = xml_.needed(node, "fx");
      camera.fy = xml_.needed(node, "fy");
      camera.cx = xml_.needed(node, "cx");
      camera.cy = xml_.needed(node, "cy");
      d.p1 = term("p1");
      d.p2 = term("p2");
      skew = term("skew");
    } else {
      camera.fy = xml_.needed(node, "f");
      camera.fx = camera.fy + term("b1");
      camera.cx = camera.width / 2.0 + term("cx");
      camera.cy = camera.height / 2.0 + term("cy");
      d.p2 = term("p1");
      d.p1 = term("p2");
      skew = term("b2");
    }
    if (camera.fx != 0) d.skew = skew / camera.fx;
    finish_camera(xml_.path(), xml_.place(node), camera);
    return camera;
  }

  int side_of(const pugi::xml_node& sensor, const pugi::xml_node& resolution, const char* name) const {
    const auto value = integer_from<std::int64_t>(resolution.attribute(name).as_string());
    if (!value || *value < 1 || *value > 1 << 24)
      xml_.fail(resolution ? resolution : sensor,
                std::string("expected a resolution with a ") + name + " of 1 to 2^24 pixels");
    return static_cast<int>(*value);
  }

  void read_reference(const pugi::xml_node& chunk) {
    const std::string_view reference = XmlFile::text(chunk, "reference");
    if (!referenced_ || reference.empty() || reference.starts_with("LOCAL_CS")) return;
    scene_.srs = "EPSG:4978";
    scene_.warnings.push_back(
        "the chunk is georeferenced, so its cameras are in geocentric coordinates (ECEF); the mesh has to be "
        "exported in them, too (coordinate system 'WGS 84 (EPSG::4978)')");
  }

  XmlFile xml_;
  SceneFile scene_;
  std::map<std::string, pugi::xml_node> sensors_;
  std::map<std::string, Camera> cameras_;
  std::map<std::string, Placement> of_component_;
  Placement of_chunk_;
  bool referenced_ = false;
};

bool fits(const fs::path& file) {
  return has_xml_root(file, "document") && first_bytes(file, 1u << 14).find("<chunk") != std::string::npos;
}

std::optional<fs::path> find(const fs::path& source) {
  if (fits(source)) return source;
  return only_file(source, ".xml", fits);
}

SceneFile parse(const fs::path& file, std::string_view text) { return MetashapeReader(file, text).read(); }

SceneFile read(const fs::path& found) {
  const FileBytes bytes(found);
  SceneFile scene = parse(found, bytes.view());
  const fs::path folder = folder_of(found);
  scene.image_folders = {folder / "images", folder / "photos", folder / ".." / "images", folder};
  return scene;
}

}  // namespace

const SceneFormat& metashape_scene() {
  static constexpr SceneFormat kFormat{"Metashape", "an Agisoft Metashape cameras.xml (or a folder with one)",
                                       find, read, parse};
  return kFormat;
}

}  // namespace gpvc
