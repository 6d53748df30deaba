#include "app/evaluate.h"
#include "app/scene_input.h"

namespace gpvc {
namespace {

// The scene with only the views asked for.
Scene chosen_views(const Scene& scene, const SceneInput& input) {
  Scene chosen{scene.source, {}};
  for (const ViewId id : used_views(scene, input.views, "")) chosen.views.push_back(scene.views[index(id)]);
  return chosen;
}

}  // namespace

void run_evaluate(const EvaluateCommandOptions& options, Console& console) {
  RunRecord record;
  Stage stage(console, record, "evaluate", "views");
  const SceneOptions reader = options.input.reader_options();
  const Scene scene = chosen_views(read_scene(options.input.scene, reader), options.input);
  PhotoCache photos(scene, reader, 0);
  GraphicsDevice device(options.common.device);
  EvaluateOptions evaluate;
  evaluate.model = options.model;
  if (!options.input.mesh.empty()) evaluate.mesh = options.input.mesh;
  if (!options.out.empty()) evaluate.out = options.out;
  evaluate.reduction = options.reduction;
  const Evaluation evaluation = evaluate_model(device, scene, photos, evaluate, stage.reporter());
  stage.finish(std::to_string(scene.views.size()) + " views");
  console.result(evaluation_table(evaluation));
}

}  // namespace gpvc
