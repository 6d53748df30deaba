// MicMac's orientations: a folder Ori-NAME with Orientation-PHOTO.xml for each photo and AutoCal*.xml for each camera, as
// Tapas, Campari and GCPBascule write them. OpenMVG's converter (main_openMVG2MICMAC), MicMac's from Bundler
// (CPP_Bundler2MM_main) and iTowns' reader (MicmacParser) of github.com agree on what follows.
//
// Pixels   the centre of the upper left pixel is (0, 0), x right, y down, as MicMac interpolates photos at whole numbers:
//          the principal point moves by half a pixel.
// Camera   x right, y down, z forward: ours.
// Pose     Centre is the camera's centre, L1 to L3 are the rows of the matrix that takes camera to world axes.
// Lens     PP and F in pixels. With q the ideal point PP + F (X / Z, Y / Z) less CDist, the photo shows
//          CDist + q (1 + R1 q^2 + R2 q^4 + ..) + (P1 (q^2 + 2 qx^2) + 2 P2 qx qy + b1 qx + b2 qy,
//          P2 (q^2 + 2 qy^2) + 2 P1 qx qy), all in pixels (ModRad and ModPhgrStd under eConvApero_DistM2C).
//          For a centre of distortion beside the principal point (RadialStd, RadialExtended, Fraser) the terms about the
//          latter that come closest are taken: see recentred(). Fisheyes (ModUnif) state their centre and focal length
//          anew, beside PP and F.
#include "io/scenes/micmac_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <tuple>
#include <vector>

#include "io/file_bytes.h"
#include "io/files/text_scan.h"
#include "io/number_text.h"
#include "io/scenes/xml_file.h"

namespace gpvc::io {

namespace {

constexpr std::string_view kPrefix = "Orientation-", kSuffix = ".xml";
constexpr std::string_view kConvention = "eConvApero_DistM2C";
constexpr double kHalf = 0.5;  ///< from the file's pixels to ours

/// Distortion as the file states it, in pixels about its own centre.
struct PixelDistortion {
  PixelPoint centre;
  std::vector<double> radial;  ///< of q^2, q^4, ..
  double p1 = 0, p2 = 0, b1 = 0, b2 = 0;

