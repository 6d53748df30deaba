// A command's scene and meshes, and the options of run.json that describe them.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "app/cli/run_record.h"
#include "app/cli/view_lists.h"
#include "app/evaluate/scene_json.h"

namespace gpvc::cli {

/// One of the meshes given: a range of the faces and vertices of all.
struct MeshPart {
  std::filesystem::path file;
  std::size_t first_face = 0, faces = 0, first_vertex = 0, vertices = 0;
};

struct SceneInputData {
  Mesh mesh;                    ///< all meshes, one after the other
  std::vector<MeshPart> parts;  ///< in the order given
  Scene scene;
  std::vector<ViewId> used;      ///< ascending; the views --views, --exclude-views and --hold-out leave
  std::vector<ViewId> held_out;  ///< ascending
  /// Borrows this struct.
  checks::Input input() const { return {scene, mesh, used, parts.front().file}; }
};

/// Cheap looks before dear ones. Throws InputError where scene or mesh is not there, or a mesh is in the scene's place.
/// \param order of the command's arguments
void check_places(const SceneInput& input, const char* order = "SCENE comes first, then MESH");

/// Reads the scene; photos must be there for the views that --views and --exclude-views leave, which become `used`; with
/// --skip-bad-photos, bad ones are left out of them. Throws InputError, UsageError.
Scene read_views(const SceneInput& input, std::vector<ViewId>& used, bool allow_missing_photos = false);

/// Reads meshes and scene at the same time, resolves the view lists and checks that cameras and mesh fit together. Throws
/// InputError, UsageError.
SceneInputData read_scene_input(const SceneInput& input, RunRecord& record);

checks::MeshOrigin origin_of(const SceneInput& input);

/// The rules of a file about photos, which is among the files read from then on; none without one. Throws InputError.
std::vector<pipeline::ViewRule> rules_of(const std::filesystem::path& allow, const SceneInputData& data,
                                         std::set<std::filesystem::path>& read);

Json scene_json(const SceneInput& input);
/// The faces and vertices of each mesh.
Json meshes_json(const SceneInputData& input);

inline bool has_mask(const View& view) { return !view.mask.empty() || view.uses_alpha; }

/// The files a scene was read from: its own files, photos and masks, as canonical paths.
std::set<std::filesystem::path> input_files(const Scene& scene);
/// The same with the meshes.
std::set<std::filesystem::path> input_files(const SceneInputData& input);

/// Throws OutputError when a file that OUT will hold under `names` is the input mesh.
void refuse_overwriting(const SceneInput& input, const std::filesystem::path& out,
                        const std::vector<std::string>& names);

}  // namespace gpvc::cli
