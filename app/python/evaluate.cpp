#include "app/evaluate/evaluate.h"

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/checks/mesh_frame.h"
#include "app/checks/nearness.h"
#include "app/python/evaluate.h"
#include "app/python/run_observer.h"
#include "app/python/texture.h"

namespace gpvc::python {
namespace {

struct EvaluateRequest {
  PhotoScene photos;
  std::vector<std::uint32_t> views;
  std::shared_ptr<const TextureResult> result;  // null: `file`
  std::string file, out;
  int reduction = 4;
};

// Of a result in memory. Its pages are borrowed.
io::LoadedModel loaded(const std::shared_ptr<const TextureResult>& result) {
  io::LoadedModel model;
  model.mesh = result->mesh;
  model.model = result->textured.atlas.model;
  for (const Image& page : result->textured.atlas.pages)
    model.pages.push_back({page.width, page.height, page.channels, Pixels::borrowed(page.pixels, result)});
  return model;
}

std::string evaluated(const EvaluateRequest& request, RunObserver& observer) {
  observer.begin({"evaluate", "views"});
  Scene scene = *request.photos.scene;
  io::LoadedModel model = request.result ? loaded(request.result) : evaluate::read_model_with_texture(request.file);
  model.model.mesh = &model.mesh;
  std::vector<View> compared;
  std::vector<ViewId> used;
  for (const std::uint32_t view : request.views) {
    compared.push_back(scene.views.at(view));
    if (request.result) {  // whose cameras may have been taken to the mesh's coordinates
      const View& textured = request.result->scene.views.at(view);
      compared.back().pose = textured.pose;
      compared.back().camera.distortion.motion.nearness = textured.camera.distortion.motion.nearness;
    }
    used.push_back(ViewId{static_cast<std::uint32_t>(used.size())});
  }
  scene.views = std::move(compared);
  if (!request.result) {
    const Remark placed = evaluate::place_model(request.file, {}, {}, used, scene, model);
    if (!placed.text.empty()) observer.warning(placed.text, placed.cures);
    checks::set_nearness(scene, model.mesh, model.offset);
  }
  const std::unique_ptr<io::PhotoSource> photos = request.photos.photos(scene, request.views);
  evaluate::EvaluateOptions options;
  options.model = request.result ? "model" : request.file;
  if (!request.out.empty()) options.out = request.out;
  options.reduction = request.reduction;
  const evaluate::Evaluation evaluation = evaluate::evaluate_model(scene, *photos, model, options, observer.reporter());
  observer.end("");
  auto report = evaluate::Json::parse(observer.json());
  report["mean"] = evaluate::score_json(evaluation.mean);
  report["views"] = evaluate::Json::object();
  for (const evaluate::ViewScore& view : evaluation.views)
    report["views"][view.view] = evaluate::score_json(view.score);
  return evaluate::json_text(report);
}

std::string score(const PhotoScene& photos, std::vector<std::uint32_t> views, std::shared_ptr<TextureResult> result,
                  std::string file, std::string out, int reduction, py::object progress) {
  const EvaluateRequest request{photos,          std::move(views), std::move(result),
                                std::move(file), std::move(out),   reduction};
  const CancelFlag cancelled = cancel_flag();
  const auto observer = std::make_shared<RunObserver>(cancelled, std::move(progress));
  const auto report = std::make_shared<std::string>();
  Worker().call([=] { *report = evaluated(request, *observer); }, cancelled);
  return *report;
}

}  // namespace

void bind_evaluate(py::module_& module) { module.def("evaluate", &score); }

}  // namespace gpvc::python