  /// Where the photo shows an ideal point.
  PixelPoint shown(const PixelPoint& ideal) const {
    const double x = ideal.x - centre.x, y = ideal.y - centre.y, r2 = x * x + y * y;
    double factor = 0;
    for (std::size_t i = radial.size(); i > 0; --i) factor = r2 * (radial[i - 1] + factor);
    return {ideal.x + x * factor + p1 * (r2 + 2 * x * x) + 2 * p2 * x * y + b1 * x + b2 * y,
            ideal.y + y * factor + p2 * (r2 + 2 * y * y) + 2 * p1 * x * y};
  }
};

/// Terms that act linearly once `p3` and `p4` are given.
constexpr std::array<double Distortion::*, 13> kFitted{
    &Distortion::k1, &Distortion::k2, &Distortion::k3,  &Distortion::k4, &Distortion::k5,
    &Distortion::k6, &Distortion::p1, &Distortion::p2,  &Distortion::s1, &Distortion::s2,
    &Distortion::s3, &Distortion::s4, &Distortion::skew};
using Row = std::array<double, kFitted.size() + 1>;  ///< what each adds to a coordinate, and what they are to add up to

/// The solution of linear equations, by Gauss' elimination with pivots. Not finite where there is none.
std::array<double, kFitted.size()> solved(std::array<Row, kFitted.size()> m) {
  constexpr std::size_t n = kFitted.size();
  for (std::size_t i = 0; i < n; ++i) {
    std::size_t pivot = i;
    for (std::size_t r = i + 1; r < n; ++r)
      if (std::abs(m[r][i]) > std::abs(m[pivot][i])) pivot = r;
    std::swap(m[i], m[pivot]);
    for (std::size_t r = 0; r < n; ++r) {
      if (r == i) continue;
      const double factor = m[r][i] / m[i][i];
      for (std::size_t c = i; c <= n; ++c) m[r][c] -= factor * m[i][c];
    }
  }
  std::array<double, n> x{};
  for (std::size_t i = 0; i < n; ++i) x[i] = m[i][n] / m[i][i];
  return x;
}

/// Calls `use` with ideal points of the photo, in the file's pixels.
template <class Use>
void for_each_ideal(const Camera& camera, const Use& use) {
  constexpr int kSteps = 32;
  for (int j = 0; j <= kSteps; ++j)
    for (int i = 0; i <= kSteps; ++i)
      use(PixelPoint{double(i) * camera.width / kSteps - kHalf, double(j) * camera.height / kSteps - kHalf});
}

/// Sets the terms of kFitted to those by which the photo comes closest, in the mean of squares, to what the file states.
void fit_terms(const PixelDistortion& stated, Camera& camera) {
  Distortion& d = camera.distortion;
  const double ppx = camera.cx - kHalf, ppy = camera.cy - kHalf;
  std::array<Row, kFitted.size()> equations{};
  for_each_ideal(camera, [&](const PixelPoint& ideal) {
    const double x = (ideal.x - ppx) / camera.fy, y = (ideal.y - ppy) / camera.fy, r2 = x * x + y * y;
    const double more = 1 + r2 * (d.p3 + r2 * d.p4);
    const PixelPoint shown = stated.shown(ideal);
    const double to_x = (shown.x - ppx) / camera.fx, to_y = (shown.y - ppy) / camera.fy;
    Row across{}, down{};
    double power = 1;
    for (std::size_t k = 0; k < 6; ++k) {
      power *= r2;
      across[k] = x * power;
      down[k] = y * power;
    }
    const double cross = 2 * x * y * more;
    std::ranges::copy(std::array{cross, (r2 + 2 * x * x) * more, r2, 0.0, r2 * r2, 0.0, to_y, to_x - x}, &across[6]);
    std::ranges::copy(std::array{(r2 + 2 * y * y) * more, cross, 0.0, r2, 0.0, r2 * r2, 0.0, to_y - y}, &down[6]);
    for (const Row& row : {across, down})
      for (std::size_t i = 0; i < kFitted.size(); ++i)
        for (std::size_t k = 0; k < row.size(); ++k) equations[i][k] += row[i] * row[k];
  });
  const std::array<double, kFitted.size()> terms = solved(equations);
  for (std::size_t i = 0; i < kFitted.size(); ++i) d.*kFitted[i] = terms[i];
}

/// How far `camera` shows points of the photo from where the file's terms do, at most, in pixels.
double largest_error(const Camera& camera, const PixelDistortion& stated) {
  double worst = 0;
  for_each_ideal(camera, [&](const PixelPoint& ideal) {
    // The frame is stretched by b1, the file's ideal points are not.
    const PixelPoint frame{camera.cx + (ideal.x + kHalf - camera.cx) * camera.fx / camera.fy, ideal.y + kHalf};
    const PixelPoint expected = stated.shown(ideal);
    if (const auto found = photo_from_pixel(camera, frame))
      worst = std::max(worst, std::hypot(found->x - kHalf - expected.x, found->y - kHalf - expected.y));
  });
  return worst;
}

/// The camera whose terms come closest to distortion about another point than the principal point. To first order in the
/// distance, what that adds is tangential, times 1 + 2 k2 / k1 r2 + 3 k3 / k1 r2^2, or without that factor, where other
/// tangential terms prevail. \pre camera has the terms as if the centre were the principal point
Camera recentred(const PixelDistortion& stated, Camera camera) {
  const Distortion& d = camera.distortion;
  Camera best = camera;
  double least = std::numeric_limits<double>::infinity();
  for (const double share : {d.k1 == 0 ? 0.0 : 1.0, 0.0}) {
    Camera fitted = camera;
    if (share > 0) {
      fitted.distortion.p3 = 2 * d.k2 / d.k1;
      fitted.distortion.p4 = 3 * d.k3 / d.k1;
    }
    fit_terms(stated, fitted);
    limit_distortion(fitted);
    const double error = largest_error(fitted, stated);
    if (!(error < least)) continue;
    least = error;
    best = fitted;
  }
  return best;
}

/// The numbers of a child. Throws where there is none.
std::vector<double> needed_numbers(const XmlFile& xml, const pugi::xml_node& parent, const char* child,
                                   std::size_t count) {
  const pugi::xml_node node = parent.child(child);
  if (!node) xml.fail(parent, std::string(parent.name()) + " has no " + child);
  return xml.numbers(node, count);
}

void expect_convention(const XmlFile& xml, const pugi::xml_node& parent) {
  const std::string_view stated = XmlFile::text(parent, "KnownConv");
  if (!stated.empty() && stated != kConvention)
    xml.fail(parent.child("KnownConv"),
             "the convention " + quote(stated) + " is not read, " + std::string(kConvention) + " is");
}

/// A camera, or why it is left out.
struct MicmacCamera {
  Camera camera;
  std::string lens;
  std::optional<InputError> refusal;
  double error = 0;  ///< of the lens, in pixels
};

constexpr const char* kWayOut = "; undistort the photos by 'mm3d Drunk', which writes their orientations as well";

/// The member of CalibDistortion that says something; null where none does.
pugi::xml_node distortion_of(const XmlFile& xml, const pugi::xml_node& in) {
  pugi::xml_node found;
  for (const pugi::xml_node calibration : in.children("CalibDistortion"))
    for (const pugi::xml_node model : calibration.children()) {
      if (std::string_view(model.name()) == "ModNoDist") continue;
      if (found) xml.fail(model, std::string("distortion upon distortion is not read") + kWayOut);
      found = model;
    }
  return found;
}

PixelDistortion stated_distortion(const XmlFile& xml, const pugi::xml_node& model) {
  PixelDistortion d;
  const pugi::xml_node radial = std::string_view(model.name()) == "ModPhgrStd" ? model.child("RadialePart") : model;
  const std::vector<double> centre = needed_numbers(xml, radial, "CDist", 2);
  d.centre = {centre[0], centre[1]};
  for (const pugi::xml_node term : radial.children("CoeffDist"))
    if (!trimmed(term.child_value()).empty()) d.radial.push_back(xml.numbers(term, 1)[0]);
  d.p1 = xml.number(model, "P1").value_or(0);
  d.p2 = xml.number(model, "P2").value_or(0);
  d.b1 = xml.number(model, "b1").value_or(0);
  d.b2 = xml.number(model, "b2").value_or(0);
  return d;
}

/// The camera without its distortion. Its focal lengths are equal.
Camera undistorted_camera(const XmlFile& xml, const pugi::xml_node& in) {
  const std::vector<double> pp = needed_numbers(xml, in, "PP", 2), size = needed_numbers(xml, in, "SzIm", 2);
  const auto width = image_side(size[0]), height = image_side(size[1]);
  if (!width || !height) xml.fail(in.child("SzIm"), "expected two whole numbers of 1 to 2^24 pixels");
  const double f = needed_numbers(xml, in, "F", 1)[0];
  return {*width, *height, f, f, pp[0] + kHalf, pp[1] + kHalf, {}};
}

/// The camera with the distortion that the file states, or the one that comes closest. \pre it has none
Camera distorted(const PixelDistortion& stated, Camera camera) {
  constexpr double Distortion::*kRadial[] = {&Distortion::k1, &Distortion::k2, &Distortion::k3,
                                             &Distortion::k4, &Distortion::k5, &Distortion::k6};
  const double f = camera.fx;
  Distortion& d = camera.distortion;
  d.model = LensModel::perspective;
  double power = 1;
  for (std::size_t i = 0; i < std::min(stated.radial.size(), std::size(kRadial)); ++i)
    d.*kRadial[i] = stated.radial[i] * (power *= f * f);
  d.p1 = stated.p2 * f;
  d.p2 = stated.p1 * f;
  camera.fx = f * (1 + stated.b1);
  d.skew = stated.b2 / (1 + stated.b1);
  // Without an affine part and about the principal point, the terms are ours.
  const bool centred = stated.centre.x + kHalf == camera.cx && stated.centre.y + kHalf == camera.cy;
  return centred && stated.b1 == 0 && stated.b2 == 0 ? camera : recentred(stated, camera);
}

/// Why distortion of this kind is not read; empty: it is.
std::string unread_kind(const pugi::xml_node& model, MicmacCamera& result) {
  result.lens = model.name();
  if (result.lens == "ModRad" || result.lens == "ModPhgrStd") return {};
  const std::string_view type = XmlFile::text(model, "TypeModele");
  if (!type.empty()) result.lens = type;
  return "distortion of the kind " + quote(result.lens) + " is not read, ModRad and ModPhgrStd are";
}

MicmacCamera camera_from(const XmlFile& xml, const pugi::xml_node& in) {
  expect_convention(xml, in);
  MicmacCamera result;
  result.camera = undistorted_camera(xml, in);
  const pugi::xml_node model = distortion_of(xml, in);
  const auto refuse = [&](const std::string& why) {
    result.refusal = InputError(xml.path(), xml.place(model), why + kWayOut);
    return result;
  };
  if (!model) {
    finish_camera(xml.path(), xml.place(in), result.camera);
    return result;
  }
  if (const std::string unread = unread_kind(model, result); !unread.empty()) return refuse(unread);
  const PixelDistortion stated = stated_distortion(xml, model);
  result.camera = distorted(stated, result.camera);
  finish_camera(xml.path(), xml.place(in), result.camera);
  result.error = largest_error(result.camera, stated);
  constexpr double kMost = 0.5;  // px
  if (result.error <= kMost) return result;
  return refuse("the centre of distortion lies so far from the principal point that the terms of " +
                std::string(model.name()) + " cannot be stated about the latter: the error would be " +
                general_text(std::round(100 * result.error) / 100) + " pixels");
}

/// Reads orientations one after another.
class MicmacReader {
 public:
  using Calibration = std::function<MicmacCamera(const std::string& stated)>;

