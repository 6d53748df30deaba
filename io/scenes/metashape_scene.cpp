// Agisoft Metashape's cameras.xml (File > Export > Export Cameras): Metashape User Manual, Professional Edition,
// appendix "Camera models" for lenses and axes.
//
// Pixels   the centre of the upper left pixel is (0.5, 0.5), x right, y down: ours. cx, cy are counted from the
//          middle of the photo.
// Camera   x right, y down, z forward: ours.
// Pose     a camera's transform takes camera to chunk coordinates, the chunk's (or its component's) transform takes
//          those to the world: rotation, scale, translation. In a chunk that is georeferenced the world is
//          geocentric; otherwise local.
// Rig      a camera with a master_id usually has no transform: its master's places it. Rotation and location of a
//          sensor take its camera's coordinates to those of the rig, the identity where none are stated:
//          chunk_from_slave = chunk_from_master * inverse([R | l] of the master's) * [R | l] of the slave's;
//          l counts in units of the chunk, like a transform. The manual is silent. Two sources agree: the converter
//          that made the poses of Meta's Eyeful Tower data set (world2slave = inverse([R | l]) * world2master, the
//          chunk's scale after that), and the community's Metashape Expert Manual (sensor.rotation is slave to
//          master, sensor.location the slave's centre there).
// Shutter  a camera's rolling_shutter has a rotation dR and a translation t, of which the manual says nothing. Marker
//          projections of a real project decide (goya_test of github.com/UTokyo-FieldPhenomics-Lab/EasyIDP, 184 of 20 coded
//          targets in photos of a DJI Mini): what lies at x in the camera's axes lies at dR^s (x - s t) when a row was
//          read, with s from -1 in the first to 1 in the last; t counts in units of the chunk, like a transform. The targets'
//          projections then differ by 0.28 px (root of the mean square) from those of one point, and by 6.07 px without it;
//          with the factors and the middle row free, the fit has them at 1.99, 1.97 and 0.499 of the height.
// Labels   usually file names without folders, so they repeat when the photos of a flight fill several.
// Lens     on the normalized plane (frame) or on it bent to theta / r (fisheye, equidistant_fisheye) or 2 sin(theta
//          / 2) / r (equisolid_fisheye; the manual of 2.3 has both, and for the first the formula that earlier ones
//          have for "fisheye"):
//          x' = x (1 + K1 r2 + .. + K4 r8) + (P1 (r2 + 2 x x) + 2 P2 x y) (1 + P3 r2 + P4 r4),
//          and y' in the same way, P1 and P2 in the other order than OpenCV's;
//          u = w / 2 + cx + x' f + x' B1 + y' B2, v = h / 2 + cy + y' f.
//          Of panoramas (spherical), u = w / 2 + f atan(X / Z), v = h / 2 + f atan(Y / sqrt(X^2 + Z^2)), f = w / (2 pi).
//          Files of PhotoScan before 1.2 state fx, fy, skew, cx and cy from the corner, and P1, P2 as OpenCV does.
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "io/files/text_scan.h"
#include "io/lens_terms.h"
#include "io/number_text.h"
#include "io/reference_system.h"
#include "io/scenes/panorama_views.h"
#include "io/scenes/scene_file.h"
#include "io/scenes/xml_file.h"

namespace gpvc::io {

namespace {

/// world = scale * rotation * local + translation
struct Placement {
  Matrix3 rotation{1, 0, 0, 0, 1, 0, 0, 0, 1};
  WorldPoint translation{};
  double scale = 1;
};

struct RigCamera {
  pugi::xml_node node;
  pugi::xml_node placed_by;  ///< itself or its master, whichever has a transform; or null
};

class MetashapeReader {
 public:
  MetashapeReader(const fs::path& file, std::string_view text) : xml_(file, text) { scene_.listing = file; }

  SceneFile read() {
    const pugi::xml_node root = xml_.root("document");
    const pugi::xml_node chunk = chunk_of(root);
    for (const pugi::xml_node sensor : chunk.child("sensors").children("sensor"))
      sensors_[sensor.attribute("id").as_string()] = sensor;
    read_placements(chunk);
    read_cameras(chunk);
    read_reference(chunk);
    return std::move(scene_);
  }

