#include "app/python/coverage.h"

#include <cstdint>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <utility>

#include "app/python/options.h"
#include "app/python/run_observer.h"
#include "app/python/texture.h"
#include "app/query/coverage.h"

namespace gpvc::python {
namespace {

// Of pictures in memory what they exclude alone, which takes no picture where a mask tells it.
class ExcludedPixels final : public io::PhotoSource {
 public:
  explicit ExcludedPixels(std::shared_ptr<const py::object> pictures) : pictures_(std::move(pictures)) {}
  std::shared_ptr<const Image> photo(ViewId /*view*/) override { throw std::logic_error("coverage takes no photo"); }
  std::shared_ptr<const io::PhotoExclusion> exclusion(ViewId view) override {
    const py::gil_scoped_acquire lock;
    auto excluded = exclusion_from(pictures_->attr("excluded")(index(view)));
    return excluded ? std::make_shared<const io::PhotoExclusion>(*std::move(excluded)) : nullptr;
  }

 private:
  std::shared_ptr<const py::object> pictures_;
};

struct CoverageRequest {
  PhotoScene photos;
  Scene scene;
  Mesh mesh;
  std::string mesh_crs;
  pipeline::Settings settings;
};

query::FaceCoverage cover(CoverageRequest& request, RunObserver& observer) {
  const std::vector<ViewId> views = all_views(request.scene);
  const std::unique_ptr<io::PhotoSource> photos = request.photos.pictures->is_none()
                                                      ? request.photos.photos(request.scene)
                                                      : std::make_unique<ExcludedPixels>(request.photos.pictures);
  checks::prepare(request.scene, request.mesh, views, {TextureResult::kMeshName, request.mesh_crs}, observer);
  const pipeline::Input input{request.scene, request.mesh, views, TextureResult::kMeshName};
  return query::cover_faces({input, request.settings, *photos, observer});
}

// Photos, ground sampling distance and angle of each face, and warnings.
py::tuple coverage(const PhotoScene& photos, const py::array_t<double, py::array::c_style>& vertices,
                   const py::array_t<std::uint32_t, py::array::c_style>& faces, const py::dict& options,
                   const std::string& mesh_crs, int device, py::object progress) {
  const auto request = std::make_shared<CoverageRequest>(
      CoverageRequest{photos, *photos.scene, mesh_from(vertices, faces), mesh_crs, {}});
  request->settings.visibility = visibility_options_from(options);
  request->settings.device = device;
  const CancelFlag cancelled = cancel_flag();
  const auto observer = std::make_shared<RunObserver>(cancelled, std::move(progress));
  const auto found = std::make_shared<query::FaceCoverage>();
  Worker().call([=] { *found = cover(*request, *observer); }, cancelled);
  const auto count = static_cast<py::ssize_t>(found->photos.size());
  return py::make_tuple(array_over<std::uint32_t>(std::move(found->photos), {count}),
                        array_over<float>(std::move(found->gsd), {count}),
                        array_over<float>(std::move(found->angle), {count}),
                        py::module_::import("json").attr("loads")(observer->json())["warnings"]);
}

}  // namespace

void bind_coverage(py::module_& module) { module.def("coverage", &coverage); }

}  // namespace gpvc::python
