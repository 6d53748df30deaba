// RealityCapture's (RealityScan's) metadata files, NAME.xmp beside each photo: "RealityScan XMP Files" of the document
// that reality_camera.h names, which also states pixels and lens.
//
//   <x:xmpmeta><rdf:RDF><rdf:Description xcr:FocalLength35mm="24" xcr:PrincipalPointU="0" xcr:DistortionModel="brown3">
//     <xcr:Rotation>R11 .. R33</xcr:Rotation> <xcr:Position>X Y Z</xcr:Position>
//     <xcr:DistortionCoeficients>k1 k2 k3 k4 t1 t2</xcr:DistortionCoeficients>      (spelled so)
//
// Values   attributes of rdf:Description or elements in it: versions differ. Other programs write .xmp files beside
//          photos too; those without xcr:Rotation and xcr:Position are passed over.
// Camera   x right, y down, z forward: ours. Rotation takes world to camera, row by row; Position is the centre.
// World    that of the program's "Same as XMP" or, georeferenced, of its output coordinates: z up. Poses that are not
//          absolute belong to the component that ComponentId names, and components have nothing to do with each other.
// Lens     Coefficients that a model lacks are 0. Skew and AspectRatio, of the models with K, are refused: no source
//          for what they multiply.
#include <algorithm>
#include <cmath>
#include <map>

#include "io/file_bytes.h"
#include "io/files/text_scan.h"
#include "io/scenes/reality_camera.h"
#include "io/scenes/scene_file.h"
#include "io/scenes/xml_file.h"

namespace gpvc::io {

namespace {

constexpr std::string_view kRealityNamespace = "http://www.capturingreality.com/ns/xcr/";

bool is_xmp(const fs::path& file) { return lower_case(file.extension().string()) == ".xmp"; }

bool states_reality_pose(std::string_view text) {
  return text.find("xcr:Rotation") != std::string_view::npos && text.find("xcr:Position") != std::string_view::npos;
}

bool is_reality_xmp(const fs::path& file) {
  constexpr std::size_t kMost = 1u << 18;  // many times what the program writes
  return is_xmp(file) && states_reality_pose(first_bytes(file, kMost));
}

/// What one file says.
struct RealityPhoto {
  View view;
  std::string component;  ///< empty: absolute coordinates
  bool in_texturing = true;
  std::string lens;  ///< of a camera that is not supported
  std::optional<InputError> refusal;
};

class RealityXmpReader {
 public:
  RealityXmpReader(const fs::path& file, std::string_view text) : xml_(file, text), root_(xml_.root("x:xmpmeta")) {}

  RealityPhoto read() {
    RealityPhoto photo;
    const std::vector<double> rotation = numbers("xcr:Rotation", 9);
    const std::vector<double> position = numbers("xcr:Position", 3);
    Matrix3 matrix{};
    std::copy(rotation.begin(), rotation.end(), matrix.begin());
    const std::optional<Matrix3> near = rotation_near(matrix);
    if (!near) fail("the matrix xcr:Rotation is no rotation");
    photo.view.pose = finish_pose(xml_.path(), "", *near, {position[0], position[1], position[2]});
    if (const std::string_view coordinates = value("xcr:Coordinates"); coordinates != "absolute")
      photo.component = value("xcr:ComponentId");
    photo.in_texturing = value("xcr:InTexturing") != "0";
    refuse_lens(photo);
    if (!photo.refusal) photo.view.camera = camera();
    return photo;
  }

 private:
  [[noreturn]] void fail(const std::string& reason) const { throw InputError(xml_.path(), "", reason); }

  /// Of the attribute or the element; empty when there is none.
  std::string_view value(const char* name) const {
    for (const pugi::xml_node description : root_.child("rdf:RDF").children("rdf:Description")) {
      if (const pugi::xml_attribute attribute = description.attribute(name)) return trimmed(attribute.value());
      if (description.child(name)) return XmlFile::text(description, name);
    }
    return {};
  }

  std::vector<double> numbers(const char* name, std::size_t count) const {
    std::string_view text = value(name);
    std::vector<double> values;
    for (std::string_view word = next_word(text); !word.empty(); word = next_word(text)) {
      const std::optional<double> number = number_from(word);
      if (!number || !std::isfinite(*number))
        fail("expected a finite number in " + std::string(name) + ", found " + quote(word));
      values.push_back(*number);
    }
    if (values.size() != count)
      fail("expected " + std::to_string(count) + (count == 1 ? " number in " : " numbers in ") + name + ", found " +
           std::to_string(values.size()));
    return values;
  }

  double number(const char* name, double otherwise) const {
    return value(name).empty() ? otherwise : numbers(name, 1).front();
  }

  std::array<double, 6> coefficients() const {
    std::array<double, 6> six{};
    if (value("xcr:DistortionCoeficients").empty()) return six;
    const std::vector<double> values = numbers("xcr:DistortionCoeficients", 6);
    std::copy(values.begin(), values.end(), six.begin());
    return six;
  }