 private:
  static std::vector<pugi::xml_node> in_order(pugi::xpath_node_set nodes) {
    nodes.sort();
    std::vector<pugi::xml_node> sorted;
    for (const pugi::xpath_node& node : nodes) sorted.push_back(node.node());
    return sorted;
  }

  /// Cameras, also those in groups, in the file's order.
  static std::vector<RigCamera> cameras_of(const pugi::xml_node& chunk) {
    std::vector<RigCamera> cameras;
    std::map<std::string, pugi::xml_node> by_id;
    for (const pugi::xml_node node : in_order(chunk.select_nodes("cameras//camera"))) {
      cameras.push_back({node, {}});
      by_id.emplace(node.attribute("id").as_string(), node);
    }
    for (RigCamera& camera : cameras) {
      const auto master = by_id.find(camera.node.attribute("master_id").as_string());
      if (has_transform(camera.node))
        camera.placed_by = camera.node;
      else if (camera.node.attribute("master_id") && master != by_id.end() && has_transform(master->second))
        camera.placed_by = master->second;
    }
    return cameras;
  }

  static bool has_transform(const pugi::xml_node& camera) { return camera.child("transform").first_child(); }

  pugi::xml_node chunk_of(const pugi::xml_node& root) {
    pugi::xml_node best;
    std::size_t most = 0;
    const std::vector<pugi::xml_node> chunks = in_order(root.select_nodes("chunk | chunks/chunk"));
    for (const pugi::xml_node& chunk : chunks) {
      std::size_t placed = 0;
      for (const RigCamera& camera : cameras_of(chunk)) placed += camera.placed_by ? 1 : 0;
      if (placed <= most) continue;
      best = chunk;
      most = placed;
    }
    if (most == 0) xml_.fail(root, "no camera has a transform: align the photos before the export");
    if (chunks.size() > 1)
      scene_.warnings.push_back("the file holds " + std::to_string(chunks.size()) + " chunks; '" +
                                best.attribute("label").as_string() + "' is read, it has the most cameras");
    return best;
  }

  Matrix3 rotation_of(const pugi::xml_node& node, const Matrix3& m) const {
    const auto rotation = rotation_near(m);
    if (!rotation) xml_.fail(node, "the matrix in " + std::string(node.name()) + " is no rotation");
    return *rotation;
  }

  Matrix3 rotation_in(const pugi::xml_node& node) const {
    const std::vector<double> m = xml_.numbers(node, 9);
    Matrix3 matrix{};
    std::copy(m.begin(), m.end(), matrix.begin());
    return rotation_of(node, matrix);
  }

  WorldPoint point_in(const pugi::xml_node& node) const {
    const std::vector<double> p = xml_.numbers(node, 3);
    return {p[0], p[1], p[2]};
  }

