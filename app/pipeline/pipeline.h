// Textures a mesh from calibrated photos. texture() does all of it; see(), choose(), plan(), bake() and write() are its
// steps, for callers who need one of them alone or who work on a part of the faces and views. Nothing here prints or parses
// options: progress, messages and figures go to an Observer.
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "../../atlas/atlas.h"
#include "../../io/names.h"
#include "../../io/photos.h"
#include "../../io/textured_model.h"
#include "../../labeling/labeling.h"
#include "../../visibility/device.h"
#include "../../visibility/method.h"
#include "../../visibility/result.h"
#include "../checks/input.h"
#include "../checks/mesh_fit.h"
#include "../results/observer.h"
#include "../results/output_folder.h"
#include "memory.h"
#include "view_rules.h"
#include "viewpoint.h"

namespace gpvc::pipeline {

using checks::all_views;
using checks::Input;
using checks::MeshFit;
using results::Observer;
using results::OutputFolder;

struct OutputSettings {
  io::ImageFormat texture = io::ImageFormat::jpg;
  int quality = 95;  ///< of JPEG pages
  io::GltfContainer gltf = io::GltfContainer::glb;
  bool normals = false;
  std::optional<io::UpAxis> up;  ///< nullopt: found from the cameras
};

/// Whether texture_into() keeps its work in the output folder until the result is complete, so that it can go on from there
/// after it was cut off. automatic: if it is expected to take more than a minute, or an earlier run has kept some.
enum class KeepWork { automatic, always, never };
inline constexpr Named<KeepWork> kKeepWorkNames[] = {
    {"auto", KeepWork::automatic}, {"always", KeepWork::always}, {"never", KeepWork::never}};

/// Of the faces of a mesh: one of which photos see less lies in other coordinates, as a rule.
inline constexpr double kLeastSeen = 0.05;

struct Settings {
  visibility::VisibilityOptions visibility;
  int device = -1;  ///< number of the graphics device to use; -1: see visibility::find_device()
  labeling::CostOptions costs;
  bool allow_unseen = false;              ///< texture a mesh of which photos see less than kLeastSeen
  std::vector<ViewRule> view_rules = {};  ///< faces in their regions lose the views that they refuse
  labeling::EdgeWeights edge_weights = labeling::EdgeWeights::uniform;
  labeling::SolverOptions solver;
  atlas::AtlasOptions atlas;
  OutputSettings output;
  /// Most bytes that texture() and texture_into() take; 0: see plan_memory(). Results are the same for any value.
  std::size_t memory_bytes = 0;
  KeepWork keep_work = KeepWork::automatic;
  /// texture_into() also writes what retexture_into() needs to change the result (edit_files.h).
  bool editable = false;
};

// --- all steps

struct TexturedMesh {
  labeling::Selection selection;                   ///< with the view of each face
  std::vector<labeling::FaceTag> tags;             ///< per face
  atlas::TextureAtlas atlas;                       ///< pages and model; borrows the mesh
  std::optional<visibility::DeviceInfo> device{};  ///< that drew the views; empty: they were drawn natively
};

/// Checks the input and textures it from all views. Throws InputError, GpuError, and what photos and observer throw.
TexturedMesh texture(const Scene& scene, const Mesh& mesh, const Settings& settings, io::PhotoSource& photos,
                     Observer& observer);

/// Textures an input that check_input() accepts. Throws MemoryError as well.
TexturedMesh texture(const Input& input, const Settings& settings, io::PhotoSource& photos, Observer& observer);

// --- the steps

/// Pairs of adjacent faces, each with the weight of a seam between the two.
labeling::FaceGraph weighed_graph(const Mesh& mesh, labeling::EdgeWeights weights, Observer& observer);

struct Seen {
  labeling::Candidates candidates;
  visibility::CoverageTable coverage;           ///< of faces tagged partial
  visibility::VisibilityStatistics statistics;  ///< over all views
  double costs_s = 0;
  MeshFit fit;                                     ///< to the photos
  MeshFit tie_point_fit;                           ///< to the scene's tie points, where it has any
  std::optional<visibility::DeviceInfo> device{};  ///< that drew the views; empty: they were drawn natively
};

class CoverageStore;  // coverage_store.h
class KeptWork;       // kept_work.h

struct SeeOptions {
  /// Faces that get candidates, ascending; empty: all. All faces of the mesh occlude and enter the outlier test and the
  /// scale of the costs, so that the candidates are those of a run over all faces. The border that plan() and bake() are
  /// given belongs to them.
  std::span<const FaceId> faces = {};
  const labeling::FaceGraph* graph = nullptr;  ///< of the mesh; null: made where it is needed
  /// Called for each view once it is classified, on the caller's thread.
  std::function<void(ViewId, const visibility::ViewVisibility&)> on_view = {};
  /// Called once all photos are compared with each other, before rules about them are applied.
  std::function<void(const labeling::CandidateCollector&, const CoverageStore&)> on_judged = {};
  KeptWork* kept = nullptr;  ///< by earlier runs and for later ones; on_view is not called for views taken from it
};

/// Visibility and candidates, view after view: while one is drawn, its photo is decoded and the costs of the view before are
/// computed. Throws InputError if no view sees any face, GpuError.
Seen see(const Input& input, const Settings& settings, io::PhotoSource& photos, Observer& observer,
         const SeeOptions& options = {});

/// Notes how the candidates see the faces. Throws InputError if no view sees any.
void report_tags(const Input& input, const labeling::Candidates& candidates, Observer& observer);

/// The numbers of faces tagged seen, partial and unseen.
std::array<std::size_t, 3> count_tags(std::span<const labeling::FaceTag> tags);

/// Chooses one view per face. `fixed`: empty, or per face the view that it must keep, kNoView where one is to be chosen.
labeling::Selection choose(const labeling::CostTable& costs, const labeling::FaceGraph& graph,
                           const labeling::SolverOptions& options, Observer& observer,
                           std::span<const ViewId> fixed = {});

/// The input of plan() and bake(), from the results of see() and choose(). Borrows everything. To texture a part of the
/// faces, set its `border` (and `exposure`, so that parts agree in brightness): see atlas::AtlasInput.
atlas::AtlasInput atlas_input(const Input& input, io::PhotoSource& photos, const labeling::FaceGraph& graph,
                              const Seen& seen, std::span<const ViewId> labels);

/// Places charts on pages and notes how many pages and texels they take. Reads no photo.
atlas::AtlasPlan plan(const atlas::AtlasInput& input, const atlas::AtlasOptions& options, Observer& observer);

/// Levels the seams and bakes the pages of a plan. \pre input and options are those of the plan
atlas::TextureAtlas bake(const atlas::AtlasPlan& plan, const atlas::AtlasInput& input,
                         const atlas::AtlasOptions& options, Observer& observer);

/// plan() and bake(), reported as one stage.
atlas::TextureAtlas make_atlas(const atlas::AtlasInput& input, const atlas::AtlasOptions& options, Observer& observer);

/// What write() chose for the files.
struct WrittenModel {
  Viewpoint preview;  ///< of preview.png
  std::array<std::uint8_t, 3> background{};
  io::UpAxis up{};
  WorldPoint offset;  ///< to be added to the model's coordinates
};

/// Writes the result into the folder: model.obj, model.mtl, pages, model.glb or its parts, preview.png, labels.npy,
/// tags.npy, faces.npy and, where they are needed, offset.txt and source_faces.npy. Pages and models are written on other
/// threads while the preview is drawn. Models hold no face of a border; model.obj keeps its vertices, and labels.npy and
/// tags.npy its entries. Throws OutputError.
WrittenModel write(const Input& input, const TexturedMesh& textured, const Settings& settings, OutputFolder& folder,
                   Observer& observer);

/// A textured mesh whose files are written.
struct TexturedFiles {
  TexturedMesh textured;  ///< without pages
  WrittenModel written;
};

/// texture() and write() in one, with the same files, for models of any size: pages are written and let go as soon as they
/// are finished, and model.obj is written while photos are baked. See Settings::keep_work for what is kept in the folder.
TexturedFiles texture_into(const Input& input, const Settings& settings, io::PhotoSource& photos, OutputFolder& folder,
                           Observer& observer);

/// The result of texture_into() with other Settings::view_rules, made from an editable one in the folder `from`: no view is
/// looked at for visibility again. Faces whose candidates change, and those around them whose label may (see
/// labeling::reselect_views), are solved again; faces with other candidates or another label get new charts on new pages,
/// leveled against the others, which keep their places on their pages, copied byte for byte. The result is editable in turn,
/// and may replace the one in `from`. Throws InputError where `from` holds no editable result of this mesh, these views and
/// settings. O(faces + records) and what the new charts take.
TexturedFiles retexture_into(const std::filesystem::path& from, const Input& input, const Settings& settings,
                             io::PhotoSource& photos, OutputFolder& folder, Observer& observer);

}  // namespace gpvc::pipeline
