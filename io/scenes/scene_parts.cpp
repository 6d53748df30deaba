// Helpers that the readers of scene formats share: recognizing files, checking cameras and poses.
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "io/files/text_scan.h"
#include "io/finite.h"
#include "io/lens_terms.h"
#include "io/scene_members.h"
#include "io/scenes/scene_file.h"

namespace gpvc::io {

std::optional<fs::path> find_file(const fs::path& source, std::string_view extension, bool (*fits)(const fs::path&)) {
  if (fits(source)) return source;
  std::error_code ignored;
  std::vector<fs::path> found;
  for (const auto& entry : fs::directory_iterator(source, ignored))
    if (lower_case(entry.path().extension().string()) == extension && fits(entry.path())) found.push_back(entry.path());
  if (found.empty()) return std::nullopt;
  std::sort(found.begin(), found.end());
  if (found.size() > 1)
    throw InputError(source, "",
                     "holds " + std::to_string(found.size()) + " scenes, among them " + found[0].filename().string() +
                         " and " + found[1].filename().string() + "; name the one that is meant");
  return found.front();
}

std::optional<fs::path> find_folder(const fs::path& source, bool (*fits)(const fs::path&)) {
  if (is_file(source)) return fits(source) ? std::optional(folder_of(source)) : std::nullopt;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(source, ignored))
    if (fits(entry.path())) return source;
  return std::nullopt;
}

std::vector<Sidecar> sidecars_in(const fs::path& folder, std::string_view extension) {
  std::vector<Sidecar> sidecars;
  std::multimap<std::string, std::string> photos;  // by name and by name without extension
  for (const auto& entry : fs::directory_iterator(folder)) {
    const fs::path& file = entry.path();
    if (!is_file(file) || is_apple_double(file)) continue;
    if (lower_case(file.extension().string()) == extension) {
      sidecars.push_back({file, file.stem().string()});
    } else {
      photos.emplace(file.filename().string(), file.filename().string());
      if (file.has_extension()) photos.emplace(file.stem().string(), file.filename().string());
    }
  }
  for (Sidecar& sidecar : sidecars)
    if (photos.count(sidecar.photo) == 1) sidecar.photo = photos.find(sidecar.photo)->second;
  std::ranges::sort(sidecars, {}, &Sidecar::file);
  return sidecars;
}

void OmittedLenses::add(const std::string& lens, const InputError& refusal) {
  if (!first_) first_ = refusal;
  ++counts_[lens];
}

void OmittedLenses::report(SceneFile& scene, const char* views) const {
  if (!first_) return;
  if (scene.views.empty()) throw *first_;
  std::size_t all = 0;
  std::string names;
  for (const auto& [lens, count] : counts_) {
    all += count;
    names += (names.empty() ? "" : ", ") + quote(lens);
  }
  const bool one = counts_.size() == 1;
  scene.warn(all, views + std::string(" are left out: their ") + (one ? "lens, " : "lenses, ") + names +
                      (one ? ", is not supported" : ", are not supported"));
}

std::optional<int> image_side(double value) {
  constexpr int kMost = 1 << 24;  // far beyond any sensor
  if (!(value >= 1 && value <= kMost && value == std::floor(value))) return std::nullopt;
  return static_cast<int>(value);
}

std::string stated_photo_name(const fs::path& file, const std::string& place, std::string name) {
  const std::string last = fs::path(name).filename().string();
  if (last.empty() || last == "." || last == ".." || last.ends_with(':'))
    throw InputError(file, place, "expected the name of a photo, found " + quote(name));
  return name;
}

void finish_camera(const fs::path& file, const std::string& place, Camera& camera) {
  if ((camera.width != 0 || camera.height != 0) && (!image_side(camera.width) || !image_side(camera.height)))
    throw InputError(file, place,
                     "an image size of " + std::to_string(camera.width) + " x " + std::to_string(camera.height) +
                         ", expected 1 to 2^24 pixels a side");
  const Distortion& d = camera.distortion;
  bool finite = true;
  for (const double value : {camera.fx, camera.fy, camera.cx, camera.cy}) finite = finite && std::isfinite(value);
  for (const LensTerm& term : kLensTerms) finite = finite && std::isfinite(d.*term.term);
  if (!finite) throw InputError(file, place, "a camera parameter is not finite");
  if (!(camera.fx > 0 && camera.fy > 0)) throw InputError(file, place, "the focal length is not positive");
  if (d.model == LensModel::fov && !(d.omega > 0 && d.omega < 3.14159))
    throw InputError(file, place, "the field of view is not between 0 and pi, its parameter omega");
  if (d.model == LensModel::unified && !(d.alpha >= 0 && d.alpha <= 1 && d.beta > 0))
    throw InputError(file, place, "the unified model's alpha is not between 0 and 1, or its beta not positive");
  limit_distortion(camera);
}