  Placement placement_of(const pugi::xml_node& transform) const {
    Placement out;
    if (const pugi::xml_node node = transform.child("rotation")) out.rotation = rotation_in(node);
    if (const pugi::xml_node node = transform.child("translation")) out.translation = point_in(node);
    if (const pugi::xml_node node = transform.child("scale")) {
      out.scale = xml_.numbers(node, 1)[0];
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
    std::vector<RigCamera> usable;
    std::map<std::string, std::size_t> components, other_lenses;
    pugi::xml_node other_sensor;
    std::size_t unplaced = 0, disabled = 0;
    for (const RigCamera& camera : cameras_of(chunk)) {
      const auto sensor = sensors_.find(camera.node.attribute("sensor_id").as_string());
      if (!camera.node.attribute("enabled").as_bool(true)) {
        ++disabled;
      } else if (!camera.placed_by) {
        ++unplaced;
      } else if (sensor != sensors_.end() && !model_of(type_of(sensor->second))) {
        ++other_lenses[type_of(sensor->second)];
        other_sensor = sensor->second;
      } else {
        usable.push_back(camera);
      }
    }
    if (usable.empty() && other_sensor)
      xml_.fail(other_sensor, "a camera of type " + quote(type_of(other_sensor)) +
                                  " is not supported; frame, fisheye and spherical are");
    if (usable.empty()) xml_.fail(chunk, "every camera with a transform is disabled");
    leave_out_unlabelled(usable);
    for (const RigCamera& camera : usable) ++components[component_of(camera)];
    const auto [main, most] = *std::max_element(components.begin(), components.end(),
                                                [](const auto& a, const auto& b) { return a.second < b.second; });
    scene_.warn(unplaced, "cameras without a transform are left out");
    scene_.warn(disabled, "disabled cameras are left out");
    for (const auto& [type, count] : other_lenses)
      scene_.warn(count,
                  "cameras are left out: their lens, " + quote(type) + ", is no perspective, fisheye or spherical one");
    scene_.warn(usable.size() - most, "cameras of other components than the largest are left out");
    std::erase_if(usable, [&, &id = main](const RigCamera& camera) { return component_of(camera) != id; });
    if (const auto component = of_component_.find(main); component != of_component_.end())
      of_views_ = component->second;
    else
      of_views_ = of_chunk_;
    read_views(usable);
  }

  static std::string component_of(const RigCamera& camera) {
    return camera.placed_by.attribute("component_id").as_string();
  }

  void read_views(const std::vector<RigCamera>& cameras) {
    const std::vector<std::string> names = names_of(cameras);
    std::set<std::string> bands;
    std::size_t slaves = 0, unknown = 0;
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      if (names[i].empty()) continue;
      read_view(cameras[i], names[i]);
      slaves += cameras[i].placed_by != cameras[i].node ? 1 : 0;
      const bool modelled = scene_.views.back().camera.distortion.motion.moves();
      unknown += !modelled && (moved(cameras[i].node) || moved(sensor_of(cameras[i].node))) ? 1 : 0;
      if (const std::string shown = bands_of(sensor_of(cameras[i].node)); !shown.empty()) bands.insert(shown);
    }
    scene_.warn(slaves, "cameras are placed by their master in a rig, having no transform of their own");
    scene_.warn(
        unknown,
        "cameras moved while their photos were read out (rolling shutter), and how is not stated in a known way: "
        "they are taken to stand still");
    if (bands.size() < 2) return;
    std::string all;
    for (const std::string& shown : bands) all += (all.empty() ? "" : ", ") + quote(shown);
    scene_.warnings.push_back("the cameras show different bands, " + all +
                              ", which the texture mixes: leave out those that it is not to show");
  }

  /// Takes out cameras whose label names no photo.
  void leave_out_unlabelled(std::vector<RigCamera>& cameras) {
    std::optional<InputError> first;
    const std::size_t count = std::erase_if(cameras, [&](const RigCamera& camera) {
      try {
        stated_photo_name(xml_.path(), xml_.place(camera.node),
                          with_slashes(camera.node.attribute("label").as_string()));
        return false;
      } catch (const InputError& error) {
        if (!first) first = error;
        return true;
      }
    });
    if (first && cameras.empty()) throw *first;
    if (first) scene_.warn(count, "cameras are left out, as their label names no photo: " + std::string(first->what()));
  }

  /// Views' names; empty for the cameras that repeat another's.
  std::vector<std::string> names_of(const std::vector<RigCamera>& cameras) {
    std::vector<std::string> names;
    std::map<std::string, std::size_t> uses;
    for (const RigCamera& camera : cameras) {
      names.push_back(with_slashes(camera.node.attribute("label").as_string()));
      ++uses[names.back()];
    }
    std::set<std::string> taken;  // labels that are unique remain, whatever the others are called
    for (const auto& [label, count] : uses)
      if (count == 1) taken.insert(label);
    std::size_t repeated = 0;
    std::string example;
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      if (uses[names[i]] == 1) continue;
      names[i] = in_group(cameras[i].node.parent(), names[i]);
      if (taken.insert(names[i]).second) continue;
      if (++repeated == 1) example = names[i];
      names[i].clear();
    }
    scene_.warn(repeated, "cameras are left out: others have their label and group, as " + quote(example));
    return names;
  }

