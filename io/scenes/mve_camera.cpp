#include "io/scenes/mve_camera.h"

namespace gpvc::io {

// Until the photo is known: fx = f, fy = f paspect, cx = ppx, cy = ppy.
Camera mve_camera(const fs::path& file, const std::string& place, const MveIntrinsics& in) {
  const auto& [focal, d0, d1, aspect, ppx, ppy] = in;
  Camera camera;
  camera.width = camera.height = 0;
  camera.fx = focal;
  camera.fy = focal * aspect;
  camera.cx = ppx;
  camera.cy = ppy;
  if (!(aspect > 0)) throw InputError(file, place, "the pixel's aspect is not positive");
  if (d0 != 0) {
    if (aspect != 1 || ppx != 0.5 || ppy != 0.5)
      throw InputError(file, place,
                       "distortion d0 with a pixel aspect other than 1 or a principal point other than 0.5 0.5 is "
                       "not read: it acts about the photo's middle");
    camera.distortion.model = d1 != 0 ? LensModel::perspective : LensModel::inverse_radial;
    camera.distortion.k1 = d0;
    camera.distortion.k2 = d1;
  }
  finish_camera(file, place, camera);
  return camera;
}

void size_mve_camera(Camera& camera, int width, int height) {
  const double f = camera.fx, aspect = camera.fy / camera.fx;
  const bool portrait = width * aspect < height;
  camera.fx = portrait ? f * height / aspect : f * width;
  camera.fy = portrait ? f * height : f * width * aspect;
  camera.cx *= width;
  camera.cy *= height;
}

Pose mve_pose(const fs::path& file, const std::string& place, const WorldPoint& t, const Matrix3& m) {
  const auto rotation = rotation_near(m);
  if (!rotation) throw InputError(file, place, "the matrix R00 .. R22 is no rotation");
  return finish_pose_from_translation(file, place, *rotation, t);
}

}  // namespace gpvc::io
