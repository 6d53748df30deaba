// The options of each command, with their defaults.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/cli/console.h"
#include "app/compare/compare_settings.h"
#include "app/ortho/ortho_settings.h"
#include "app/pipeline/pipeline.h"
#include "app/pipeline/undistort.h"
#include "app/query/coverage.h"
#include "app/synth/band_photos.h"
#include "app/synth/city.h"
#include "app/tiles/make_job.h"
#include "app/tileset/tileset.h"
#include "io/names.h"
#include "io/scene_files.h"
#include "io/textured_model.h"
#include "visibility/method.h"

namespace gpvc::cli {

struct CommonOptions {
  int threads = 0;  ///< 0: all
  int device = -1;  ///< of list_devices(); -1: the first
  std::filesystem::path log;
  bool quiet = false, verbose = false;
  std::vector<std::string> command_line;  ///< as given, for run.json
  std::vector<std::string> notes;         ///< of the parser, to be shown when the command starts
  Loudness loudness() const { return quiet ? Loudness::quiet : verbose ? Loudness::verbose : Loudness::normal; }
};

/// Options of every command that writes a result.
struct CommandOptions {
  CommonOptions common;
  std::filesystem::path out;
  bool force = false;
};

inline constexpr int kPreviewReduction = 4, kPreviewPhotosOfPlace = 3;

struct SceneInput {
  std::filesystem::path scene, mesh;
  std::vector<std::filesystem::path> more_meshes;  ///< follow `mesh`, their faces after its faces
  std::optional<std::filesystem::path> images_dir;
  std::string views, exclude_views;  ///< lists as given; empty: all, none
  std::string hold_out;              ///< a number (every so many views) or a list
  int downscale = 1;
  bool preview = false;  ///< of fewer photos, smaller ones unless `downscale` says how much
  std::optional<std::filesystem::path> masks_dir;
  bool masks = true;
  std::vector<io::BandFolder> bands;  ///< with a folder for each; empty: by the files' names, if at all
  bool bands_by_name = true;
  std::vector<std::string> composite;  ///< names or numbers of bands; empty: by their names
  bool skip_bad_photos = false;
  bool whole_fisheyes = false;   ///< one view for each photo, see io::SceneOptions
  bool bands_as_listed = false;  ///< see there
  std::string mesh_crs;          ///< reference system of the meshes; empty: found, if it is not the scene's
  int reduction() const { return preview && downscale == 1 ? kPreviewReduction : downscale; }
  io::SceneOptions reader_options() const {
    return {.images_dir = images_dir,
            .skip_bad_photos = skip_bad_photos,
            .downscale = reduction(),
            .masks_dir = masks_dir,
            .masks = masks,
            .bands = bands,
            .bands_by_name = bands_by_name,
            .composite = composite,
            .whole_fisheyes = whole_fisheyes,
            .bands_as_listed = bands_as_listed};
  }
};

struct TextureOptions : CommandOptions {
  SceneInput input;
  std::filesystem::path allow;                ///< rules about photos; empty: none
  std::filesystem::path from;                 ///< an earlier result to change; empty: none
  bool keep_uv = false;                       ///< bake onto the mesh's own texture coordinates
  bool sizes_pages = false;                   ///< a page size is given
  std::vector<std::filesystem::path> layers;  ///< folders of further photos for the same pages
  bool level_layers = false;
  pipeline::Settings settings;
};

struct TilesetOptions : CommandOptions {
  SceneInput input;
  std::filesystem::path allow;
  pipeline::Settings settings;
  tileset::TilesetSettings tiles;
};

struct OrthoCommandOptions : CommandOptions {
  SceneInput input;  ///< empty scene and mesh: all is taken from `from`
  std::filesystem::path allow;
  std::filesystem::path from;  ///< a textured model, or the folder of a result; empty: the scene is textured
  pipeline::Settings settings;
  ortho::OrthoSettings ortho;
  OrthoCommandOptions() { settings.atlas.unseen = atlas::UnseenFaces::drop; }
};

struct TilesOptions : CommandOptions {
  SceneInput input;
  std::filesystem::path allow;
  tiles::JobSettings settings;
};

struct UnitOptions {
  CommonOptions common;
  std::filesystem::path job;
  std::vector<std::string> names;
  bool all = false;
  bool clean = false;         ///< remove what units leave for each other once all are complete
  pipeline::Settings limits;  ///< memory
};

struct PlanOptions {
  CommonOptions common;
  std::filesystem::path job;
  bool sbatch = false;
};

struct VisibilityCommandOptions : CommandOptions {
  SceneInput input;
  bool ivm = false;
  visibility::VisibilityOptions visibility;
  int oracle_check = 0;  ///< views to compare with the oracle
};

enum class SynthKind { city, terrain, slits };

struct SynthOptions : CommandOptions {
  SynthKind kind = SynthKind::city;
  synth::FlightOptions flight;
  std::size_t faces = 60000;
  double gap_m = 20;              ///< terrain: between the two layers
  double mesh_noise_m = 0;        ///< each coordinate of the written mesh is off by up to this
  synth::CameraErrors errors;     ///< of the written cameras
  bool exposure = false;          ///< a gain and vignetting for each photo
  bool exif = false;              ///< photos' EXIF data state their exposure
  double wander = 0;              ///< most that a channel's gain changes from photo to photo, as a share
  double backscatter = 0;         ///< of synth::Shot
  synth::BandOptions bands;       ///< of photos that are TIFFs
  synth::Unmodelled unmodelled;   ///< city: what the mesh lacks
  bool reflections = false;       ///< of window panes
  double aperture_m = 0;          ///< 0: a pinhole
  std::optional<double> focus_m;  ///< depth of the plane in focus; empty: what cameras look at
  double shake_px = 0;            ///< most that a photo's middle moves during the exposure
  double travel_m = 0;            ///< most that the camera moves along the photo's width meanwhile
  double visibility_m = 0;        ///< in haze; 0: clear air
  int rays = 64;                  ///< a pixel of a blurred photo
  bool ids = true;                ///< write ids/ and clean/
  WorldPoint offset;              ///< added to all coordinates
  int quality = 95;
};

/// The defaults of `gpvc synth KIND`.
SynthOptions synth_defaults(SynthKind kind);
const char* synth_name(SynthKind kind);

/// `out` may be empty: no pictures.
struct EvaluateCommandOptions : CommandOptions {
  std::filesystem::path model;
  SceneInput input;             ///< input.mesh: the mesh that was to be textured; empty: the model's own faces
  std::filesystem::path truth;  ///< a synthetic scene's folder; empty: none
  int reduction = 4;
};

struct CompareOptions : CommandOptions {
  SceneInput input;
  std::string modes;                             ///< list; empty: compare::default_modes()
  std::vector<double> epsilons;                  ///< of modes given without one; empty: compare::BiasScale::sweep()
  std::vector<std::string> externals;            ///< NAME=MODEL
  std::optional<int> reduction;                  ///< empty: what makes a quarter of the photo as taken
  compare::CompareSettings settings;             ///< its modes, externals and reduction follow from the above
  std::vector<std::filesystem::path> summarize;  ///< report.json files: no scene is textured
};

struct LabelOptions : CommandOptions {
  std::filesystem::path costs, mesh;
  pipeline::Settings settings;
  LabelOptions() { settings.solver.thorough = true; }
};

struct InspectOptions {
  CommonOptions common;
  SceneInput input;               ///< the mesh may be missing
  bool check = false;             ///< looks at the photos, too
  std::filesystem::path picture;  ///< of the photos that agree least; empty: none
  bool plan = false;              ///< what a job of units would take
  std::optional<WorldPoint> at;   ///< a place of a result, which takes the scene's place
  tiles::JobSettings job;
};

struct PhotosOptions {
  CommonOptions common;
  SceneInput input;
  std::vector<WorldPoint> points;
  std::string crs;  ///< of the points; empty: they are in the mesh's coordinates, or the scene's reference system
  std::vector<std::uint32_t> faces;
  std::filesystem::path geojson;  ///< with more points; empty: none
  std::filesystem::path from;     ///< an earlier result that knows outliers and costs; empty: none
  bool judge = false;             ///< compare the photos for that
  std::filesystem::path allow;
  pipeline::Settings settings;
  std::filesystem::path json, crops, index;  ///< empty: not written
  int crop_size = 256;
};

struct ViewOptions {
  CommonOptions common;
  std::filesystem::path result, beside;  ///< beside: empty, or a second result
  SceneInput input;                      ///< empty scene and mesh: those that the result was made from
  int port = 0;                          ///< 0: one that is free
  bool no_browser = false;
  std::filesystem::path export_to;  ///< a folder to write the page to, instead of serving it; empty: none
  bool force = false;
};

struct CoverageOptions : CommandOptions {
  SceneInput input;
  std::filesystem::path from;  ///< an earlier result that knows outliers; empty: none
  query::Wanted wanted;
  std::optional<double> least_area;  ///< empty: found
  int cells = 2048;
  visibility::VisibilityOptions visibility;
};

struct ConvertOptions : CommandOptions {
  SceneInput input;  ///< no mesh
  bool undistort = false;
  pipeline::FrameRule frame = pipeline::FrameRule::inside;
  io::SceneTarget target = io::SceneTarget::colmap;
  int quality = 98;
};

/// Bad usage found after parsing: exit code 2. what() is one sentence.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// The commands. They throw; run_command_line() turns exceptions into exit codes.
/// `watcher` hears what the console shows, and can cancel the run; null: nobody.
void run_texture(const TextureOptions& options, Console& console, results::Observer* watcher);
inline void run_texture(const TextureOptions& options, Console& console) { run_texture(options, console, nullptr); }
void run_tileset(const TilesetOptions& options, Console& console);
void run_ortho(const OrthoCommandOptions& options, Console& console);
void run_tiles(const TilesOptions& options, Console& console);
void run_unit(const UnitOptions& options, Console& console);
void run_plan(const PlanOptions& options, Console& console);
void run_visibility(const VisibilityCommandOptions& options, Console& console);
void run_evaluate(const EvaluateCommandOptions& options, Console& console);
void run_compare(const CompareOptions& options, Console& console);
void run_label(const LabelOptions& options, Console& console);
void run_photos(const PhotosOptions& options, Console& console);
void run_coverage(const CoverageOptions& options, Console& console);
void run_view(const ViewOptions& options, Console& console);
void run_convert(const ConvertOptions& options, Console& console);
void run_inspect(const InspectOptions& options, Console& console);
void run_synth(const SynthOptions& options, Console& console);

/// "0.1.0 (ab12cd3)".
std::string program_version();

}  // namespace gpvc::cli