  /// The label below that of its group, which is a folder's as a rule. Only what can be a folder's name is taken of it,
  /// and nothing for a label that is a whole path.
  static std::string in_group(const pugi::xml_node& group, const std::string& label) {
    if (std::string_view(group.name()) != "group" || label.starts_with('/') || label.starts_with("..") ||
        label.find(':') != label.npos)
      return label;
    const std::string folders = with_slashes(group.attribute("label").as_string());
    std::string name;
    for (std::size_t begin = 0; begin < folders.size();) {
      const std::size_t end = std::min(folders.find('/', begin), folders.size());
      const std::string part = folders.substr(begin, end - begin);
      if (!part.empty() && part != "." && !part.starts_with("..") && part.find(':') == part.npos) name += part + "/";
      begin = end + 1;
    }
    return name + label;
  }

  /// True if a camera, or those of a sensor, are said to have moved: anything called rolling shutter counts unless it is
  /// said to be off. A still camera has the rotation 1 and no translation.
  bool moved(const pugi::xml_node& of) const {
    if (states_motion(of)) return motion_in(of).moves();
    const auto names_it = [](std::string_view name) { return lower_case(name).find("rolling_shutter") != name.npos; };
    const auto is_on = [](std::string_view value) {
      const std::string word = lower_case(trimmed(value));
      return word != "0" && word != "false" && word != "disabled" && word != "none";
    };
    for (const pugi::xml_attribute attribute : of.attributes())
      if (names_it(attribute.name()) && is_on(attribute.value())) return true;
    for (const pugi::xml_node child : of.children()) {
      if (names_it(child.name()) && is_on(child.child_value())) return true;
      if (names_it(child.attribute("name").value()) && is_on(child.attribute("value").value())) return true;
    }
    return false;
  }

  static bool states_motion(const pugi::xml_node& camera) {
    const pugi::xml_node shutter = camera.child("rolling_shutter");
    return shutter.child("rotation").first_child() || shutter.child("translation").first_child();
  }

  /// In the coordinates of the camera's transform. \pre states_motion()
  Motion motion_in(const pugi::xml_node& camera) const {
    Motion motion;
    const pugi::xml_node shutter = camera.child("rolling_shutter");
    if (const pugi::xml_node node = shutter.child("rotation"); node.first_child())
      motion.turn = angle_axis_from_rotation(rotation_in(node));
    if (const pugi::xml_node node = shutter.child("translation"); node.first_child()) {
      const WorldPoint step = point_in(node);
      motion.step = {step.x, step.y, step.z};
    }
    if (motion != Motion{}) motion.down = 2;  // from -1 to 1
    return motion;
  }

  static std::string bands_of(const pugi::xml_node& sensor) {
    std::string bands;
    for (const pugi::xml_node band : sensor.child("bands").children("band")) {
      if (!bands.empty()) bands += ' ';
      bands += band.attribute("label").as_string();
    }
    return bands;
  }

  pugi::xml_node sensor_of(const pugi::xml_node& camera) const {
    const std::string id = camera.attribute("sensor_id").as_string();
    const auto found = sensors_.find(id);
    if (found == sensors_.end()) xml_.fail(camera, "sensor " + quote(id) + " is not in the file");
    return found->second;
  }

  void read_view(const RigCamera& from, const std::string& name) {
    View view;
    view.name = name;
    const pugi::xml_node sensor = sensor_of(from.node);
    const auto [camera, fresh] = cameras_.try_emplace(from.node.attribute("sensor_id").as_string());
    if (fresh) camera->second = camera_of(sensor);
    view.camera = camera->second;

    const pugi::xml_node transform = from.placed_by.child("transform");
    const std::vector<double> m = xml_.numbers(transform, 16);
    Placement chunk_from_camera{rotation_of(transform, {m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]}),
                                {m[3], m[7], m[11]}};
    if (from.placed_by != from.node)
      chunk_from_camera = chained(chunk_from_camera, master_from_slave(sensor_of(from.placed_by), sensor));
    const Placement world_from_camera = chained(of_views_, chunk_from_camera);
    view.pose = finish_pose(xml_.path(), xml_.place(from.node), transposed(world_from_camera.rotation),
                            world_from_camera.translation);
    if (from.placed_by == from.node && states_motion(from.node) && !is_spherical(view.camera.distortion.model)) {
      Motion& motion = view.camera.distortion.motion;
      motion = motion_in(from.node);
      for (double& length : motion.step) length *= of_views_.scale;
    }
    scene_.views.push_back(std::move(view));
  }

