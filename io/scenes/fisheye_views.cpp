#include "io/scenes/fisheye_views.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <numbers>
#include <optional>

#include "io/bands/band_range.h"
#include "io/file_hashes.h"
#include "io/images.h"
#include "io/images/image_file.h"
#include "io/lens/lens.h"
#include "io/scenes/scene_file.h"

namespace gpvc::io {

namespace {

constexpr double kDegree = std::numbers::pi / 180;
/// No lens that is made shows more than 250 degrees.
constexpr double kFarthest = 125 * kDegree;

std::optional<double> angle_at(const Camera& camera, const PhotoPoint& p, double most) {
  const auto ray = ray_of_photo(camera, p, most);
  return ray ? std::optional(std::atan2(std::hypot(ray->x, ray->y), ray->z)) : std::nullopt;
}

/// How far from its axis the lens may show something, from the photo's shape. Where the image circle fills the photo, the
/// corners are some 90 degrees from the axis at most; where they are farther, or the lens folds back before them, they are
/// dark, and the circle reaches two of the edges at most.
double largest_circle(const Camera& camera) {
  constexpr double kWidestCorner = 92 * kDegree;
  const double most = std::min(largest_angle(camera.distortion), kFarthest);
  const double w = camera.width, h = camera.height;
  const auto farthest = [&](std::initializer_list<PhotoPoint> places, bool all) {
    double angle = 0;
    for (const PhotoPoint& p : places) {
      const std::optional<double> there = angle_at(camera, p, most);
      if (all && !(there && *there <= kWidestCorner)) return 0.0;
      angle = std::max(angle, there.value_or(most));
    }
    return angle;
  };
  const double corners = farthest({{0, 0}, {w, 0}, {0, h}, {w, h}}, true);
  return corners > 0 ? corners : farthest({{0, camera.cy}, {w, camera.cy}, {camera.cx, 0}, {camera.cx, h}}, false);
}

/// The share of what the lens shows that lies outside the frame.
double share_beyond_frame(const Camera& camera, double most) {
  constexpr int kSteps = 16;
  int shown = 0, beyond = 0;
  for (int j = 0; j < kSteps; ++j)
    for (int i = 0; i < kSteps; ++i) {
      const auto ray =
          ray_of_photo(camera, {(i + 0.5) / kSteps * camera.width, (j + 0.5) / kSteps * camera.height}, most);
      if (!ray) continue;
      ++shown;
      if (ray->z > 0) {
        const PixelPoint p = pixel_from_camera(camera, {ray->x, ray->y, ray->z});
        if (p.x >= 0 && p.x <= camera.width && p.y >= 0 && p.y <= camera.height) continue;
      }
      ++beyond;
    }
  return shown > 0 ? static_cast<double>(beyond) / shown : 0;
}

/// v in the axes of a view that looks aside.
std::array<double, 3> turned(const Matrix3& view_from_lens, const std::array<double, 3>& v) {
  const WorldPoint p = io::product(view_from_lens, WorldPoint{v[0], v[1], v[2]});
  return {p.x, p.y, p.z};
}

bool is_wide_fisheye(const View& view) { return fisheye_views(view).size() > 1; }

/// Photos of a lens are about the same: calibrations for each photo differ by less.
bool is_same_lens(const Camera& a, const Camera& b) {
  return a.width == b.width && a.height == b.height && a.distortion.model == b.distortion.model &&
         std::abs(a.fx / b.fx - 1) < 0.02;
}

/// The brightness of photos along rings about the lens's axis, of several photos the largest.
class Rings {
 public:
  explicit Rings(const Camera& camera) : camera_(camera), most_(largest_circle(camera)) {
    brightness_.assign(kRings * kAround, -1);
  }

  void add(const Image& photo) {
    for (int ring = 0; ring < kRings; ++ring)
      for (int i = 0; i < kAround; ++i) {
        const double theta = angle(ring), around = 2 * std::numbers::pi * i / kAround;
        const auto p = photo_of_ray(
            camera_, {std::sin(theta) * std::cos(around), std::sin(theta) * std::sin(around), std::cos(theta)}, most_);
        if (!p || !(p->x >= 0 && p->y >= 0 && p->x < photo.width && p->y < photo.height)) continue;
        const std::uint8_t* pixel = photo.at(static_cast<int>(p->x), static_cast<int>(p->y));
        int& known = brightness_[static_cast<std::size_t>(ring * kAround + i)];
        known = std::max({known, int{pixel[0]}, int{pixel[1]}, int{pixel[2]}});
      }
  }

  /// The angle of the outermost ring that is lit, less what the lens leaves unsharp at the rim; the largest one where none
  /// is, in the dark.
  double image_circle() const {
    constexpr int kDark = 24;      // of 255: what stray light and JPEG leave of black
    constexpr double kLit = 0.9;   // what a drone's legs and an axis beside the circle's middle leave
    constexpr double kRim = 0.01;  // of the circle's radius
    for (int ring = kRings - 1; ring > 0; --ring) {
      int shown = 0, lit = 0;
      for (int i = 0; i < kAround; ++i) {
        const int brightness = brightness_[static_cast<std::size_t>(ring * kAround + i)];
        shown += brightness >= 0 ? 1 : 0;
        lit += brightness > kDark ? 1 : 0;
      }
      if (shown > 0 && lit >= kLit * shown) return ring == kRings - 1 ? most_ : angle(ring) * (1 - kRim);
    }
    return most_;
  }

