// RealityCapture's (RealityScan's) registration as .csv: "Internal/External Camera Parameters", whose columns older
// versions name heading, f, px, py, and "OpenCV-compliant Internal/External Camera Parameters". "Orientation and Euler
// Angles" and "Reporting System" of the document that reality_camera.h names, which also states pixels and lens.
//
//   #name,x,y,alt,yaw,pitch,roll,f_35mm,px_norm,py_norm,k1,k2,k3,k4,t1,t2                    angles in degrees
//   #name,tx,ty,tz,R00,R01 .. R22,f_pix,px_pix,py_pix,k1,k2,t2,t1,k3,k4 (R = ...)            in pixels
//
// Columns  are found by their names: users edit the export's template. px, py and the lens may be missing.
// Camera   x right, y down, z forward: ours. With R, x_camera = R x_world + t, and the principal point is measured from
//          the photo's corner.
// Angles   turn an aircraft whose axes are nose, right wing, down from north, east, down: Rz(yaw) Ry(pitch) Rx(roll).
//          The photo's upper edge is towards the nose, and the camera looks down. In axes x east, y north, z up that is
//          camera to world = Rz(-yaw) Rx(pitch) Ry(roll) diag(1, -1, -1), as nerfstudio and camorph have it too. A
//          camera in both this file and .xmp (forums.unrealengine.com, "Different rotation of cameras in XMP and CSV")
//          agrees.
// World    x, y, alt are the export's coordinates. The angles are those of the ground plane's axes, which projected
//          coordinates are turned against by the meridian convergence: such a file gets a warning. A file in degrees of
//          longitude and latitude cannot be told from one in metres.
// Lens     The file does not say which model it has. k1 alone is Division: the others have three coefficients or more.
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "io/files/text_scan.h"
#include "io/scenes/reality_camera.h"
#include "io/scenes/scene_file.h"

namespace gpvc::io {

namespace {

std::vector<std::string_view> comma_separated(std::string_view line) {
  std::vector<std::string_view> fields;
  for (;;) {
    const std::size_t comma = line.find(',');
    fields.push_back(trimmed(line.substr(0, comma)));
    if (comma == std::string_view::npos) return fields;
    line.remove_prefix(comma + 1);
  }
}

/// Where each column is.
class RealityColumns {
 public:
  static std::optional<RealityColumns> from_header(std::string_view line) {
    line = trimmed(line.substr(0, line.find('(')));
    if (line.starts_with('#')) line.remove_prefix(1);
    RealityColumns columns;
    for (const std::string_view field : comma_separated(line))
      columns.places_.emplace(lower_case(field), columns.count_++);
    struct Renamed {
      const char *older, *name;
    };
    constexpr Renamed kRenamed[] = {{"heading", "yaw"}, {"f", "f_35mm"}, {"px", "px_norm"}, {"py", "py_norm"}};
    for (const Renamed& column : kRenamed)
      if (const auto older = columns.place(column.older)) columns.places_.emplace(column.name, *older);
    const bool angles = columns.has({"name", "x", "y", "alt", "yaw", "pitch", "roll", "f_35mm"});
    columns.matrices_ = columns.has({"name", "tx", "ty", "tz", "r00", "r01", "r02", "r10", "r11", "r12", "r20", "r21",
                                     "r22", "f_pix", "px_pix", "py_pix"});
    if ((!angles && !columns.matrices_) || columns.places_.at("name") != 0) return std::nullopt;
    return columns;
  }

  /// A pose as a matrix, lengths in pixels.
  bool matrices() const { return matrices_; }
  std::size_t count() const { return count_; }
  std::optional<std::size_t> place(const char* name) const {
    const auto found = places_.find(name);
    return found == places_.end() ? std::nullopt : std::optional(found->second);
  }

 private:
  bool has(std::initializer_list<const char*> names) const {
    return std::ranges::all_of(names, [this](const char* name) { return places_.contains(name); });
  }

  std::map<std::string, std::size_t, std::less<>> places_;
  std::size_t count_ = 0;
  bool matrices_ = false;
};

/// Takes the header off `text`; a line "#cameras COUNT" may precede it.
std::optional<RealityColumns> reality_header(std::string_view& text, std::size_t& line_number) {
  std::string_view line;
  while (line.empty() && !text.empty()) {
    line = trimmed(next_line(text));
    ++line_number;
    if (line.starts_with("#cameras")) line = {};
  }
  return RealityColumns::from_header(line);
}

Matrix3 camera_from_world_turned(double yaw, double pitch, double roll) {
  constexpr double kDegree = std::numbers::pi / 180;
  const double cy = std::cos(yaw * kDegree), sy = std::sin(yaw * kDegree);
  const double cp = std::cos(pitch * kDegree), sp = std::sin(pitch * kDegree);
  const double cr = std::cos(roll * kDegree), sr = std::sin(roll * kDegree);
  const Matrix3 turn_z{cy, sy, 0, -sy, cy, 0, 0, 0, 1};  // by -yaw
  const Matrix3 turn_x{1, 0, 0, 0, cp, -sp, 0, sp, cp};
  const Matrix3 turn_y{cr, 0, sr, 0, 1, 0, -sr, 0, cr};
  return transposed(product(product(turn_z, turn_x), product(turn_y, {1, 0, 0, 0, -1, 0, 0, 0, -1})));
}

class RealityCsvReader {
 public:
  RealityCsvReader(const fs::path& file, std::string_view text) : file_(file), text_(without_byte_order_mark(text)) {
    scene_.listing = file;
  }

