// Cameras that fit the sizes of their photos.
#include <algorithm>

#include "io/files/paths.h"
#include "io/images/image_file.h"
#include "io/photos.h"
#include "io/scenes/bad_photos.h"
#include "io/scenes/photo_files.h"

namespace gpvc::io {

namespace {

/// A photo at another size than its camera's: the same picture when one factor explains both sides, whichever way they
/// were rounded. An equal side rounds nothing and allows no other.
bool same_shape(int width, int height, const Camera& camera) {
  if ((width == camera.width) != (height == camera.height)) return false;
  // width = factor * camera.width, rounded to nearest or cut: factor lies in [width - 1/2, width + 1).
  const double low = std::max((width - 0.5) / camera.width, (height - 0.5) / camera.height);
  const double high = std::min((width + 1.0) / camera.width, (height + 1.0) / camera.height);
  return low < high;
}

void scale(Camera& camera, int width, int height) {
  const double x = static_cast<double>(width) / camera.width, y = static_cast<double>(height) / camera.height;
  camera.fx *= x;
  camera.cx *= x;
  camera.fy *= y;
  camera.cy *= y;
  camera.width = width;
  camera.height = height;
}

}  // namespace

void fit_cameras(SceneFile& scene, const std::vector<bool>& needed) {
  std::vector<PhotoHeader> headers(scene.views.size());
  const std::vector<std::exception_ptr> errors =
      for_each_photo(scene.views, [&](std::size_t i) { headers[i] = read_photo_header(scene.views[i].photo); });
  std::size_t scaled = 0;
  std::string example;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    View& view = scene.views[i];
    if (errors[i]) try {
        std::rethrow_exception(errors[i]);
      } catch (const InputError& error) {
        forget_photo(scene, i, needed[i], BadPhoto::Problem::unreadable, reason_of(error, view.photo));
      }
    if (view.photo.empty()) continue;
    const auto [width, height] = headers[i].size;
    view.exposure_value = headers[i].exposure_value;
    Camera& camera = view.camera;
    if (camera.width == 0) {
      scene.size_camera(camera, width, height);
      camera.width = width;
      camera.height = height;
      finish_camera(scene.listing, "image '" + view.name + "'", camera);
    } else if (width != camera.width || height != camera.height) {
      const std::string differs = "is " + size_text(width, height) + " pixels, its camera in " +
                                  folder_of(scene.listing).string() + " is calibrated for " +
                                  size_text(camera.width, camera.height);
      if (!same_shape(width, height, camera)) {
        const bool turned = same_shape(height, width, camera);
        forget_photo(scene, i, needed[i], turned ? BadPhoto::Problem::turned : BadPhoto::Problem::other_shape, differs);
        continue;
      }
      if (scaled++ == 0) example = view.name + " " + differs;
      scale(camera, width, height);
    }
  }
  if (scaled > 0)
    scene.warnings.push_back("the cameras of " + std::to_string(scaled) +
                             " photos were scaled to the photos' size: " + example);
}

}  // namespace gpvc::io
