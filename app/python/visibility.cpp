#include "app/python/visibility.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "app/checks/input.h"
#include "app/python/options.h"
#include "app/python/run_observer.h"
#include "app/python/texture.h"
#include "visibility/device.h"
#include "visibility/visibility.h"

namespace gpvc::python {
namespace {

// The face at the frame's pixel that each pixel of the photo shows.
std::vector<FaceId> faces_of_photo(const Camera& camera, const visibility::Ivm& frame) {
  std::vector<FaceId> faces(pixel_index(0, camera.height, camera.width), kNoFace);
  tbb::parallel_for(0, camera.height, [&](int y) {
    for (int x = 0; x < camera.width; ++x) {
      const std::optional<PixelPoint> at = pixel_from_photo(camera, {x + 0.5, y + 0.5});
      if (at && at->x >= 0 && at->y >= 0 && at->x < frame.width && at->y < frame.height)
        faces[pixel_index(x, y, camera.width)] = frame.at(static_cast<int>(at->x), static_cast<int>(at->y));
    }
  });
  return faces;
}

// A mesh before the cameras of a scene, on a thread of its own, to which its device belongs.
class ViewClasses {
 public:
  ViewClasses(const PhotoScene& photos, const py::array_t<double, py::array::c_style>& vertices,
              const py::array_t<std::uint32_t, py::array::c_style>& faces, const py::dict& options,
              const std::string& mesh_crs, int device)
      : photos_(photos), stage_(std::make_shared<Stage>()) {
    stage_->scene = *photos.scene;
    stage_->mesh = mesh_from(vertices, faces);
    const CancelFlag cancelled = cancel_flag();
    const auto observer = std::make_shared<RunObserver>(cancelled, py::none());
    worker_.call(
        [stage = stage_, observer, mesh_crs, device, settings = visibility_options_from(options)] {
          checks::prepare(stage->scene, stage->mesh, all_views(stage->scene), {TextureResult::kMeshName, mesh_crs},
                          *observer);
          stage->photos = std::make_unique<io::PhotoCache>(stage->scene);
          stage->device = visibility::find_device(settings, device);
          stage->visibility.emplace(stage->mesh, settings, stage->device.get());
        },
        cancelled);
    warnings_ = py::module_::import("json").attr("loads")(observer->json())["warnings"];
  }
  ~ViewClasses() {
    worker_.post([stage = std::move(stage_)] { stage->end(); });
  }
  ViewClasses(const ViewClasses&) = delete;
  ViewClasses& operator=(const ViewClasses&) = delete;

  py::array_t<std::uint8_t> classes(std::uint32_t view) {
    auto seen = look(view);
    const auto faces = static_cast<py::ssize_t>(seen->classes.size());
    return array_over<std::uint8_t>(std::move(seen->classes), {faces});
  }
  // kNoFace becomes -1. In the pixels of the view's frame, or of its photo.
  py::array_t<std::int32_t> face_ids(std::uint32_t view, bool of_photo) {
    auto seen = look(view);
    const Camera& camera = stage_->scene.views[view].camera;
    if (of_photo && !camera.distortion.is_identity()) {
      const auto shown = std::make_shared<std::vector<FaceId>>();
      worker_.call([=] { *shown = faces_of_photo(camera, seen->ivm); }, cancel_flag());
      return array_over<std::int32_t>(std::move(*shown), {camera.height, camera.width});
    }
    return array_over<std::int32_t>(std::move(seen->ivm.faces), {seen->ivm.height, seen->ivm.width});
  }
  std::size_t views() const { return stage_->scene.views.size(); }
  const py::object& warnings() const { return warnings_; }

 private:
  struct Stage {
    Scene scene;
    Mesh mesh;
    std::unique_ptr<io::PhotoSource> photos;  // of files, for what they exclude
    std::unique_ptr<visibility::GraphicsDevice> device;
    std::optional<visibility::VisibilityStage> visibility;
    void end() {
      visibility.reset();
      device.reset();
    }
  };

  std::shared_ptr<visibility::ViewVisibility> look(std::uint32_t number) {
    std::optional<io::PhotoExclusion> excluded;
    const bool in_files = photos_.pictures->is_none();
    if (!in_files) excluded = exclusion_from(photos_.pictures->attr("excluded")(number));
    const auto seen = std::make_shared<visibility::ViewVisibility>();
    worker_.call(
        [=, stage = stage_]() mutable {
          const View& view = stage->scene.views.at(number);
          const auto in_file = in_files ? stage->photos->exclusion(ViewId{number}) : nullptr;
          stage->visibility->classify(view, ViewId{number}, excluded ? &*excluded : in_file.get(), *seen);
        },
        cancel_flag());
    return seen;
  }

  PhotoScene photos_;
  std::shared_ptr<Stage> stage_;
  py::object warnings_;
  Worker worker_;
};

}  // namespace

void bind_visibility(py::module_& module) {
  py::class_<ViewClasses>(module, "ViewClasses")
      .def(py::init<const PhotoScene&, const py::array_t<double, py::array::c_style>&,
                    const py::array_t<std::uint32_t, py::array::c_style>&, const py::dict&, const std::string&, int>())
      .def("classes", &ViewClasses::classes)
      .def("face_ids", &ViewClasses::face_ids)
      .def("__len__", &ViewClasses::views)
      .def_property_readonly("warnings", &ViewClasses::warnings);
  module.def("visibility_options", &visibility_options);
}

}  // namespace gpvc::python