  /// a_from_b and b_from_c make a_from_c.
  static Placement chained(const Placement& a, const Placement& b) {
    const WorldPoint t = product(a.rotation, b.translation);
    return {product(a.rotation, b.rotation),
            {a.scale * t.x + a.translation.x, a.scale * t.y + a.translation.y, a.scale * t.z + a.translation.z},
            a.scale * b.scale};
  }

  Placement master_from_slave(const pugi::xml_node& master, const pugi::xml_node& slave) const {
    const Placement rig_from_master = offset_of(master), rig_from_slave = offset_of(slave);
    Placement master_from_rig{transposed(rig_from_master.rotation), {}};
    const WorldPoint t = product(master_from_rig.rotation, rig_from_master.translation);
    master_from_rig.translation = {-t.x, -t.y, -t.z};
    return chained(master_from_rig, rig_from_slave);
  }

  /// The sensor's pose in a rig, as far as it is stated; <rotation fixed="true"/> states nothing.
  Placement offset_of(const pugi::xml_node& sensor) const {
    Placement out;
    if (const pugi::xml_node node = sensor.child("rotation"); node.first_child()) out.rotation = rotation_in(node);
    if (const pugi::xml_node node = sensor.child("location"); node.first_child()) out.translation = point_in(node);
    return out;
  }

  /// Null where the sensor has none, as panoramas do.
  static pugi::xml_node calibration_of(const pugi::xml_node& sensor) {
    pugi::xml_node best;
    for (const pugi::xml_node calibration : sensor.children("calibration"))
      if (!best || std::string_view(calibration.attribute("class").as_string()) == "adjusted") best = calibration;
    return best;
  }

  static const char* type_of(const pugi::xml_node& sensor) {
    return calibration_of(sensor).attribute("type").as_string(sensor.attribute("type").as_string("frame"));
  }

  static std::optional<LensModel> model_of(std::string_view type) {
    if (type == "frame") return LensModel::perspective;
    if (type == "fisheye" || type == "equidistant_fisheye") return LensModel::equidistant;
    if (type == "equisolid_fisheye") return LensModel::equisolid;
    if (type == "spherical") return LensModel::spherical;
    return std::nullopt;
  }

  Camera camera_of(const pugi::xml_node& sensor) {
    const pugi::xml_node node = calibration_of(sensor);
    Camera camera;
    Distortion& d = camera.distortion;
    d.model = model_of(type_of(sensor)).value();  // read_cameras left out those of other types
    const pugi::xml_node resolution = node.child("resolution") ? node.child("resolution") : sensor.child("resolution");
    camera.width = side_of(sensor, resolution, "width");
    camera.height = side_of(sensor, resolution, "height");
    if (is_spherical(d.model))
      return panorama_camera(xml_.path(), xml_.place(sensor), camera.width, camera.height,
                             camera.width / (2 * std::numbers::pi));
    if (!node) return finished(sensor, uncalibrated(sensor, camera));
    const auto term = [&](const char* name) { return xml_.number(node, name).value_or(0); };
    constexpr LensTerm kTerms[] = {{"k1", &Distortion::k1}, {"k2", &Distortion::k2}, {"k3", &Distortion::k3},
                                   {"k4", &Distortion::k4}, {"p1", &Distortion::p2}, {"p2", &Distortion::p1},
                                   {"p3", &Distortion::p3}, {"p4", &Distortion::p4}};
    for (const auto& [name, member] : kTerms) d.*member = term(name);
    double skew = 0;
    if (node.child("fx")) {
      camera.fx = xml_.needed(node, "fx");
      camera.fy = xml_.needed(node, "fy");
      camera.cx = xml_.needed(node, "cx");
      camera.cy = xml_.needed(node, "cy");
      std::swap(d.p1, d.p2);
      skew = term("skew");
    } else {
      camera.fy = xml_.needed(node, "f");
      camera.fx = camera.fy + term("b1");
      camera.cx = camera.width / 2.0 + term("cx");
      camera.cy = camera.height / 2.0 + term("cy");
      skew = term("b2");
    }
    if (camera.fx != 0) d.skew = skew / camera.fx;
    return finished(node, camera);
  }

