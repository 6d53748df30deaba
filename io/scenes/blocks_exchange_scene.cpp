// Bentley ContextCapture's (iTwin Capture Modeler's) BlocksExchange XML: "BlocksExchange XML/XMLZ format" and
// "Perspective camera model" of the ContextCapture User Guide, docs.bentley.com.
//
// Pixels   the centre of the upper left pixel is (0, 0), x right, y down: the principal point moves by half a pixel.
// Camera   axes as CameraOrientation names them (XRightYDown when it does not), z completes them to a right-handed
//          frame; only XRightYDown is ours, the others are turned into it.
// Pose     Rotation takes world to camera axes, as a matrix or as Omega, Phi, Kappa in degrees: (Rx(omega) Ry(phi)
//          Rz(kappa))^T. Center is the camera's centre.
// Lens     Brown's, on the normalized plane with y down whatever the orientation. P1 and P2 are in the other order
//          than OpenCV's ("in some other conventions, the roles are reversed", says the guide): x' = x (1 + K1 r2 +
//          K2 r4 + K3 r6) + P1 (r2 + 2 x x) + 2 P2 x y. The focal matrix is [f Skew; 0 AspectRatio f], so u = cx + f
//          x' + Skew y'. StOriJimmy/libBATools reads both the same.
//          Fisheye: a polynomial P0 .. P4 of the angle and a focal matrix, see set_fisheye(); the example of the guide
//          has 0, 1, 0, 0, 0.
// Mask     black pixels are ignored ("Photo properties" of the guide), as ours.
// XMLZ     "an extension of XML format adding file compression for convenience (zip)": a zip archive with the XML. The
//          guide names no member, so it is the one that is a BlocksExchange document.
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "io/file_bytes.h"
#include "io/files/text_scan.h"
#include "io/files/zip_file.h"
#include "io/lens_terms.h"
#include "io/scenes/scene_file.h"
#include "io/scenes/xml_file.h"

namespace gpvc::io {

namespace {

/// Takes the file's camera axes to x right, y down, z forward.
std::optional<Matrix3> ours_from_axes(std::string_view orientation) {
  struct Axes {
    std::string_view name;
    Matrix3 turn;
  };
  static constexpr std::array<Axes, 8> kAxes{{{"XRightYDown", {1, 0, 0, 0, 1, 0, 0, 0, 1}},
                                              {"XRightYUp", {1, 0, 0, 0, -1, 0, 0, 0, -1}},
                                              {"XLeftYDown", {-1, 0, 0, 0, 1, 0, 0, 0, -1}},
                                              {"XLeftYUp", {-1, 0, 0, 0, -1, 0, 0, 0, 1}},
                                              {"XDownYRight", {0, 1, 0, 1, 0, 0, 0, 0, -1}},
                                              {"XDownYLeft", {0, -1, 0, 1, 0, 0, 0, 0, 1}},
                                              {"XUpYRight", {0, 1, 0, -1, 0, 0, 0, 0, 1}},
                                              {"XUpYLeft", {0, -1, 0, -1, 0, 0, 0, 0, -1}}}};
  for (const Axes& axes : kAxes)
    if (orientation.empty() || axes.name == orientation) return axes.turn;
  return std::nullopt;
}

/// True if a definition (or a name that contains one) states degrees. The values cannot decide that: metres about a
/// local origin may be as small. EPSG codes are those that photos and surveys come in: no rule separates their numbers
/// from those of projected systems, and a complete table is beyond this program.
bool is_geographic(std::string_view definition) {
  static constexpr std::array kCodes{4326, 4979, 9057,        // WGS 84: of two and of three dimensions, G1762
                                     4322,                    // WGS 72
                                     4490, 4480, 4214, 4610,  // CGCS2000, Beijing 1954, Xian 1980
                                     4258, 4937, 4171, 4965, 9777, 9776,  // ETRS89, RGF93
                                     4230, 4277, 4275, 4284,              // ED50, OSGB36, NTF, Pulkovo 1942
                                     4269, 4152, 4759, 6318, 6319,        // NAD83: HARN, NSRS2007, 2011
                                     4617, 4955,                          // NAD83(CSRS)
                                     4267,                                // NAD27
                                     4283, 4939, 7844, 7843, 4167, 4959,  // GDA94, GDA2020, NZGD2000
                                     6668, 6667, 4612, 4947, 4737, 4927,  // JGD2011, JGD2000, Korea 2000
                                     4674, 4989, 4148};                   // SIRGAS 2000, Hartebeesthoek94
  const std::string text = lower_case(definition);
  const auto states = [&text](const char* word) { return text.find(word) != std::string::npos; };
  if (text == "wgs84" || text == "wgs 84" || states("crs84") || states("+proj=longlat") || states("+proj=latlong") ||
      states("+proj=latlon") || states("+proj=lonlat"))
    return true;
  // WKT: the bases of projected systems are geographic, and a geodetic system may be geocentric.
  if (states("geogcs[") || states("geogcrs[") || states("geographiccrs[") || states("geodcrs[") ||
      states("geodeticcrs["))
    return !states("projcs[") && !states("projcrs[") && !states("projectedcrs[") && !states("cartesian");
  if (const std::size_t at = text.find("epsg:"); at != std::string::npos) {
    std::string_view code = std::string_view(text).substr(at + 5);
    while (!code.empty() && (code.front() == ':' || is_blank(code.front()))) code.remove_prefix(1);
    const auto number = integer_from<int>(code.substr(0, code.find_first_not_of("0123456789")));
    return number && std::find(kCodes.begin(), kCodes.end(), *number) != kCodes.end();
  }
  return false;
}

class BlocksReader {
 public:
  BlocksReader(const fs::path& file, std::string_view text) : xml_(file, text) { scene_.listing = file; }