  void add(const fs::path& file, std::string_view text, const Calibration& calibration) {
    const XmlFile xml(file, text);
    const pugi::xml_node in = xml.root("ExportAPERO").child("OrientationConique");
    if (!in) xml.fail(xml.root("ExportAPERO"), "holds no OrientationConique");
    expect_plain(xml, in);
    const pugi::xml_node inner = in.child("Interne");
    const std::string stated = inner ? "" : with_slashes(XmlFile::text(in, "FileInterne"));
    if (!inner && stated.empty()) xml.fail(in, "states no camera: expected Interne or FileInterne");
    const MicmacCamera camera = inner ? camera_from(xml, inner) : calibration(stated);
    if (camera.refusal) {
      omitted_.add(camera.lens, *camera.refusal);
      return;
    }
    error_ = std::max(error_, camera.error);
    View view;
    const std::string name = file.filename().string();
    view.name = name.substr(kPrefix.size(), name.size() - kPrefix.size() - kSuffix.size());
    view.camera = camera.camera;
    view.pose = pose_from(xml, in.child("Externe"));
    scene_.views.push_back(std::move(view));
  }

  SceneFile finish() {
    omitted_.report(scene_);
    constexpr double kNoticed = 0.02;  // px
    if (error_ > kNoticed)
      scene_.warnings.push_back(
          "the lens is distorted about another point than its principal point, which is modelled to " +
          general_text(std::round(100 * error_) / 100) + " pixels");
    return std::move(scene_);
  }

