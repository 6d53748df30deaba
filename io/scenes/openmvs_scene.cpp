// OpenMVS' interface archive, .mvs: libs/MVS/Interface.h of github.com/cdcseacave/openMVS, versions 1 to 7.
//
// Pixels   the centre of the upper left pixel is (0, 0), x right, y down: the principal point moves by half a pixel.
//          Where the camera states no resolution, K is divided by the longer side, from version 6 (OpenMVS 2.0) on
//          with the principal point measured from the photo's edge, less half a pixel (Camera::ScaleK); a principal
//          point of 0, 0 is then the photo's middle.
// Camera   x right, y down, z forward: ours.
// Pose     R takes world to camera, C is the centre; a camera's own R and C are relative to its platform's pose.
// Lens     none: photos are undistorted.
#include <algorithm>
#include <cmath>

#include "io/file_bytes.h"
#include "io/files/text_scan.h"
#include "io/scenes/scene_file.h"

namespace gpvc::io {

namespace {

constexpr std::uint32_t kNoPose = 0xFFFFFFFFu, kNewest = 7;

struct MvsCamera {
  std::uint32_t width = 0, height = 0;
  Matrix3 k{}, rotation{};
  WorldPoint centre;
};

struct Platform {
  std::vector<MvsCamera> cameras;
  std::vector<Pose> poses;
};

/// \param off what 0 as the principal point's coordinate is, in pixels from the photo's edge
void scale_by_longer_side(Camera& camera, int width, int height, double off) {
  const double longer = std::max(width, height);
  camera.fx *= longer;
  camera.fy *= longer;
  const bool in_the_middle = camera.cx == 0 && camera.cy == 0;
  camera.cx = in_the_middle ? width / 2.0 : camera.cx * longer + off;
  camera.cy = in_the_middle ? height / 2.0 : camera.cy * longer + off;
}

void size_until_version_5(Camera& camera, int width, int height) { scale_by_longer_side(camera, width, height, 0.5); }

/// c' = (c + 1/2) / longer - 1/2 of a c that counts from the middle of the first pixel.
void size_from_version_6(Camera& camera, int width, int height) {
  scale_by_longer_side(camera, width, height, std::max(width, height) / 2.0);
}

class MvsReader {
 public:
  MvsReader(const fs::path& file, std::string_view bytes) : file_(file), reader_(file, bytes) { scene_.listing = file; }

  SceneFile read() {
    if (reader_.take(4, "the header") != "MVSI")
      reader_.fail(
          "expected 'MVSI', the interface archive of OpenMVS (a project saved by its tools in another "
          "archive type has to be exported)");
    version_ = reader_.read<std::uint32_t>("the header");
    if (version_ < 1 || version_ > kNewest)
      reader_.fail("archive version " + std::to_string(version_) + ", expected 1 to " + std::to_string(kNewest));
    scene_.size_camera = version_ < 6 ? size_until_version_5 : size_from_version_6;
    reader_.read<std::uint32_t>("the header");
    read_platforms();
    read_images();
    scene_.warn(masks_, "masks are not used: they hold labels, and the file does not say which to leave out");
    scene_.warn(unposed_, "images without a pose are left out");
    return std::move(scene_);
  }

 private:
  /// A count of elements of at least `least` bytes: more than the file can hold are refused before anything is
  /// allocated.
  std::uint64_t count(std::uint64_t least, const char* what) {
    const auto number = reader_.read<std::uint64_t>(what);
    if (number > reader_.remaining() / least)
      reader_.fail(std::string("a count of ") + std::to_string(number) + " in " + what +
                   ", the rest of the file cannot hold so many");
    return number;
  }
  std::string_view text(const char* what) { return reader_.take(count(1, what), what); }
  Matrix3 matrix(const char* what) {
    Matrix3 m{};
    for (double& v : m) v = reader_.read<double>(what);
    return m;
  }
  WorldPoint point(const char* what) {
    WorldPoint p;
    for (double* v : {&p.x, &p.y, &p.z}) *v = reader_.read<double>(what);
    return p;
  }

