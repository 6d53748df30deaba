// Scenes for other programs. Each format's conventions are stated where it is read: colmap_scene.cpp, cam_scene.cpp,
// openmvs_scene.cpp, nvm_scene.cpp; for JSON see json_scene_writer.cpp.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <set>
#include <utility>

#include "io/lens_terms.h"
#include "io/number_text.h"
#include "io/output_file.h"
#include "io/scenes/scene_file.h"
#include "io/scenes/scene_writer.h"

namespace gpvc::io {
namespace {

std::string joined(std::initializer_list<double> values) {
  std::string text;
  for (const double value : values) {
    if (!text.empty()) text += ' ';
    text += general_text(value);
  }
  return text;
}

// --- what a lens has, and what a format can state

constexpr Named<LensModel> kProjectionNames[] = {{"the perspective projection", LensModel::brown},
                                                 {"the perspective projection", LensModel::perspective},
                                                 {"the equidistant (fisheye) projection", LensModel::equidistant},
                                                 {"the equidistant (fisheye) projection", LensModel::fisheye_624},
                                                 {"the equisolid (fisheye) projection", LensModel::equisolid},
                                                 {"the polynomial (fisheye) projection", LensModel::fisheye_polynomial},
                                                 {"the field-of-view projection", LensModel::fov},
                                                 {"the inverse radial projection", LensModel::inverse_radial},
                                                 {"the division projection", LensModel::division},
                                                 {"the unified projection", LensModel::unified},
                                                 {"a panorama's projection", LensModel::spherical},
                                                 {"a panorama's projection", LensModel::spherical_up},
                                                 {"a panorama's projection", LensModel::spherical_down}};

/// The first of COLMAP's models that states the whole lens, or else the one of its projection with the most terms;
/// nullptr when no model has its projection.
const ColmapModel* colmap_model(const Distortion& d) {
  const LensModel lens = is_perspective(d.model) ? LensModel::perspective : d.model;
  const ColmapModel* most = nullptr;
  for (const ColmapModel& model : kColmapModels) {
    if (model.focal_lengths < 2 || model.lens != lens) continue;
    if (!first_term_beyond(d, model.terms())) return &model;
    if (most == nullptr || model.terms().size() > most->terms().size()) most = &model;
  }
  return most;
}

std::optional<std::string> lost_in_colmap(const Camera& c) {
  const Distortion& d = c.distortion;
  const ColmapModel* model = colmap_model(d);
  return model != nullptr ? first_term_beyond(d, model->terms()) : projection_name(d.model);
}

std::optional<std::string> lost_in_pinhole(const Camera& c) {
  const Distortion& d = c.distortion;
  return is_perspective(d.model) ? first_term_beyond(d, {}) : projection_name(d.model);
}

/// The format has radial terms alone, about the photo's middle, with square pixels; k1 without k2 selects another model.
std::optional<std::string> lost_in_cam(const Camera& c) {
  const Distortion& d = c.distortion;
  if (!lost_in_pinhole(c)) return std::nullopt;
  if (d.model != LensModel::inverse_radial) {
    if (!is_perspective(d.model)) return projection_name(d.model);
    if ((d.k1 != 0) != (d.k2 != 0)) return d.k1 != 0 ? "k1 without k2" : "k2 without k1";
  }
  if (auto more = first_term_beyond(d, std::array{&Distortion::k1, &Distortion::k2})) return more;
  if (c.fx != c.fy) return "fx apart from fy, with distortion";
  if (2 * c.cx != c.width || 2 * c.cy != c.height) return "a principal point off the middle, with distortion";
  return std::nullopt;
}

/// Square pixels around the photo's middle, and one radial term from the photo to the frame. A header with FixedK, which
/// could state more, is honoured by few programs.
std::optional<std::string> lost_in_nvm(const Camera& c) {
  const Distortion& d = c.distortion;
  if (d.model == LensModel::inverse_radial) {
    if (auto more = first_term_beyond(d, std::array{&Distortion::k1})) return more;
  } else if (auto lost = lost_in_pinhole(c)) {
    return lost;
  }
  if (c.fx != c.fy) return "fx apart from fy";
  if (2 * c.cx != c.width || 2 * c.cy != c.height) return "a principal point off the middle";
  return std::nullopt;
}

/// Little-endian values one after the other.
class Bytes {
 public:
  explicit Bytes(std::string begin = "") : bytes_(std::move(begin)) {}

