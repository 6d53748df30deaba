#include "io/scenes/panorama_views.h"

#include <cmath>
#include <numbers>

#include "io/lens/spherical.h"
#include "io/scene_files.h"

namespace gpvc::io {

namespace {

struct Face {
  const char* name;
  LensModel model;
  double longitude;      ///< of the frame's principal point, in turns from the panorama's left edge
  Matrix3 from_forward;  ///< takes the panorama's axes to the view's
};

constexpr Face kFaces[] = {{"front", LensModel::spherical, 0.5, {1, 0, 0, 0, 1, 0, 0, 0, 1}},
                           {"right", LensModel::spherical, 0.75, {0, 0, -1, 0, 1, 0, 1, 0, 0}},
                           {"back", LensModel::spherical, 1, {-1, 0, 0, 0, 1, 0, 0, 0, -1}},
                           {"left", LensModel::spherical, 0.25, {0, 0, 1, 0, 1, 0, -1, 0, 0}},
                           {"up", LensModel::spherical_up, 0.5, {1, 0, 0, 0, 0, 1, 0, -1, 0}},
                           {"down", LensModel::spherical_down, 0.5, {1, 0, 0, 0, 0, -1, 0, 1, 0}}};

}  // namespace

Camera panorama_camera(const std::filesystem::path& file, const std::string& place, int width, int height, double down,
                       const PhotoPoint& off) {
  // The columns that continue_around() adds are those that views see about the middle.
  if (!(std::abs(off.x) <= 1))
    throw InputError(file, place, "expected the principal point of a panorama in its middle");
  Camera camera;
  camera.width = width;
  camera.height = height;
  camera.fx = width / (2 * std::numbers::pi);
  camera.fy = down;
  camera.cx = width / 2.0 + off.x;
  camera.cy = height / 2.0 + off.y;
  camera.distortion.model = LensModel::spherical;
  finish_camera(file, place, camera);
  return camera;
}

bool is_panorama(const View& view) { return is_spherical(view.camera.distortion.model); }

std::vector<View> views_of(const View& view) {
  if (!is_panorama(view)) return {view};
  const std::filesystem::path name = view.name;
  std::vector<View> views;
  for (const Face& face : kFaces) {
    View& out = views.emplace_back(view);
    out.name = (name.parent_path() / name.stem() / face.name).string() + name.extension().string();
    out.pose.rotation = product(face.from_forward, view.pose.rotation);
    const int width = view.camera.width, before = columns_before(width);
    out.camera.width = before + width + columns_behind(width);
    out.camera.cx = before + face.longitude * width + view.camera.cx - width / 2.0;
    out.camera.distortion.model = face.model;
  }
  return views;
}

std::string photo_name(const View& view) {
  if (!is_panorama(view) && !view.camera.distortion.looks_aside()) return view.name;
  const std::filesystem::path name = view.name;
  return name.parent_path().string() + name.extension().string();
}

}  // namespace gpvc::io