  SceneFile read() {
    const pugi::xml_node root = xml_.root("BlocksExchange");
    base_ = with_slashes(XmlFile::text(root, "BaseImagePath"));
    pugi::xml_node best;
    std::size_t most = 0, blocks = 0;
    for (const pugi::xml_node block : root.children("Block")) {
      ++blocks;
      const std::size_t posed = count_posed(block);
      if (posed > most) {
        best = block;
        most = posed;
      }
    }
    if (most == 0) xml_.fail(root, "no photo has a pose: export the block after its aerotriangulation");
    if (blocks > 1)
      scene_.warnings.push_back("the file holds " + std::to_string(blocks) + " blocks; '" +
                                std::string(XmlFile::text(best, "Name")) + "' is read, it has the most photos");
    read_srs(root, best);
    for (const pugi::xml_node group : best.child("Photogroups").children("Photogroup")) read_group(best, group);
    omitted_.report(scene_, "photos");
    scene_.warn(unposed_, "photos without a pose are left out");
    scene_.warn(aside_, "photos outside the main component are left out");
    return std::move(scene_);
  }

 private:
  static bool has_pose(const pugi::xml_node& photo) {
    const pugi::xml_node pose = photo.child("Pose");
    return pose.child("Rotation").first_child() && pose.child("Center").first_child();
  }

  static std::size_t count_posed(const pugi::xml_node& block) {
    std::size_t count = 0;
    for (const pugi::xml_node group : block.child("Photogroups").children("Photogroup"))
      for (const pugi::xml_node photo : group.children("Photo")) count += has_pose(photo) ? 1 : 0;
    return count;
  }

  void read_srs(const pugi::xml_node& root, const pugi::xml_node& block) {
    const std::string_view id = XmlFile::text(block, "SRSId");
    if (id.empty()) return;
    for (const pugi::xml_node srs : root.child("SpatialReferenceSystems").children("SRS"))
      if (XmlFile::text(srs, "Id") == id) {
        const std::string_view definition = XmlFile::text(srs, "Definition");
        scene_.srs = reference_system(definition.empty() ? XmlFile::text(srs, "Name") : definition);
        if (is_geographic(scene_.srs))
          xml_.fail(srs, "the positions are degrees of " + quote(scene_.srs) +
                             ", which no mesh is in; export the block in a projected or a local system");
        return;
      }
    xml_.fail(block.child("SRSId"), "SRS " + quote(id) + " is not defined in the file");
  }

  void read_group(const pugi::xml_node& block, const pugi::xml_node& group) {
    std::vector<pugi::xml_node> photos;
    for (const pugi::xml_node photo : group.children("Photo")) {
      const std::string_view component = XmlFile::text(photo, "Component");
      if (!has_pose(photo))
        ++unposed_;
      else if (!component.empty() && component != "1")
        ++aside_;
      else
        photos.push_back(photo);
    }
    if (photos.empty()) return;  // its camera need not be understood
    const std::string_view own = XmlFile::text(group, "SRSId");
    if (!own.empty() && own != XmlFile::text(block, "SRSId"))
      xml_.fail(group.child("SRSId"), "a photogroup in another SRS than its block's is not read");
    const auto turn = ours_from_axes(XmlFile::text(group, "CameraOrientation"));
    if (!turn)
      xml_.fail(group.child("CameraOrientation"), "expected a CameraOrientation like XRightYDown, found " +
                                                      quote(XmlFile::text(group, "CameraOrientation")));
    const std::string_view type = XmlFile::text(group, "CameraModelType");
    if (!type.empty() && type != "Perspective" && type != "Fisheye") {
      const InputError refusal(xml_.path(), xml_.place(group.child("CameraModelType")),
                               "camera model " + quote(type) +
                                   " is not supported, Perspective and Fisheye are; undistort the "
                                   "photos or leave the photogroup out");
      for (std::size_t i = 0; i < photos.size(); ++i) omitted_.add(std::string(type), refusal);
      return;
    }
    Matrix3 to_ours = *turn;
    const Camera camera = camera_of(group, to_ours);
    for (const pugi::xml_node& photo : photos) read_photo(photo, camera, to_ours);
  }

