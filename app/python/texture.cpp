#include "app/python/texture.h"

#include <fmt/format.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "app/checks/input.h"
#include "app/evaluate/scene_json.h"
#include "app/pipeline/given_layout.h"
#include "app/pipeline/web_model.h"
#include "app/python/options.h"
#include "app/python/run_observer.h"
#include "app/python/save.h"
#include "app/python/uv.h"

namespace gpvc::python {
namespace {

using Result = std::shared_ptr<TextureResult>;

struct TextureRequest {
  PhotoScene photos;
  Result result;  ///< with what is to be textured
  std::string mesh_crs;
  int threads = 0;
  std::shared_ptr<const MeshUv> uv;  ///< that the mesh has; null: it gets new ones
  bool sizes_pages = false;          ///< the page size of the settings counts, whatever size its pages have
};

void run(const TextureRequest& request, RunObserver& observer) {
  std::optional<tbb::global_control> limit;
  if (request.threads > 0)
    limit.emplace(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(request.threads));
  TextureResult& result = *request.result;
  observer.begin({"read"});
  checks::prepare(result.scene, result.mesh, result.views, {TextureResult::kMeshName, request.mesh_crs}, observer);
  observer.end("");
  result.settings = pipeline::with_target(result.settings, result.mesh.faces.size(), request.uv != nullptr);
  if (request.uv != nullptr)
    result.layout =
        io::lay_out(request.uv->stated, {result.settings.atlas.page_size, !request.sizes_pages}, request.uv->name);
  const std::unique_ptr<io::PhotoSource> photos = request.photos.photos(result.scene);
  const pipeline::Input input = result.input();
  result.textured = pipeline::texture({input, result.settings, *photos, observer});
  const io::PhotoDecodes decodes = photos->decodes();
  observer.figure("decodes.photos", decodes.photos);
  observer.figure("decodes.all", decodes.times);
  auto report = evaluate::Json::parse(observer.json());
  report["device"] = evaluate::device_json(result.textured.device);
  result.report = evaluate::json_text(report);
}

// (faces, views, allow, name): ascending face numbers, numbers of views.
using Rule = std::tuple<std::vector<std::uint32_t>, std::vector<std::uint32_t>, bool, std::string>;

pipeline::ViewRule rule_from(const Rule& stated) {
  const auto& [faces, views, allow, name] = stated;
  io::FaceRegion region;
  for (const std::uint32_t face : faces) {
    if (region.ranges.empty() || region.ranges.back()[1] + 1 != face)
      region.ranges.push_back({face, face});
    else
      region.ranges.back()[1] = face;
  }
  pipeline::ViewRule rule{std::move(region), allow, {}, name};
  for (const std::uint32_t view : views) rule.views.push_back(ViewId{view});
  return rule;
}

Result texture(const PhotoScene& photos, const py::array_t<double, py::array::c_style>& vertices,
               const py::array_t<std::uint32_t, py::array::c_style>& faces, const std::vector<std::uint32_t>& views,
               const py::dict& options, const std::string& mesh_crs, int threads, int device,
               std::shared_ptr<const MeshUv> uv, const std::vector<Rule>& rules, py::object progress) {
  std::vector<ViewId> used;
  for (const std::uint32_t view : views) used.push_back(ViewId{view});
  TextureRequest request{photos,
                         std::make_shared<TextureResult>(TextureResult{*photos.scene, mesh_from(vertices, faces),
                                                                       std::move(used), settings_from(options)}),
                         mesh_crs,
                         threads,
                         std::move(uv),
                         options.contains("page_size")};
  request.result->settings.device = device;
  for (const Rule& rule : rules) request.result->settings.view_rules.push_back(rule_from(rule));
  const CancelFlag cancelled = cancel_flag();
  const auto observer = std::make_shared<RunObserver>(cancelled, std::move(progress));
  Worker().call([=] { run(request, *observer); }, cancelled);
  return request.result;
}

// (F, 3, 2)
py::array_t<float> texture_coordinates(const TextureResult& result) {
  const io::TexturedModel& model = result.textured.atlas.model;
  const std::size_t faces = model.face_page.size();
  py::array_t<float> uv({static_cast<py::ssize_t>(faces), py::ssize_t{3}, py::ssize_t{2}});
  float* to = uv.mutable_data();
  for (std::size_t face = 0; face < faces; ++face)
    for (const std::uint32_t corner : model.face_texcoords[face]) {
      const bool has_page = model.face_page[face] != io::kNoPage;
      const io::TexCoord at = has_page ? model.texcoords[corner] : io::TexCoord{};
      *to++ = at.u;
      *to++ = at.v;
    }
  return uv;
}

py::list pages(const Result& result) {
  py::list all;
  for (const Image& page : result->textured.atlas.pages)
    all.append(read_only_array(std::as_const(page).pixels.data(), {page.height, page.width, page.channels}, result));
  return all;
}

template <typename Sample>
py::object samples_array(const Samples& samples, const Result& keeper) {
  return read_only_array(reinterpret_cast<const Sample*>(samples.bytes.data()),
                         {samples.height, samples.width, static_cast<py::ssize_t>(samples.bands)}, keeper);
}

// None where photos have no bands.
py::list samples(const Result& result) {
  py::list all;
  for (const atlas::PageSamples& page : result->textured.atlas.samples) {
    const Samples& samples = page.samples;
    all.append(samples.type == SampleType::u8    ? samples_array<std::uint8_t>(samples, result)
               : samples.type == SampleType::u16 ? samples_array<std::uint16_t>(samples, result)
                                                 : samples_array<float>(samples, result));
  }
  return all;
}

template <typename To, typename From>
py::array_t<To> per_face(const std::vector<From>& values) {
  py::array_t<To> array(static_cast<py::ssize_t>(values.size()));
  std::ranges::transform(values, array.mutable_data(), [](From value) { return static_cast<To>(value); });
  return array;
}

}  // namespace

Mesh mesh_from(const py::array_t<double, py::array::c_style>& vertices,
               const py::array_t<std::uint32_t, py::array::c_style>& faces) {
  Mesh mesh;
  const auto count = static_cast<std::size_t>(vertices.shape(0));
  mesh.positions.resize(count);
  std::copy_n(vertices.data(), 3 * count, &mesh.positions.data()->x);
  mesh.faces.resize(static_cast<std::size_t>(faces.shape(0)));
  std::copy_n(faces.data(), 3 * mesh.faces.size(), mesh.faces.data()->data());
  return mesh;
}

void bind_texture(py::module_& module) {
  py::class_<TextureResult, Result>(module, "Result")
      .def("uv", &texture_coordinates)
      .def("page",
           [](const TextureResult& result) { return per_face<std::int32_t>(result.textured.atlas.model.face_page); })
      .def("pages", &pages)
      .def("samples", &samples)
      .def("page_names",
           [](const TextureResult& result) {
             py::list names;
             for (std::size_t n = 0; n < result.textured.atlas.pages.size(); ++n)
               names.append(pipeline::page_suffix(result.input(), n));
             return names;
           })
      .def("labels",
           [](const TextureResult& result) { return per_face<std::int32_t>(result.textured.selection.labels); })
      .def("tags", [](const TextureResult& result) { return per_face<std::uint8_t>(result.textured.tags); })
      .def_property_readonly("views", [](const TextureResult& result) { return result.scene.views.size(); })
      .def_readonly("report", &TextureResult::report)
      .def("save", [](const Result& result, const std::string& path) -> py::object {
        const CancelFlag cancelled = cancel_flag();
        const auto observer = std::make_shared<RunObserver>(cancelled, py::none());
        Worker().call([=] { save(*result, path, *observer); }, cancelled);
        return py::module_::import("json").attr("loads")(observer->json())["warnings"];
      });
  module.def("texture", &texture);
  module.def("texture_options", &texture_options);
}

}  // namespace gpvc::python