 private:
  static constexpr int kRings = 500, kAround = 360;
  double angle(int ring) const { return most_ * (ring + 0.5) / kRings; }

  Camera camera_;
  double most_;
  std::vector<int> brightness_;  ///< by ring and place on it; -1: outside the photo
};

}  // namespace

std::vector<View> fisheye_views(const View& view) {
  const Camera& camera = view.camera;
  if (camera.width == 0 || !is_of_angle(camera.distortion.model)) return {view};
  const double most = camera.distortion.max_angle > 0 ? camera.distortion.max_angle : largest_circle(camera);
  constexpr double kTooMuch = 0.4;
  const bool wide = share_beyond_frame(camera, most) > kTooMuch;
  View ahead = view;
  if ((wide || camera.distortion.max_angle > 0) && most < std::numbers::pi / 2) {
    double& max_r2 = ahead.camera.distortion.max_r2;
    max_r2 = std::min(max_r2, std::tan(most) * std::tan(most));
  }
  if (!wide) return {ahead};

  const double right = std::atan((camera.width - camera.cx) / camera.fx), left = std::atan(camera.cx / camera.fx),
               down = std::atan((camera.height - camera.cy) / camera.fy), up = std::atan(camera.cy / camera.fy);
  const auto across = [](double angle) {
    const double c = std::cos(angle), s = std::sin(angle);
    return Matrix3{c, 0, s, 0, 1, 0, -s, 0, c};
  };
  const auto upright = [](double angle) {
    const double c = std::cos(angle), s = std::sin(angle);
    return Matrix3{1, 0, 0, 0, c, s, 0, -s, c};
  };
  const std::filesystem::path name = view.name;
  std::vector<View> views{ahead};
  for (const auto& [way, lens_from_frame] : {std::pair{"right", across(right)}, std::pair{"left", across(-left)},
                                             std::pair{"down", upright(down)}, std::pair{"up", upright(-up)}}) {
    View& aside = views.emplace_back(view);
    aside.name = (name.parent_path() / name.stem() / way).string() + name.extension().string();
    const Matrix3 frame_from_lens = transposed(lens_from_frame);
    aside.pose.rotation = product(frame_from_lens, view.pose.rotation);
    Distortion& lens = aside.camera.distortion;
    lens.lens_from_frame = lens_from_frame;
    lens.max_angle = most;
    lens.max_r2 = Distortion{}.max_r2;
    lens.motion.turn = turned(frame_from_lens, lens.motion.turn);
    lens.motion.step = turned(frame_from_lens, lens.motion.step);
  }
  return views;
}

namespace {

/// Photos of one lens. Those of more than 8 bits are looked at in the range of all of them: 12 bits in 16 would be dark all over,
/// and a dark photo stretched by itself would be lit all over.
class PhotosOfLens {
 public:
  explicit PhotosOfLens(const Camera& camera) : rings_(camera) {}

  void add(const std::filesystem::path& file) {
    if (read_photo_header(file).type == SampleType::u8) return rings_.add(read_image(file));
    const BandSet set = read_band_set(file);
    if (!set_) set_ = set;
    if (set.type != set_->type || set.bands.size() != set_->bands.size()) return;  // which find_bands() refuses
    StoredPhoto stored = read_stored(file, set.bands.size());
    linear_light_ = stored.linear_light;
    deep_.push_back({std::move(stored.samples), std::move(stored.without_data), linear_light_});
    const std::vector<float> some = some_samples(deep_.back());
    some_.insert(some_.end(), some.begin(), some.end());
  }

  double image_circle() {
    if (set_) set_range(*set_, std::move(some_), linear_light_);
    for (const BandPhoto& photo : deep_) rings_.add(composite_of(photo.samples, *set_, linear_light_, new_room));
    return rings_.image_circle();
  }

 private:
  Rings rings_;
  std::vector<BandPhoto> deep_;
  std::optional<BandSet> set_;
  std::vector<float> some_;
  bool linear_light_ = false;
};

}  // namespace

std::vector<HashedPhoto> find_image_circles(std::vector<View>& views, const std::vector<bool>& needed) {
  std::vector<HashedPhoto> decoded;
  FileHashes hashes;
  std::vector<bool> done(views.size(), false);
  for (std::size_t first = 0; first < views.size(); ++first) {
    if (done[first] || views[first].photo.empty() || !is_wide_fisheye(views[first])) continue;
    std::vector<std::size_t> same;
    for (std::size_t i = first; i < views.size(); ++i)
      if (!done[i] && !views[i].photo.empty() && is_same_lens(views[i].camera, views[first].camera)) same.push_back(i);
    constexpr std::size_t kPhotos = 3;
    PhotosOfLens photos(views[first].camera);
    const std::size_t count = std::min(kPhotos, same.size());
    for (std::size_t n = 0; n < count; ++n)
      for (std::size_t at = n * same.size() / count; at < (n + 1) * same.size() / count; ++at) try {
          const std::filesystem::path& file = views[same[at]].photo;
          const WorkKey hash = hashes.unchanged(file).hash;
          photos.add(file);
          hashes.unchanged(file);  // throws where it has changed meanwhile
          decoded.push_back({file, hash.bits});
          break;
        } catch (const InputError&) {
          if (needed[same[at]]) throw;
          views[same[at]].photo.clear();
        }
    const double circle = photos.image_circle();
    for (const std::size_t i : same) {
      views[i].camera.distortion.max_angle = circle;
      done[i] = true;
    }
  }
  return decoded;
}

}  // namespace gpvc::io