  SceneFile read() {
    const std::optional<RealityColumns> columns = reality_header(text_, line_);
    if (!columns)
      throw InputError(file_, place(),
                       "expected the columns #name,x,y,alt,yaw,pitch,roll,f_35mm,.. or #name,tx,ty,tz,R00,..");
    columns_ = *columns;
    scene_.size_camera = size_reality_camera;
    if (columns_.matrices()) scene_.size_camera = [](Camera&, int, int) {};
    while (!text_.empty()) {
      const std::string_view row = trimmed(next_line(text_));
      ++line_;
      if (!row.empty() && !row.starts_with('#')) read_row(row);
    }
    omitted_.report(scene_, "photos");
    if (!columns_.matrices() && far_)
      scene_.warnings.push_back(
          "the coordinates seem to be projected; yaw, pitch and roll are not about their axes but off by the meridian "
          "convergence: export .xmp or OpenCV-compliant camera parameters instead");
    return std::move(scene_);
  }

 private:
  std::string place() const { return "line " + std::to_string(line_); }

  double number(const char* name) const {
    const std::string_view word = fields_.at(columns_.place(name).value());
    const std::optional<double> value = number_from(word);
    if (!value || !std::isfinite(*value))
      throw InputError(file_, place(), "expected a finite number as " + std::string(name) + ", found " + quote(word));
    return *value;
  }
  double number_or_zero(const char* name) const { return columns_.place(name) ? number(name) : 0; }

  void read_row(std::string_view row) {
    fields_ = comma_separated(row);
    if (fields_.size() < columns_.count())
      throw InputError(
          file_, place(),
          "expected " + std::to_string(columns_.count()) + " values, found " + std::to_string(fields_.size()));
    // A name may contain commas; it comes first.
    const std::size_t commas = fields_.size() - columns_.count();
    const std::string_view name(
        fields_[0].data(),
        static_cast<std::size_t>(fields_[commas].data() - fields_[0].data()) + fields_[commas].size());
    fields_.erase(fields_.begin(), fields_.begin() + static_cast<std::ptrdiff_t>(commas));
    View view;
    view.name = stated_photo_name(file_, place(), with_slashes(name));
    view.photo = view.name;
    const std::array<double, 6> lens{number_or_zero("k1"), number_or_zero("k2"), number_or_zero("k3"),
                                     number_or_zero("k4"), number_or_zero("t1"), number_or_zero("t2")};
    view.pose = pose();
    view.camera = camera(lens);
    if (lens[0] != 0 && std::all_of(lens.begin() + 1, lens.end(), [](double k) { return k == 0; }))
      omitted_.add("division", InputError(file_, place(), std::string("k1 stands alone: ") + kNoDivision));
    else
      scene_.views.push_back(std::move(view));
  }

  Pose pose() {
    if (columns_.matrices()) {
      const auto rotation = rotation_near({number("r00"), number("r01"), number("r02"), number("r10"), number("r11"),
                                           number("r12"), number("r20"), number("r21"), number("r22")});
      if (!rotation) throw InputError(file_, place(), "the matrix R00 .. R22 is no rotation");
      return finish_pose_from_translation(file_, place(), *rotation, {number("tx"), number("ty"), number("tz")});
    }
    const WorldPoint centre{number("x"), number("y"), number("alt")};
    constexpr double kFar_m = 1e4;  // the program's own coordinates begin in the middle of the scene
    far_ = far_ || std::abs(centre.x) > kFar_m || std::abs(centre.y) > kFar_m;
    return finish_pose(file_, place(), camera_from_world_turned(number("yaw"), number("pitch"), number("roll")),
                       centre);
  }

  Camera camera(const std::array<double, 6>& lens) const {
    Camera camera;
    if (columns_.matrices()) {
      camera.fx = camera.fy = number("f_pix");
      camera.cx = number("px_pix");
      camera.cy = number("py_pix");
      set_brown_terms(lens, camera);
    } else {
      camera = camera_from({number("f_35mm"), number_or_zero("px_norm"), number_or_zero("py_norm"), lens});
    }
    finish_camera(file_, place(), camera);
    return camera;
  }

  const fs::path& file_;
  std::string_view text_;
  std::size_t line_ = 0;
  RealityColumns columns_;
  std::vector<std::string_view> fields_;  ///< of the row
  bool far_ = false;                      ///< coordinates beyond any scene's about its middle
  OmittedLenses omitted_;
  SceneFile scene_;
};

bool is_reality_csv(const fs::path& file) {
  if (lower_case(file.extension().string()) != ".csv") return false;
  const std::string head = first_bytes(file, 1u << 12);
  std::string_view text = without_byte_order_mark(head);
  std::size_t line = 0;
  return reality_header(text, line).has_value();
}

}  // namespace

extern const SceneFormat kRealityCsv{
    "RealityCapture CSV",
    "RealityCapture's camera parameters, .csv (or a folder with them)",
    [](const fs::path& source) { return find_file(source, ".csv", is_reality_csv); },
    [](const fs::path& file, std::string_view text) { return RealityCsvReader(file, text).read(); },
    {"images", "photos", "../images"}};

}  // namespace gpvc::io