 private:
  /// Scanned photos have an orientation of their own on the film.
  static void expect_plain(const XmlFile& xml, const pugi::xml_node& in) {
    const std::string_view type = XmlFile::text(in, "TypeProj");
    if (!type.empty() && type != "eProjStenope")
      xml.fail(in.child("TypeProj"), "a projection of the type " + quote(type) + " is not read");
    expect_convention(xml, in.child("ConvOri"));
    const pugi::xml_node inner = in.child("OrIntImaM2C");
    if (!inner) return;
    for (const auto& [name, x, y] : {std::tuple("I00", 0.0, 0.0), {"V10", 1.0, 0.0}, {"V01", 0.0, 1.0}})
      if (needed_numbers(xml, inner, name, 2) != std::vector{x, y})
        xml.fail(inner, std::string("an affine map from camera to image is not read: resample the photos by 'mm3d "
                                    "ReSampFid'"));
  }

  static Pose pose_from(const XmlFile& xml, const pugi::xml_node& in) {
    expect_convention(xml, in);
    const std::vector<double> c = needed_numbers(xml, in, "Centre", 3);
    const pugi::xml_node coded = in.child("ParamRotation").child("CodageMatr");
    if (!coded) xml.fail(in, "expected a rotation as CodageMatr; angles are not read");
    Matrix3 world_from_camera{};
    std::size_t at = 0;
    for (const char* row : {"L1", "L2", "L3"})
      for (const double value : needed_numbers(xml, coded, row, 3)) world_from_camera[at++] = value;
    const auto rotation = rotation_near(transposed(world_from_camera));
    if (!rotation) xml.fail(coded, "L1, L2 and L3 are no rotation");
    return finish_pose(xml.path(), xml.place(in), *rotation, {c[0], c[1], c[2]});
  }

