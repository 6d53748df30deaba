// Scenes (cameras, poses, photo names) in the formats of other programs: reading and writing.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "error.h"
#include "names.h"
#include "scene.h"

namespace gpvc::io {

// --- reading

inline constexpr Named<BadPhoto::Problem> kPhotoProblemNames[] = {
    {"missing", BadPhoto::Problem::missing},        {"ambiguous", BadPhoto::Problem::ambiguous},
    {"unreadable", BadPhoto::Problem::unreadable},  {"truncated", BadPhoto::Problem::truncated},
    {"damaged", BadPhoto::Problem::damaged},        {"turned", BadPhoto::Problem::turned},
    {"other shape", BadPhoto::Problem::other_shape}};

/// The files of one band, which are called like the photos.
struct BandFolder {
  std::string name;
  std::filesystem::path folder;
};

struct SceneOptions {
  /// Folder of the photos, which may lie at any depth and behind links to folders; they are matched by the longest common
  /// tail of their paths. Default: where the scene's file says, then the format's usual folders.
  std::optional<std::filesystem::path> images_dir{};
  /// Views whose photo is not found keep an empty View::photo (and, in formats that leave the size to the photo, a
  /// camera of width 0) instead of being an error.
  bool allow_missing_photos = false;
  /// Tells which of the views, in their final order and under their final names, need their photo; default: all. A photo
  /// of another view that is missing, ambiguous, unreadable or of another shape than its camera leaves View::photo empty
  /// (and a camera of width 0, see above) instead of being an error.
  std::function<std::vector<bool>(std::span<const View> views)> needed{};
  /// Of the views that need them, photos that cannot be used (BadPhoto) leave View::photo empty instead of being an error,
  /// and are listed in Scene::bad_photos. To find them, every photo is decoded whole.
  bool skip_bad_photos = false;
  /// Photos are reduced by this factor (box average) and cameras with them; >= 1.
  int downscale = 1;
  /// Folder of the masks, by the views' names; default: beside the photos.
  std::optional<std::filesystem::path> masks_dir{};
  bool masks = true;  ///< look for masks, and use alpha channels
  /// Folders with one band each: of all bands, or of those that the photos have not.
  std::vector<BandFolder> bands{};
  /// Each camera of a multispectral rig writes a file, whose name ends with the band. True: files beside a photo whose names differ from its
  /// name in that ending alone hold its other bands (see band_files.h). Where the scene has views for these files, one view of each photo is
  /// left, with View::band_cameras (see band_views.h).
  bool bands_by_name = true;
  /// The names or numbers, from 1 on, of the bands that are red, green and blue in what is looked at, or of one that is grey; empty: by
  /// their names.
  std::vector<std::string> composite{};
  /// One view for each photo of a fisheye, however wide, whose edges then lie beyond the frame; for writing the scene.
  bool whole_fisheyes = false;
  /// Bands that the scene has views for stay views of their own; for writing the scene.
  bool bands_as_listed = false;
};

/// Reads a scene of any format that a scenes/NAME_scene.cpp reads; the format is recognized by what `source` (a file or a
/// folder) is or contains. Each of those files states its format's pixel and axis conventions, which are converted to
/// ours. Checks that every photo exists and that its header has the camera's size, without decoding it: a photo of
/// another size but the same shape scales its camera. A JPEG or PNG that ends too early is found, too. One error names all
/// photos that cannot be used. Of wide fisheyes up to three photos of a lens are decoded, of photos with bands (Scene::bands) up to eight. A reduced camera is width / N, height / N (cut), fx / N, fy / N, cx / N, cy / N,
/// which is exact in this convention. What was left out or assumed is in Scene::warnings. Equirectangular photos become six views each (is_spherical in scene.h): DIR/STEM.EXT
/// becomes DIR/STEM/front.EXT, right, back, left, up and down. Wide fisheyes keep their view and get four more that look
/// aside (Distortion::lens_from_frame): DIR/STEM/right.EXT, left, down and up. Throws InputError.
Scene read_scene(const std::filesystem::path& source, const SceneOptions& options);

/// Further coordinates that a mesh of the scene may be in: those of a training of nerfstudio, whose
/// dataparser_transforms.json lies beside the mesh or the scene; taken from the scene's own and each of its other frames,
/// as the file does not say from which. Empty where there is no such file. Throws InputError.
std::vector<SceneFrame> read_parser_frames(const Scene& scene, const std::filesystem::path& mesh);

/// The camera of the same photo reduced by a factor. \pre the photo is no smaller than that
Camera reduced_camera(Camera camera, int factor);

/// The name of the photo that a view shows: the view's own, or DIR/STEM.EXT of a panorama's DIR/STEM/front.EXT and of a
/// fisheye's DIR/STEM/right.EXT.
std::string photo_name(const View& view);

// --- writing

/// colmap: sparse/{cameras,images,points3D}.bin; cam: mvs-texturing's NAME.cam beside each photo; mvs: OpenMVS'
/// scene.mvs; transforms: nerfstudio's and instant-ngp's transforms.json; opensfm: reconstruction.json; nvm:
/// VisualSFM's scene.nvm.
enum class SceneTarget { colmap, cam, mvs, transforms, opensfm, nvm };
inline constexpr Named<SceneTarget> kSceneTargetNames[] = {
    {"colmap", SceneTarget::colmap},         {"cam", SceneTarget::cam},         {"mvs", SceneTarget::mvs},
    {"transforms", SceneTarget::transforms}, {"opensfm", SceneTarget::opensfm}, {"nvm", SceneTarget::nvm}};

struct PlacedScene;

/// A format's entry in the table of writers.
struct SceneWriter {
  SceneTarget target;
  /// What is written, relative to the scene's folder. The format's programs take it if it is one file, else the folder. Empty:
  /// NAME.cam beside each photo, in a folder without sub-folders.
  std::vector<std::filesystem::path> files;
  std::optional<std::string> (*lost_term)(const Camera&);  ///< as gpvc::io::lost_term, of this format alone
  /// Where the format's programs look for the mask of a photo at one of `photo_places`, according to their manuals:
  /// COLMAP's ImageReader.mask_path has NAME.EXT.png (colmap.github.io/faq, "Mask image regions"), here in masks/, where
  /// OpenSfM has them, too; transforms.json names them; OpenMVS takes NAME.mask.png beside the photo (with
  /// --ignore-mask-label 0). Programs that read NVM have no masks; ours finds NAME.EXT.mask.png beside the photo. Null
  /// for cam: mvs-texturing has no masks, and would take one beside a PNG for its photo.
  std::filesystem::path (*mask_place)(const std::filesystem::path& photo_place);
  void (*write)(const PlacedScene&);
  struct {
    bool square_and_centred = false;      ///< pixels have to be square, and the principal point in the photo's middle
    bool states_enu = false;              ///< states a reference system "ENU:..."
    const char* without_masks = nullptr;  ///< if its programs have no masks: who "will use" what masks exclude
    void (*refuse_name)(const std::string&) = nullptr;  ///< throws OutputError for a name that the format cannot state
  } more{};
};

const SceneWriter& scene_writer(SceneTarget target);

/// The first term of the camera's lens that the format cannot state ("p1", "the equisolid (fisheye) projection"); nullopt
/// when it can state all of it.
std::optional<std::string> lost_term(SceneTarget target, const Camera& camera);

/// Where the format expects the photo of each used view, relative to its folder. Throws OutputError where two views would
/// share one file, or the format cannot state a name.
std::vector<std::filesystem::path> photo_places(SceneTarget target, const Scene& scene, std::span<const ViewId> used);

/// The files that write_scene() writes, relative to its folder.
std::vector<std::filesystem::path> listing_files(SceneTarget target, std::span<const std::filesystem::path> places);

/// Writes cameras and poses, and the names in `places`, below `folder`, whose sub-folder `sparse` exists for colmap; no
/// photo is touched. Numbers read back exactly, and so do positions in world and pixels to the rounding of t = -R C.
/// Throws OutputError, also for a lens with a lost_term.
void write_scene(SceneTarget target, const Scene& scene, std::span<const ViewId> used,
                 std::span<const std::filesystem::path> places, const std::filesystem::path& folder);

}  // namespace gpvc::io