  /// `turn`, which takes the file's camera axes to ours, is changed to those of the camera that is returned.
  Camera camera_of(const pugi::xml_node& group, Matrix3& turn) const {
    Camera camera;
    const pugi::xml_node dimensions = group.child("ImageDimensions");
    camera.width = xml_.side(dimensions ? dimensions : group, "Width");
    camera.height = xml_.side(dimensions ? dimensions : group, "Height");
    const double longer = std::max(camera.width, camera.height);
    double pixel_mm = 0;
    if (const auto size = xml_.number(group, "PixelSize")) pixel_mm = *size;
    if (const auto size = xml_.number(group, "SensorSize")) pixel_mm = *size / longer;
    principal_point(group, pixel_mm, turn, camera);
    if (XmlFile::text(group, "CameraModelType") == "Fisheye") {
      turn = product(set_fisheye(group, pixel_mm, camera), turn);
      finish_camera(xml_.path(), xml_.place(group), camera);
      return camera;
    }
    camera.fx = focal_length(group, pixel_mm);
    camera.fy = camera.fx * xml_.number(group, "AspectRatio").value_or(1);
    Distortion& d = camera.distortion;
    d.model = LensModel::perspective;
    if (const auto skew = xml_.number(group, "Skew"); skew && camera.fx != 0) d.skew = *skew / camera.fx;
    constexpr LensTerm kTerms[] = {{"K1", &Distortion::k1},
                                   {"K2", &Distortion::k2},
                                   {"K3", &Distortion::k3},
                                   {"P1", &Distortion::p2},
                                   {"P2", &Distortion::p1}};
    for (const auto& [name, term] : kTerms) d.*term = xml_.number(group.child("Distortion"), name).value_or(0);
    finish_camera(xml_.path(), xml_.place(group), camera);
    return camera;
  }

  double focal_length(const pugi::xml_node& group, double pixel_mm) const {
    if (const auto focal = xml_.number(group, "FocalLengthPixels")) return *focal;
    const double focal_mm = xml_.needed(group, "FocalLength");
    if (!(pixel_mm > 0))
      xml_.fail(group, "FocalLength is in millimetres: expected a positive SensorSize or PixelSize with it");
    return focal_mm / pixel_mm;
  }

  /// Without a focal matrix the focal length is that of small angles, of which 90 degrees would be pi / 2.
  Matrix3 set_fisheye(const pugi::xml_node& group, double pixel_mm, Camera& camera) const {
    std::array<double, 4> affine{};
    if (const pugi::xml_node matrix = group.child("FisheyeFocalMatrix"))
      affine = {xml_.needed(matrix, "M_00"), xml_.needed(matrix, "M_01"), xml_.needed(matrix, "M_10"),
                xml_.needed(matrix, "M_11")};
    else
      affine[0] = affine[3] = focal_length(group, pixel_mm) * std::numbers::pi / 2;
    constexpr std::array<const char*, 5> kPowers{"P0", "P1", "P2", "P3", "P4"};
    std::array<double, 5> polynomial{0, 1, 0, 0, 0};
    for (std::size_t i = 0; i < kPowers.size(); ++i)
      if (const auto term = xml_.number(group.child("FisheyeDistortion"), kPowers[i])) polynomial[i] = *term;
    return io::set_fisheye(xml_.path(), xml_.place(group), affine, polynomial, camera);
  }