  Camera finished(const pugi::xml_node& node, Camera camera) const {
    finish_camera(xml_.path(), xml_.place(node), camera);
    return camera;
  }

  /// A sensor that is fixed to what the photos' EXIF data say of it has no calibration: its focal length and the size of
  /// its pixels stand among its properties, in millimetres.
  Camera uncalibrated(const pugi::xml_node& sensor, Camera camera) {
    const auto length = [&](const char* name) {
      const pugi::xml_node property = sensor.find_child_by_attribute("property", "name", name);
      const std::optional<double> value = number_from(trimmed(property.attribute("value").as_string()));
      if (!value || !(*value > 0) || !std::isfinite(*value))
        xml_.fail(sensor, "the sensor of a camera has no calibration, and no positive " + quote(name) +
                              " among its properties that would do instead");
      return *value;
    };
    camera.fx = length("focal_length") / length("pixel_width");
    camera.fy = length("focal_length") / length("pixel_height");
    camera.cx = camera.width / 2.0;
    camera.cy = camera.height / 2.0;
    scene_.warnings.push_back("the sensor " + quote(sensor.attribute("label").as_string()) +
                              " has no calibration: its focal length of " + general_text(length("focal_length")) +
                              " mm is taken, and no distortion");
    return camera;
  }

  int side_of(const pugi::xml_node& sensor, const pugi::xml_node& resolution, const char* name) const {
    const auto value = integer_from<std::int64_t>(resolution.attribute(name).as_string());
    if (!value || !image_side(static_cast<double>(*value)))
      xml_.fail(resolution ? resolution : sensor,
                std::string("expected a resolution with a ") + name + " of 1 to 2^24 pixels");
    return static_cast<int>(*value);
  }

  void read_reference(const pugi::xml_node& chunk) {
    const std::string_view reference = XmlFile::text(chunk, "reference");
    if (!referenced_ || reference.empty() || reference.starts_with("LOCAL_CS")) return;
    scene_.srs = kGeocentric;
    scene_.reference = reference;
    // Scripts export meshes in the chunk's own coordinates, unless they name others.
    SceneFrame own{"the chunk's own coordinates", transposed(of_views_.rotation), of_views_.translation,
                   1 / of_views_.scale};
    SceneFrame metric = own;
    metric.name = "the chunk's own coordinates in metres";
    metric.scale = 1;
    scene_.other_frames = {std::move(own), std::move(metric)};
  }

  XmlFile xml_;
  SceneFile scene_;
  std::map<std::string, pugi::xml_node> sensors_;
  std::map<std::string, Camera> cameras_;
  std::map<std::string, Placement> of_component_;
  Placement of_chunk_;
  Placement of_views_;  ///< of the component whose cameras are read
  bool referenced_ = false;
};

bool is_metashape(const fs::path& file) {
  return xml_root(file) == "document" && first_bytes(file, 1u << 14).find("<chunk") != std::string::npos;
}

}  // namespace

extern const SceneFormat kMetashape{
    "Metashape",
    "an Agisoft Metashape cameras.xml (or a folder with one)",
    [](const fs::path& source) { return find_file(source, ".xml", is_metashape); },
    [](const fs::path& file, std::string_view text) { return MetashapeReader(file, text).read(); },
    {"images", "photos", "../images"}};

}  // namespace gpvc::io
