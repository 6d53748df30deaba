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
#include "../../visibility/result.h"
#include "../checks/mesh_fit.h"
#include "layers.h"
#include "memory.h"
#include "run.h"
#include "settings.h"
#include "view_rules.h"
#include "viewpoint.h"
#include "web_model.h"

namespace gpvc::pipeline {

using checks::MeshFit;

// --- all steps

struct TexturedMesh {
  labeling::Selection selection;                   ///< with the view of each face
  std::vector<labeling::FaceTag> tags;             ///< per face
  atlas::TextureAtlas atlas;                       ///< pages and model; borrows the mesh
  std::optional<visibility::DeviceInfo> device{};  ///< that drew the views; empty: they were drawn natively
};

/// Brings mesh and cameras into the same coordinates (checks::prepare()), changing both, and textures the mesh from all views.
/// Throws InputError, GpuError, MemoryError, and what photos and observer throw.
TexturedMesh texture(Scene& scene, Mesh& mesh, const Settings& settings, io::PhotoSource& photos, Observer& observer);

/// Textures an input that checks::prepare() accepts. Coarse photos are kept in a file without a name, in the folder for temporary
/// files.
TexturedMesh texture(const Run& run);

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

struct SeeOptions {
  /// Faces that get candidates, ascending; empty: all. All faces of the mesh occlude and enter the outlier test and the
  /// scale of the costs, so that the candidates are those of a run over all faces. The border that plan() and bake() are
  /// given belongs to them.
  std::span<const FaceId> faces = {};
  const labeling::FaceGraph* graph = nullptr;  ///< of the mesh; null: made where it is needed
  /// Called for each view once it is classified, on the caller's thread; not for views that the run has kept.
  std::function<void(ViewId, const visibility::ViewVisibility&)> on_view = {};
  /// Called once all views are looked at, before they are judged. \param held bytes of what is known of them and, at most, of judging
  std::function<void(double held)> on_looked = {};
  /// Photos, poses and mesh are known to fit together: nothing is refused.
  bool judged = false;
};

/// Visibility and candidates, view after view: while one is drawn, its photo is decoded and the costs of the view before are
/// computed. Throws InputError if no view sees any face or photos, poses and mesh do not fit together, GpuError.
Seen see(const Run& run, const SeeOptions& options = {});

/// Notes how the candidates see the faces. Throws InputError if no view sees any.
void report_tags(const Input& input, const labeling::Candidates& candidates, Observer& observer);

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

/// Writes the result into the folder: model.obj, model.mtl, pages, model.glb or its parts, preview.png, labels.npy,
/// tags.npy, faces.npy and, where they are needed, offset.txt and source_faces.npy. Pages and models are written on other
/// threads while the preview is drawn. Models hold no face of a border; model.obj keeps its vertices, and labels.npy and
/// tags.npy its entries. Throws OutputError.
WrittenModel write(const Run& run, const TexturedMesh& textured, OutputFolder& folder);
/// The same of a mesh textured from all views, into a folder that holds no result yet.
WrittenModel write(const Scene& scene, const Mesh& mesh, const TexturedMesh& textured, const Settings& settings,
                   const std::filesystem::path& out, Observer& observer);

/// A textured mesh whose files are written.
struct TexturedFiles {
  TexturedMesh textured;  ///< without pages
  WrittenModel written;
};

/// texture() and write() in one, with the same files, for models of any size: pages are written and let go as soon as they
/// are finished, and model.obj is written while photos are baked. See Settings::keep_work for what is kept in the folder. Layers are
/// baked onto the same pages (bake_layers()).
TexturedFiles texture_into(const Run& run, OutputFolder& folder, std::span<const LayerPhotos> layers = {});

/// The result of texture_into() with other Settings::view_rules, made from an editable one in the folder `from`: no view is
/// looked at for visibility again. Faces whose candidates change, and those around them whose label may (see
/// labeling::reselect_views), are solved again; faces with other candidates or another label get new charts on new pages,
/// leveled against the others, which keep their places on their pages, copied byte for byte. The result is editable in turn,
/// and may replace the one in `from`. Throws InputError where `from` holds no editable result of this mesh, these views and
/// settings. O(faces + records) and what the new charts take.
TexturedFiles retexture_into(const std::filesystem::path& from, const Run& run, OutputFolder& folder,
                             std::span<const LayerPhotos> layers = {});

}  // namespace gpvc::pipeline