  SceneFile scene_;
  OmittedLenses omitted_;
  double error_ = 0;
};

MicmacCamera read_calibration(const fs::path& file, std::string_view text) {
  const XmlFile xml(file, text);
  const pugi::xml_node root = xml.root("ExportAPERO"), in = root.child("CalibrationInternConique");
  if (!in) xml.fail(root, "holds no CalibrationInternConique");
  return camera_from(xml, in);
}

std::vector<fs::path> orientations_in(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with(kPrefix) && name.ends_with(kSuffix) && name.size() > kPrefix.size() + kSuffix.size() &&
        is_file(entry.path()))
      files.push_back(entry.path());
  }
  std::ranges::sort(files);
  return files;
}

/// A folder with orientations, or a project's that has one such.
std::optional<fs::path> find_micmac(const fs::path& source) {
  if (!is_folder(source)) return std::nullopt;
  if (!orientations_in(source).empty()) return source;
  std::vector<fs::path> found;
  for (const auto& entry : fs::directory_iterator(source))
    if (entry.path().filename().string().starts_with("Ori-") && !orientations_in(entry.path()).empty())
      found.push_back(entry.path());
  if (found.empty()) return std::nullopt;
  std::ranges::sort(found);
  if (found.size() > 1)
    throw InputError(source, "",
                     "holds " + std::to_string(found.size()) + " of MicMac's orientations, among them " +
                         found[0].filename().string() + " and " + found[1].filename().string() +
                         "; name the one that is meant");
  return found.front();
}

SceneFile read_micmac(const fs::path& folder) {
  std::map<std::string, MicmacCamera> cameras;
  std::vector<fs::path> files = orientations_in(folder);
  const auto calibration = [&](const std::string& stated) {
    const auto [camera, fresh] = cameras.try_emplace(stated);
    if (!fresh) return camera->second;
    // Paths start at the project's folder. Folders that were moved or renamed keep the file's name.
    const fs::path here = folder / fs::path(stated).filename(), there = folder / ".." / stated;
    const fs::path& file = is_file(here) ? here : there;
    if (!is_file(file)) throw InputError(folder, "", "the camera " + quote(stated) + " of its photos is not in it");
    const FileBytes bytes(file);
    files.push_back(file);
    return camera->second = read_calibration(file, bytes.view());
  };
  MicmacReader reader;
  for (const fs::path& file : std::vector<fs::path>(files)) {
    const FileBytes bytes(file);
    reader.add(file, bytes.view(), calibration);
  }
  SceneFile scene = reader.finish();
  scene.listing = files.front();
  scene.files = files;
  scene.image_folders = {folder / "..", folder};
  return scene;
}

}  // namespace

SceneFile parse_micmac(const fs::path& orientation, std::string_view orientation_text, const fs::path& camera,
                       std::string_view camera_text) {
  MicmacReader reader;
  reader.add(orientation, orientation_text, [&](const std::string&) { return read_calibration(camera, camera_text); });
  return reader.finish();
}

extern const SceneFormat kMicmac{
    "MicMac",    "MicMac's orientations (a folder Ori-NAME with Orientation-PHOTO.xml, or a folder with one)",
    find_micmac, nullptr,
    {},          read_micmac};

}  // namespace gpvc::io