Matrix3 set_fisheye(const fs::path& file, const std::string& place, const std::array<double, 4>& affine,
                    std::span<const double> polynomial, Camera& camera) {
  std::array<double, 5> p{};
  for (std::size_t i = 0; i < polynomial.size(); ++i) {
    if (i < p.size()) p[i] = polynomial[i];
    if ((i == 0 || i >= p.size()) && polynomial[i] != 0)
      throw InputError(file, place,
                       "the fisheye's polynomial has a term of power " + std::to_string(i) +
                           ", expected powers 1 to 4 alone: no ray is shown where it goes");
  }
  constexpr double kTurns = 2 / std::numbers::pi;
  const double unit = p[1] * kTurns;
  const auto [c, d, e, f] = affine;
  const double down = std::hypot(e, f), cosine = f / down, sine = e / down;
  if (!(unit > 0) || !((c * cosine - d * sine) * down > 0))
    throw InputError(file, place, "the fisheye's affine matrix or its polynomial shows all in one line, or mirrored");
  // affine = [across across*skew; 0 down] * turn
  camera.fx = unit * (c * cosine - d * sine);
  camera.fy = unit * down;
  Distortion& lens = camera.distortion;
  lens.model = LensModel::fisheye_polynomial;
  lens.skew = unit * (c * sine + d * cosine) / camera.fx;
  double power = kTurns / p[1];
  for (const auto& [term, coefficient] :
       {std::pair{&Distortion::a1, p[2]}, {&Distortion::a2, p[3]}, {&Distortion::a3, p[4]}}) {
    lens.*term = coefficient * power;
    power *= kTurns;
  }
  return {cosine, -sine, 0, sine, cosine, 0, 0, 0, 1};
}

std::string reference_system(std::string_view definition) {
  std::string line;
  while (!definition.empty()) line += trimmed(next_line(definition));
  for (const char* local : {"LOCAL_CS", "ENGCRS", "ENGINEERINGCRS"})
    if (line.starts_with(local)) return {};
  return line;
}

Matrix3 product(const Matrix3& a, const Matrix3& b) {
  Matrix3 out{};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      for (std::size_t k = 0; k < 3; ++k) out[3 * i + j] += a[3 * i + k] * b[3 * k + j];
  return out;
}

Matrix3 transposed(const Matrix3& m) { return {m[0], m[3], m[6], m[1], m[4], m[7], m[2], m[5], m[8]}; }

WorldPoint product(const Matrix3& m, const WorldPoint& p) {
  return {m[0] * p.x + m[1] * p.y + m[2] * p.z, m[3] * p.x + m[4] * p.y + m[5] * p.z,
          m[6] * p.x + m[7] * p.y + m[8] * p.z};
}

std::optional<Matrix3> rotation_from_quaternion(const std::array<double, 4>& q) {
  const double norm = std::hypot(std::hypot(q[0], q[1]), std::hypot(q[2], q[3]));
  if (!(norm > 0) || !std::isfinite(norm)) return std::nullopt;
  const double w = q[0] / norm, x = q[1] / norm, y = q[2] / norm, z = q[3] / norm;
  return Matrix3{1 - 2 * (y * y + z * z), 2 * (x * y - w * z),     2 * (x * z + w * y),
                 2 * (x * y + w * z),     1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
                 2 * (x * z - w * y),     2 * (y * z + w * x),     1 - 2 * (x * x + y * y)};
}

std::optional<Matrix3> rotation_from_angle_axis(const WorldPoint& v) {
  const double angle = std::hypot(v.x, v.y, v.z);
  // sin(angle / 2) / angle tends to 1/2: no division by zero.
  const double s = angle > 0 ? std::sin(angle / 2) / angle : 0.5;
  return rotation_from_quaternion({std::cos(angle / 2), s * v.x, s * v.y, s * v.z});
}

