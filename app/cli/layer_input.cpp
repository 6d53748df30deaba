#include "app/cli/layer_input.h"

#include <fmt/format.h>

#include <set>
#include <utility>

#include "app/cli/band_notes.h"

namespace gpvc::cli {
namespace {

namespace fs = std::filesystem;

// Of "DIR/", "." and the like, too.
std::string name_of_folder(const fs::path& folder) {
  std::error_code ignored;
  fs::path whole = fs::weakly_canonical(folder, ignored);
  if (!whole.has_filename()) whole = whole.parent_path();
  return whole.filename().string();
}

Scene read_layer(const std::string& name, const fs::path& folder, const SceneInput& input, const SceneInputData& data) {
  SceneInput other = input;
  other.images_dir = folder;
  other.bands.clear();  // those of the model's photos
  other.composite.clear();
  std::vector<ViewId> used;
  Scene scene = read_views(other, used);
  pipeline::check_layer(data.input(), name, scene);
  // Those of the scene may have been brought to the mesh's coordinates.
  for (std::size_t v = 0; v < scene.views.size(); ++v) {
    scene.views[v].camera = data.scene.views[v].camera;
    scene.views[v].pose = data.scene.views[v].pose;
  }
  return scene;
}

}  // namespace

std::vector<LayerInput> read_layers(const std::vector<fs::path>& folders, const SceneInput& input,
                                    const SceneInputData& data, RunRecord& record) {
  std::set<std::string> names;
  std::vector<LayerInput> layers;
  for (const fs::path& folder : folders) {
    if (!fs::is_directory(folder)) throw InputError(folder, "", "is no folder of photos, expected one for each layer");
    if (const std::string name = name_of_folder(folder); !names.insert(name).second)
      throw UsageError(fmt::format("--layers: two folders are called {}, expected names that differ", name));
  }
  for (const fs::path& folder : folders) {
    const std::string name = name_of_folder(folder);
    layers.push_back({name, read_layer(name, folder, input, data)});
    if (layers.back().scene.bands)
      for (const std::string& note : band_notes(layers.back().scene)) record.note(fmt::format("{}: {}", name, note));
  }
  return layers;
}

}  // namespace gpvc::cli