  /// "" and "none": no distortion, whatever the coefficients.
  bool has_lens() const {
    const std::string_view model = value("xcr:DistortionModel");
    return !model.empty() && model != "none" && model != "perspective";
  }

  void refuse_lens(RealityPhoto& photo) const {
    const auto refuse = [&](std::string_view lens, const std::string& reason) {
      photo.lens = lens;
      photo.refusal = InputError(xml_.path(), "", reason);
    };
    const std::string_view model = value("xcr:DistortionModel");
    static constexpr std::string_view kBrown[] = {"brown3", "brown4", "brown3t2", "brown4t2"};
    if (number("xcr:Skew", 0) != 0 || number("xcr:AspectRatio", 1) != 1)
      refuse("skew or aspect ratio",
             "xcr:Skew other than 0 and xcr:AspectRatio other than 1 are not supported; align with a distortion model "
             "without K");
    else if (!has_lens() || coefficients() == std::array<double, 6>{})
      return;
    else if (model == "division")
      refuse(model, kNoDivision);
    else if (std::find(std::begin(kBrown), std::end(kBrown), model) == std::end(kBrown))
      refuse(model, "the lens model " + quote(model) + " is not supported, Brown's models are");
  }

  Camera camera() const {
    RealityCamera reality;
    if (value("xcr:FocalLength35mm").empty())
      fail("has no xcr:FocalLength35mm; export the metadata with the calibration");
    reality.focal_35mm = number("xcr:FocalLength35mm", 0);
    reality.px = number("xcr:PrincipalPointU", 0);
    reality.py = number("xcr:PrincipalPointV", 0);
    if (has_lens()) reality.coefficients = coefficients();
    Camera camera = camera_from(reality);
    finish_camera(xml_.path(), "", camera);
    return camera;
  }

  XmlFile xml_;
  pugi::xml_node root_;
};

SceneFile parse_reality_xmp(const fs::path& file, std::string_view text) {
  if (!states_reality_pose(text)) throw InputError(file, "", "expected xcr:Rotation and xcr:Position");
  SceneFile scene;
  scene.listing = file;
  scene.size_camera = size_reality_camera;
  RealityPhoto photo = RealityXmpReader(file, text).read();
  if (photo.refusal) throw *photo.refusal;
  photo.view.name = file.stem().string();
  scene.views.push_back(std::move(photo.view));
  return scene;
}

std::optional<fs::path> find_reality_folder(const fs::path& source) { return find_folder(source, is_reality_xmp); }

/// Photos of the component with the most, the first by name of several; all are where no pose names a component.
void keep_largest_component(std::vector<RealityPhoto>& photos, SceneFile& scene) {
  std::map<std::string, std::size_t> sizes;
  for (const RealityPhoto& photo : photos) ++sizes[photo.component];
  if (sizes.size() < 2) return;
  const auto most =
      std::max_element(sizes.begin(), sizes.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  const std::string kept = most->first;
  scene.warn(photos.size() - most->second, "photos of other components are left out; " +
                                               (kept.empty() ? "those in absolute coordinates" : kept) + ", " +
                                               std::to_string(most->second) + " photos, are read");
  std::erase_if(photos, [&](const RealityPhoto& photo) { return photo.component != kept; });
}

SceneFile read_reality_folder(const fs::path& folder) {
  SceneFile scene;
  scene.listing = folder / "*.xmp";
  scene.size_camera = size_reality_camera;
  scene.image_folders = {folder};
  std::vector<RealityPhoto> photos;
  std::size_t unposed = 0;
  for (const Sidecar& sidecar : sidecars_in(folder, ".xmp")) {
    const FileBytes bytes(sidecar.file);
    if (!states_reality_pose(bytes.view())) {
      unposed += bytes.view().find(kRealityNamespace) != std::string_view::npos ? 1 : 0;
      continue;
    }
    photos.push_back(RealityXmpReader(sidecar.file, bytes.view()).read());
    photos.back().view.name = sidecar.photo;
    scene.files.push_back(sidecar.file);
  }
  keep_largest_component(photos, scene);
  const std::size_t all = photos.size();
  if (std::ranges::any_of(photos, &RealityPhoto::in_texturing))
    std::erase_if(photos, [](const RealityPhoto& photo) { return !photo.in_texturing; });
  scene.warn(all - photos.size(), "photos are left out: they are marked as not for texturing (xcr:InTexturing)");
  scene.warn(unposed, "photos without a pose are left out");
  OmittedLenses omitted;
  for (RealityPhoto& photo : photos)
    if (photo.refusal)
      omitted.add(photo.lens, *photo.refusal);
    else
      scene.views.push_back(std::move(photo.view));
  omitted.report(scene, "photos");
  return scene;
}

}  // namespace

extern const SceneFormat kRealityXmp{"RealityCapture",
                                     "a folder of photos with RealityCapture's .xmp files",
                                     find_reality_folder,
                                     parse_reality_xmp,
                                     {},
                                     read_reality_folder};

}  // namespace gpvc::io