  template <class T>
  void add(T value) {
    const std::size_t at = bytes_.size();
    bytes_.resize(at + sizeof value);
    std::memcpy(bytes_.data() + at, &value, sizeof value);
  }
  /// With its length before it.
  void add_text(const std::string& text) {
    add<std::uint64_t>(text.size());
    bytes_ += text;
  }
  /// With a zero behind it.
  void add_name(const std::string& name) { bytes_.append(name).push_back('\0'); }
  void add_point(const WorldPoint& p) {
    for (const double v : {p.x, p.y, p.z}) add(v);
  }
  void add_matrix(const std::array<double, 9>& m) {
    for (const double v : m) add(v);
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

// --- COLMAP

/// A binary model: in text models COLMAP ends names at blanks.
void write_colmap(const PlacedScene& scene) {
  Bytes cameras, images, points;
  cameras.add<std::uint64_t>(scene.cameras.size());
  std::uint32_t number = 0;
  for (const Camera& c : scene.cameras) {
    const ColmapModel& model = *colmap_model(c.distortion);
    cameras.add(++number);
    cameras.add(static_cast<std::int32_t>(&model - kColmapModels.data()));
    cameras.add(static_cast<std::uint64_t>(c.width));
    cameras.add(static_cast<std::uint64_t>(c.height));
    for (const double value : {c.fx, c.fy, c.cx, c.cy}) cameras.add(value);
    for (const DistortionTerm term : model.terms()) cameras.add(c.distortion.*term);
  }
  images.add<std::uint64_t>(scene.views.size());
  number = 0;
  for (const auto& [view, place, camera] : scene.views) {
    images.add(++number);
    for (const double value : quaternion(view.pose.rotation)) images.add(value);
    images.add_point(translation(view.pose));
    images.add(camera + 1);
    images.add_name(place.lexically_relative("images").generic_string());
    images.add<std::uint64_t>(0);  // points seen
  }
  points.add<std::uint64_t>(0);
  write_file(scene.folder / "sparse" / "cameras.bin", cameras.bytes());
  write_file(scene.folder / "sparse" / "images.bin", images.bytes());
  write_file(scene.folder / "sparse" / "points3D.bin", points.bytes());
}

void write_cams(const PlacedScene& scene) {
  for (const auto& [view, place, camera] : scene.views) {
    const Camera& c = view.camera;
    const auto& r = view.pose.rotation;
    const WorldPoint t = translation(view.pose);
    const double aspect = c.fy / c.fx;
    const bool portrait = c.width * aspect < c.height;
    const double f = portrait ? c.fx * aspect / c.height : c.fx / c.width;
    const Distortion& d = c.distortion;
    write_file(scene.folder / fs::path(place).replace_extension(".cam"),
               joined({t.x, t.y, t.z, r[0], r[1], r[2], r[3], r[4], r[5], r[6], r[7], r[8]}) + "\n" +
                   joined({f, d.k1, d.k2, aspect, c.cx / c.width, c.cy / c.height}) + "\n");
  }
}

// --- OpenMVS

/// Version 4 of the interface: what every OpenMVS since 2.0 reads. One platform per camera.
void write_mvs(const PlacedScene& scene) {
  constexpr std::array<double, 9> kIdentity{1, 0, 0, 0, 1, 0, 0, 0, 1};
  std::vector<std::vector<Pose>> poses(scene.cameras.size());
  std::vector<std::uint32_t> pose_of_view;
  for (const PlacedView& placed : scene.views) {
    pose_of_view.push_back(static_cast<std::uint32_t>(poses[placed.camera].size()));
    poses[placed.camera].push_back(placed.view.pose);
  }

  Bytes archive("MVSI");
  archive.add<std::uint32_t>(4);
  archive.add<std::uint32_t>(0);
  archive.add<std::uint64_t>(scene.cameras.size());
  for (std::size_t p = 0; p < scene.cameras.size(); ++p) {
    const Camera& c = scene.cameras[p];
    archive.add_text("platform" + std::to_string(p));
    archive.add<std::uint64_t>(1);
    archive.add_text("camera");
    archive.add_text("");  // band
    archive.add(static_cast<std::uint32_t>(c.width));
    archive.add(static_cast<std::uint32_t>(c.height));
    archive.add_matrix({c.fx, 0, c.cx - 0.5, 0, c.fy, c.cy - 0.5, 0, 0, 1});
    archive.add_matrix(kIdentity);
    archive.add_point({});
    archive.add<std::uint64_t>(poses[p].size());
    for (const Pose& pose : poses[p]) {
      archive.add_matrix(pose.rotation);
      archive.add_point(pose.centre);
    }
  }
  archive.add<std::uint64_t>(scene.views.size());
  for (std::size_t i = 0; i < scene.views.size(); ++i) {
    archive.add_text(scene.views[i].place.generic_string());
    archive.add(scene.views[i].camera);
    archive.add<std::uint32_t>(0);
    archive.add(pose_of_view[i]);
    archive.add(static_cast<std::uint32_t>(i));
  }
  // Vertices, their normals and colours; lines, their normals and colours: none.
  for (int list = 0; list < 6; ++list) archive.add<std::uint64_t>(0);
  for (const double v : {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}) archive.add(v);
  write_file(scene.folder / "scene.mvs", archive.bytes());
}

// --- NVM

/// NVM ends names at blanks, for which it has '"'; so it cannot state that character itself, nor the end of a line. Our
/// reader takes '\\' for the separator of folders.
void refuse_name_beyond_nvm(const std::string& name) {
  const bool stated =
      std::ranges::none_of(name, [](char c) { return c == '"' || c == '\\' || (static_cast<unsigned char>(c) < ' '); });
  if (!stated)
    throw OutputError(name, "NVM cannot state a photo's name with a quote, a backslash or a control character");
}

/// One model without points; the 0 behind it, a model without cameras, ends the file.
void write_nvm(const PlacedScene& scene) {
  std::string text = "NVM_V3\n\n" + std::to_string(scene.views.size()) + "\n";
  for (const auto& [view, place, camera] : scene.views) {
    std::string name = place.generic_string();
    std::ranges::replace(name, ' ', '"');
    const auto q = quaternion(view.pose.rotation);
    const WorldPoint& c = view.pose.centre;
    text += name + '\t' +
            joined({view.camera.fx, q[0], q[1], q[2], q[3], c.x, c.y, c.z, view.camera.distortion.k1, 0}) + '\n';
  }
  write_file(scene.folder / "scene.nvm", text + "\n0\n\n0\n");
}

// --- where masks lie

fs::path mask_by_stem(const fs::path& photo) { return fs::path(photo).replace_extension(".mask.png"); }
fs::path mask_by_name(const fs::path& photo) { return fs::path(photo.string() + ".mask.png"); }

}  // namespace

// --- parts of all writers

WorldPoint translation(const Pose& pose) {
  const WorldPoint c = product(pose.rotation, pose.centre);
  return {-c.x, -c.y, -c.z};
}

std::optional<std::string> first_term_beyond(const Distortion& d, std::span<const DistortionTerm> stated) {
  for (const LensTerm& term : kLensTerms)
    if (d.*term.term != 0 && std::find(stated.begin(), stated.end(), term.term) == stated.end()) return term.name;
  return std::nullopt;
}

std::string projection_name(LensModel model) { return std::string(name_of(kProjectionNames, model)); }

fs::path mask_in_folder(const fs::path& photo) {
  return fs::path("masks") / (photo.lexically_relative("images").string() + ".png");
}

// --- scenes

const SceneWriter& scene_writer(SceneTarget target) {
  using enum SceneTarget;
  static const SceneWriter kWriters[] = {
      {colmap,
       {"sparse/cameras.bin", "sparse/images.bin", "sparse/points3D.bin"},
       lost_in_colmap,
       mask_in_folder,
       write_colmap},
      {cam, {}, lost_in_cam, nullptr, write_cams, {.without_masks = "mvs-texturing has no masks: it"}},
      {mvs, {"scene.mvs"}, lost_in_pinhole, mask_by_stem, write_mvs},
      {transforms, {"transforms.json"}, lost_in_transforms, mask_in_folder, write_transforms},
      {opensfm, {"reconstruction.json"}, lost_in_opensfm, mask_in_folder, write_opensfm, {.states_enu = true}},
      {nvm,
       {"scene.nvm"},
       lost_in_nvm,
       mask_by_name,
       write_nvm,
       {.square_and_centred = true,
        .without_masks = "NVM has no masks: programs other than gpvc",
        .refuse_name = refuse_name_beyond_nvm}}};
  return *std::ranges::find(kWriters, target, &SceneWriter::target);
}

std::optional<std::string> lost_term(SceneTarget target, const Camera& camera) {
  if (camera.distortion.motion.moves()) return "a movement while the photo was read out (rolling shutter)";
  if (camera.distortion.looks_aside()) return "a view that looks another way than the lens";
  return scene_writer(target).lost_term(camera);
}

std::vector<fs::path> photo_places(SceneTarget target, const Scene& scene, std::span<const ViewId> used) {
  const SceneWriter& writer = scene_writer(target);
  const bool flat = writer.files.empty();
  std::vector<fs::path> places;
  std::set<fs::path> taken;
  for (const ViewId id : used) {
    std::string name = fs::path(scene.views[index(id)].name).lexically_normal().generic_string();
    if (writer.more.refuse_name != nullptr) writer.more.refuse_name(name);
    if (flat) std::ranges::replace(name, '/', '_');
    places.push_back(flat ? fs::path(name) : fs::path("images") / name);
    const fs::path key = flat ? fs::path(name).replace_extension(".cam") : places.back();
    if (!taken.insert(key).second)
      throw OutputError(
          key, std::string("two photos would need this name") + (flat ? " in a folder without sub-folders" : ""));
  }
  return places;
}

void write_scene(SceneTarget target, const Scene& scene, std::span<const ViewId> used, std::span<const fs::path> places,
                 const fs::path& folder) {
  PlacedScene placed{scene, folder};
  for (std::size_t i = 0; i < used.size(); ++i) {
    const View& view = scene.views[index(used[i])];
    if (const auto lost = lost_term(target, view.camera))
      throw OutputError(folder, "the format cannot state " + *lost + " of the camera of " + view.name);
    const auto known = std::ranges::find(placed.cameras, view.camera);
    placed.views.push_back({view, places[i], static_cast<std::uint32_t>(known - placed.cameras.begin())});
    if (known == placed.cameras.end()) placed.cameras.push_back(view.camera);
  }
  scene_writer(target).write(placed);
}

std::vector<fs::path> listing_files(SceneTarget target, std::span<const fs::path> places) {
  const SceneWriter& writer = scene_writer(target);
  if (!writer.files.empty()) return writer.files;
  std::vector<fs::path> files(places.begin(), places.end());
  for (fs::path& file : files) file.replace_extension(".cam");
  return files;
}

}  // namespace gpvc::io