// The largest of the four first (Shepperd 1978).
std::array<double, 4> quaternion(const Matrix3& r) {
  const std::array<double, 4> squares{1 + r[0] + r[4] + r[8], 1 + r[0] - r[4] - r[8], 1 - r[0] + r[4] - r[8],
                                      1 - r[0] - r[4] + r[8]};
  const auto largest = static_cast<std::size_t>(std::max_element(squares.begin(), squares.end()) - squares.begin());
  const double twice = std::sqrt(squares[largest]);
  // The products of each two of the four, times 4.
  const std::array<std::array<double, 4>, 4> products{{{twice * twice, r[7] - r[5], r[2] - r[6], r[3] - r[1]},
                                                       {r[7] - r[5], twice * twice, r[1] + r[3], r[2] + r[6]},
                                                       {r[2] - r[6], r[1] + r[3], twice * twice, r[5] + r[7]},
                                                       {r[3] - r[1], r[2] + r[6], r[5] + r[7], twice * twice}}};
  std::array<double, 4> q = products[largest];
  for (double& v : q) v /= 2 * twice;
  return q;
}

std::array<double, 3> angle_axis_from_rotation(const Matrix3& rotation) {
  const auto [w, x, y, z] = quaternion(rotation);
  // The quaternion of a turn by an angle is cos(angle / 2) and sin(angle / 2) times the axis, or both with the other sign.
  const double sine = std::hypot(x, y, z), half = std::atan2(sine, std::abs(w));
  const double factor = (w < 0 ? -2 : 2) * (sine > 0 ? half / sine : 1);
  return {factor * x, factor * y, factor * z};
}

Matrix3 rotation_from_angles(const std::array<double, 3>& omega_phi_kappa) {
  std::array<double, 3> c{}, s{};
  for (std::size_t i = 0; i < 3; ++i) {
    const double angle = omega_phi_kappa[i] * (std::numbers::pi / 180);
    c[i] = std::cos(angle);
    s[i] = std::sin(angle);
  }
  const Matrix3 x{1, 0, 0, 0, c[0], -s[0], 0, s[0], c[0]}, y{c[1], 0, s[1], 0, 1, 0, -s[1], 0, c[1]},
      z{c[2], -s[2], 0, s[2], c[2], 0, 0, 0, 1};
  return product(product(x, y), z);
}

std::optional<Matrix3> rotation_near(const Matrix3& m) {
  constexpr double kPrinting = 0.01;
  const Matrix3 square = product(m, transposed(m));
  for (std::size_t i = 0; i < 9; ++i)
    if (!(std::abs(square[i] - (i % 4 == 0 ? 1 : 0)) <= kPrinting)) return std::nullopt;
  // Newton's iteration for the polar decomposition, R <- (R + R^-T) / 2, squares the distance each time; the inverse
  // transposed is the cofactors over the determinant.
  Matrix3 r = m;
  for (int iteration = 0; iteration < 5; ++iteration) {
    const Matrix3 c{r[4] * r[8] - r[5] * r[7], r[5] * r[6] - r[3] * r[8], r[3] * r[7] - r[4] * r[6],
                    r[2] * r[7] - r[1] * r[8], r[0] * r[8] - r[2] * r[6], r[1] * r[6] - r[0] * r[7],
                    r[1] * r[5] - r[2] * r[4], r[2] * r[3] - r[0] * r[5], r[0] * r[4] - r[1] * r[3]};
    const double determinant = r[0] * c[0] + r[1] * c[1] + r[2] * c[2];
    if (!(determinant > 0)) return std::nullopt;  // a mirror
    for (std::size_t i = 0; i < 9; ++i) r[i] = (r[i] + c[i] / determinant) / 2;
  }
  return r;
}

Pose finish_pose(const fs::path& file, const std::string& place, const Matrix3& rotation, const WorldPoint& centre) {
  if (!is_finite(rotation)) throw InputError(file, place, "the rotation is not finite");
  if (!is_finite(centre)) throw InputError(file, place, "the camera centre is not finite");
  return {rotation, centre};
}

Pose finish_pose_from_translation(const fs::path& file, const std::string& place, const Matrix3& rotation,
                                  const WorldPoint& t) {
  if (!is_finite(t)) throw InputError(file, place, "the translation is not finite");
  const WorldPoint c = product(transposed(rotation), t);
  return finish_pose(file, place, rotation, {-c.x, -c.y, -c.z});
}

}  // namespace gpvc::io