  void read_platforms() {
    constexpr const char* kWhat = "the platforms";
    for (std::uint64_t p = count(24, kWhat); p > 0; --p) {
      Platform& platform = platforms_.emplace_back();
      text(kWhat);
      for (std::uint64_t c = count(176, kWhat); c > 0; --c) {
        MvsCamera& camera = platform.cameras.emplace_back();
        text(kWhat);
        if (version_ > 3) text(kWhat);
        camera.width = reader_.read<std::uint32_t>(kWhat);
        camera.height = reader_.read<std::uint32_t>(kWhat);
        camera.k = matrix(kWhat);
        camera.rotation = matrix(kWhat);
        camera.centre = point(kWhat);
      }
      for (std::uint64_t n = count(96, kWhat); n > 0; --n) {
        Pose& pose = platform.poses.emplace_back();
        pose.rotation = matrix(kWhat);
        pose.centre = point(kWhat);
      }
    }
  }

  void read_images() {
    constexpr const char* kWhat = "the images";
    for (std::uint64_t i = count(20, kWhat); i > 0; --i) {
      const std::string name = with_slashes(text(kWhat));
      const bool masked = version_ > 4 && !text(kWhat).empty();
      const auto platform = reader_.read<std::uint32_t>(kWhat), camera = reader_.read<std::uint32_t>(kWhat),
                 pose = reader_.read<std::uint32_t>(kWhat);
      if (version_ > 2) reader_.read<std::uint32_t>(kWhat);
      if (version_ > 6) {
        reader_.take(12, kWhat);  // depths
        constexpr std::uint64_t kScore = 24;
        const std::uint64_t scores = count(kScore, kWhat);
        reader_.take(scores * kScore, kWhat);
      }
      if (pose == kNoPose) {
        ++unposed_;
        continue;
      }
      masks_ += masked ? 1 : 0;
      const std::string place = "image " + quote(name);
      if (platform >= platforms_.size() || camera >= platforms_[platform].cameras.size() ||
          pose >= platforms_[platform].poses.size())
        throw InputError(file_, place, "refers to a platform, camera or pose that the file does not hold");
      add_view(place, name, platforms_[platform].cameras[camera], platforms_[platform].poses[pose]);
    }
  }

  void add_view(const std::string& place, const std::string& name, const MvsCamera& camera, const Pose& pose) {
    View view;
    view.name = stated_photo_name(file_, place, name);
    view.photo = name;
    view.camera = {0, 0, camera.k[0], camera.k[4], camera.k[2], camera.k[5], {}};
    constexpr std::uint32_t kMaxSide = 1u << 24;
    if (camera.width > kMaxSide || camera.height > kMaxSide)
      throw InputError(file_, place, "its camera is larger than 2^24 pixels");
    if (camera.width > 0 && camera.height > 0) {
      view.camera.width = static_cast<int>(camera.width);
      view.camera.height = static_cast<int>(camera.height);
      view.camera.cx += 0.5;
      view.camera.cy += 0.5;
    }
    if (camera.k[1] != 0 && camera.k[0] != 0) {
      view.camera.distortion.model = LensModel::perspective;
      view.camera.distortion.skew = camera.k[1] / camera.k[0];
    }
    finish_camera(file_, place, view.camera);
    const auto own = rotation_near(camera.rotation), platform = rotation_near(pose.rotation);
    if (!own || !platform) throw InputError(file_, place, "a rotation matrix is none");
    const WorldPoint offset = product(transposed(*platform), camera.centre);
    view.pose = finish_pose(file_, place, product(*own, *platform),
                            {offset.x + pose.centre.x, offset.y + pose.centre.y, offset.z + pose.centre.z});
    scene_.views.push_back(std::move(view));
  }

  const fs::path& file_;
  ByteReader reader_;
  std::uint32_t version_ = 0;
  std::vector<Platform> platforms_;
  SceneFile scene_;
  std::size_t unposed_ = 0, masks_ = 0;
};

bool is_openmvs(const fs::path& file) {
  return lower_case(file.extension().string()) == ".mvs" && first_bytes(file, 3) == "MVS";
}

}  // namespace

extern const SceneFormat kOpenmvs{
    "OpenMVS",
    "an OpenMVS scene, .mvs (or a folder with one)",
    [](const fs::path& source) { return find_file(source, ".mvs", is_openmvs); },
    [](const fs::path& file, std::string_view bytes) { return MvsReader(file, bytes).read(); },
    {"images", "../images"}};

}  // namespace gpvc::io
