// What the commands share about their input and about what they write of it.
#pragma once

#include <functional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "app/cli/options.h"
#include "app/cli/run_record.h"
#include "app/pipeline/output_folder.h"

namespace gpvc::cli {

/// One of the meshes given: a run of the faces and vertices of all.
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
};

/// Reads meshes and scene at the same time and resolves the view lists. Throws InputError, UsageError.
SceneInputData read_scene_input(const SceneInput& input, Console& console, RunRecord& record);

/// Which views LISTs of names and globs, or @FILE, leave; a name may lack its extension where one view alone has it
/// without. Throws UsageError for an entry that matches none, with the names that come near, and for a name without
/// extension that two views have.
std::vector<ViewId> used_views(std::span<const View> all, const std::string& views, const std::string& exclude_views);

/// For SceneOptions::needed: those of used_views.
std::function<std::vector<bool>(std::span<const View>)> needs_used_views(std::string views, std::string exclude_views);

/// Which of `used` a --hold-out names: every K-th (the K-th, the 2 K-th, ...) for a whole number from 2, else names and
/// globs. Throws UsageError for names among none of them, and when nothing would be left.
std::vector<ViewId> held_out_views(const Scene& scene, std::span<const ViewId> used, const std::string& hold_out);

/// Names of the views that the views.json beside a model marks with `mark` ("held_out", "used"); empty where there is
/// no such file.
std::vector<std::string> marked_views(const std::filesystem::path& model, const std::string& mark);

/// views.json: every view in order, with `used` and `held_out`.
void write_views_json(const std::filesystem::path& file, const SceneInputData& input);

struct RunFacts {
  std::string command;
  const CommonOptions& common;
  Json options = Json::object();
  Json device = Json::object();
};

/// run.json; to be called last, as it lists what was promised and what was spent. Promises itself.
void write_run_json(pipeline::OutputFolder& folder, const RunFacts& facts, const RunRecord& record);

Json device_json(const visibility::DeviceInfo& device);
Json visibility_json(const visibility::VisibilityOptions& options);
Json scene_json(const SceneInput& input);
/// For run.json: which faces and vertices are whose.
Json meshes_json(const SceneInputData& input);

/// What a scene was read from: its own files, photos and masks, as canonical paths.
std::set<std::filesystem::path> input_files(const Scene& scene);
/// The same with the meshes.
std::set<std::filesystem::path> input_files(const SceneInputData& input);

/// Throws OutputError when a file that OUT will hold under `names` is one of the inputs.
void refuse_overwriting(const SceneInput& input, const std::filesystem::path& out,
                        const std::vector<std::string>& names);

/// A whole text as a file.
void write_text_file(const std::filesystem::path& file, const std::string& text);

}  // namespace gpvc::cli