  void principal_point(const pugi::xml_node& group, double pixel_mm, const Matrix3& turn, Camera& camera) const {
    camera.cx = camera.width / 2.0;
    camera.cy = camera.height / 2.0;
    const pugi::xml_node point = group.child("PrincipalPoint");
    if (!point) return;
    if (point.child("xmm") || point.child("ymm")) {
      const double x = xml_.needed(point, "xmm"), y = xml_.needed(point, "ymm");
      if (!(pixel_mm > 0)) xml_.fail(point, "in millimetres: expected a positive SensorSize or PixelSize with it");
      camera.cx += (turn[0] * x + turn[1] * y) / pixel_mm;
      camera.cy += (turn[3] * x + turn[4] * y) / pixel_mm;
      return;
    }
    camera.cx = xml_.needed(point, "x") + 0.5;
    camera.cy = xml_.needed(point, "y") + 0.5;
  }

  Matrix3 rotation_of(const pugi::xml_node& node) const {
    if (node.child("M_00")) {
      Matrix3 m{};
      constexpr const char* kNames[] = {"M_00", "M_01", "M_02", "M_10", "M_11", "M_12", "M_20", "M_21", "M_22"};
      for (std::size_t i = 0; i < 9; ++i) m[i] = xml_.needed(node, kNames[i]);
      const auto rotation = rotation_near(m);
      if (!rotation) xml_.fail(node, "the matrix M_00 .. M_22 is no rotation");
      return *rotation;
    }
    if (node.child("Omega"))
      return transposed(
          rotation_from_angles({xml_.needed(node, "Omega"), xml_.needed(node, "Phi"), xml_.needed(node, "Kappa")}));
    xml_.fail(node, "expected a rotation as M_00 .. M_22 or as Omega, Phi, Kappa; other angles are not read");
  }

  /// Below BaseImagePath unless it is absolute; empty when there is no such child.
  std::string path_of(const pugi::xml_node& photo, const char* child) const {
    const std::string path = with_slashes(XmlFile::text(photo, child));
    if (path.empty() || base_.empty()) return path;
    const bool absolute = path.front() == '/' || (path.size() > 1 && path[1] == ':');
    return absolute ? path : base_ + '/' + path;
  }

  void read_photo(const pugi::xml_node& photo, const Camera& camera, const Matrix3& turn) {
    View view;
    view.name = stated_photo_name(xml_.path(), xml_.place(photo), path_of(photo, "ImagePath"));
    view.photo = view.name;
    view.mask = path_of(photo, "MaskPath");
    view.camera = camera;
    const pugi::xml_node pose = photo.child("Pose"), centre = pose.child("Center");
    view.pose = finish_pose(xml_.path(), xml_.place(pose), product(turn, rotation_of(pose.child("Rotation"))),
                            {xml_.needed(centre, "x"), xml_.needed(centre, "y"), xml_.needed(centre, "z")});
    scene_.views.push_back(std::move(view));
  }

  XmlFile xml_;
  SceneFile scene_;
  std::string base_;
  OmittedLenses omitted_;
  std::size_t unposed_ = 0, aside_ = 0;
};

/// The members of an archive that are BlocksExchange documents.
std::vector<std::string> zipped_documents(const ZipFile& archive) {
  std::vector<std::string> documents;
  for (const auto& [member, number] : archive.members())
    if (lower_case(member).ends_with(".xml") && xml_root_in(archive.read(member, kXmlHead)) == "BlocksExchange")
      documents.push_back(member);
  return documents;
}

bool is_zipped(const fs::path& file) {
  if (!is_zip(first_bytes(file, 4))) return false;
  const FileBytes bytes(file, FileBytes::Use::in_places);
  return !zipped_documents(ZipFile(file, bytes.view())).empty();
}

std::optional<fs::path> find_blocks(const fs::path& source) {
  const auto found = find_file(source, ".xml", [](const fs::path& file) { return xml_root(file) == "BlocksExchange"; });
  return found ? found : find_file(source, ".xmlz", is_zipped);
}

SceneFile parse_blocks(const fs::path& file, std::string_view bytes) {
  if (!is_zip(bytes)) return BlocksReader(file, bytes).read();
  const ZipFile archive(file, bytes);
  const std::vector<std::string> documents = zipped_documents(archive);
  if (documents.empty()) throw InputError(file, "", "holds no BlocksExchange XML");
  if (documents.size() > 1)
    throw InputError(file, "",
                     "holds " + std::to_string(documents.size()) + " BlocksExchange documents, among them " +
                         quote(documents[0]) + " and " + quote(documents[1]) + "; unpack it and name one");
  const std::string text = archive.read(documents.front());
  return BlocksReader(file, text).read();
}

}  // namespace

extern const SceneFormat kBlocksExchange{"BlocksExchange",
                                         "a ContextCapture BlocksExchange XML or XMLZ file (or a folder with one)",
                                         find_blocks,
                                         parse_blocks,
                                         {"images", "photos"}};

}  // namespace gpvc::io
