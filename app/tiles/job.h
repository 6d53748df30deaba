// A job: a scene cut into units of work, in a folder that all machines see which work on it. What units leave for each other:
//
//   job.json             the program and the settings that the job was made with, for people
//   plan.json            the units, see plan.h
//   mesh/                scene and tiles; files.json lists them
//   units/NAME/          what a unit leaves for others, and done.json once that is complete
//   result/              tileset.json, tiles/LEVEL_NUMBER.glb, obj/NUMBER/model.obj with pages and offset.txt for level 0
//
// Files in mesh/ and units/ are those of io::WorkStore, each with a key of what it came from and a hash of its bytes. files.json
// and done.json have a hash of each file, too: one that is replaced by a whole one of the same key is told from it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "app/checks/framing.h"
#include "app/pipeline/pipeline.h"
#include "app/pipeline/view_rules.h"
#include "app/tileset/tileset.h"
#include "io/images.h"
#include "io/textured_model.h"
#include "io/tie_points.h"
#include "io/work_store.h"

namespace gpvc::tiles {

namespace fs = std::filesystem;

struct TileInfo {
  checks::Box box;                                     ///< of its faces and those of its border
  checks::Box own_box;                                 ///< of its faces
  std::size_t faces = 0, all_faces = 0, vertices = 0;  ///< without and with the border; with it
  std::vector<ViewId> views{};                         ///< that may frame the box
  std::vector<std::uint32_t> beside{};                 ///< tiles that share an edge with it
  std::vector<std::uint32_t> around{};                 ///< tiles with faces in its border
  int color = 0;                                       ///< no two tiles beside each other have the same
  double pairs = 0, texels = 0;                        ///< pipeline::Workload, border included
};

/// Tiles of one level of detail. Tile n has the children 4 n to 4 n + 3 on the level below.
struct Level {
  /// Above level 0, of meshes that are not made yet: boxes hold what their children hold, and the rest is predicted.
  std::vector<TileInfo> tiles{};
  int reduction = 1;      ///< pixels of the job's photos to one that the level is textured from, each way
  double texel_size = 0;  ///< least edge of a texel, in the scene's units; 0: those of the photos
};

struct JobSettings {
  pipeline::Settings texture{};
  tileset::TilesetSettings tiles{};
  std::size_t views_per_unit = 16;  ///< at most, looked at by one unit
  bool levels = true;               ///< of detail above that of the mesh
};

struct Job {
  JobSettings settings{};
  Scene scene;                                   ///< as brought into the mesh's coordinates
  std::filesystem::path mesh_file{};             ///< named in errors and warnings
  std::vector<ViewId> views{};                   ///< to texture from
  std::vector<io::TiePoint> tie_points{};        ///< of the scene
  std::vector<pipeline::NumberRanges> listed{};  ///< vertices of the faces that rules list
  io::ModelOptions model{};                      ///< how model.obj writes the coordinates of the mesh's file
  io::ModelOptions tiles_model{};                ///< how tiles write those of the scene
  io::ColorProfile color_profile{};              ///< of the pages
  std::vector<Level> levels{};                ///< the mesh's own faces, then each level of detail above, up to one tile
  std::vector<std::vector<ViewId>> groups{};  ///< views that one unit looks at

  const std::vector<TileInfo>& tiles(int level) const { return levels[static_cast<std::size_t>(level)].tiles; }
};

/// In mesh/, the job itself.
inline constexpr const char* kSceneFile = "scene";

/// The scene at the size of photos that a level is textured from.
Scene scene_at(const Job& job, int level);

/// Of all that a job's units and results depend on, except the bytes of photos and masks. \param program its version
/// \param job whose settings, models and color_profile are known
io::WorkKey job_key(const pipeline::Run& run, std::string_view program, const Job& job);

/// The tiles with faces that views of a group may frame, ascending.
std::vector<std::uint32_t> tiles_of_group(const Job& job, int level, std::size_t group);

class DoneList;

/// Reads and writes the files of a job. Errors name the file, and the unit that makes it.
class JobFolder {
 public:
  /// The folders that units write into.
  static constexpr const char* kOfUnits[] = {"units", "result"};
  explicit JobFolder(std::filesystem::path folder);

  const std::filesystem::path& path() const { return folder_; }
  std::filesystem::path unit(const std::string& name) const { return folder_ / "units" / name; }
  std::filesystem::path done_file(const std::string& name) const { return unit(name) / "done.json"; }

  /// Throws OutputError.
  void write_job(const Job& job, const io::WorkKey& key) const;
  /// Lists the files of mesh/.
  std::filesystem::path mesh_files() const { return folder_ / "mesh" / "files.json"; }
  /// Throws InputError where there is none.
  Job read_job() const;
  /// The key of the job. Throws InputError.
  io::WorkKey key() const;
  /// nullopt where there is none.
  std::optional<io::WorkKey> key_if_made() const;

  /// Removes what units have left, with the result. Throws OutputError where that cannot be done.
  void remove_units() const;
  /// Removes what units have left for each other alone. Throws OutputError where that cannot be done.
  void remove_kept() const;
  /// The key of a complete unit; nullopt where it has to be done.
  std::optional<io::WorkKey> done(const std::string& name) const;
  /// The first file that a complete unit made and that is not what it was. O(bytes of these files).
  std::optional<std::filesystem::path> changed_output(const std::string& name) const;
  /// Throws OutputError where a folder on the way to a file, which is named from that of the job, is a symbolic link: what
  /// lies beyond it is not the job's.
  void refuse_links(const std::filesystem::path& file) const;

  /// Throws OutputError.
  void keep(const std::filesystem::path& folder, const std::string& name, const io::WorkKey& key,
            const std::function<void(io::WorkStore::Writer&)>& write) const;
  /// What a unit left; throws InputError that names the unit where it is missing or not what the unit made.
  /// \param is_right if the values of the part can be of this job
  template <typename Part, typename IsRight>
  Part get(const std::string& unit, const std::string& name, const IsRight& is_right) const {
    Part part{};
    read(unit, name, [&](io::WorkStore::Reader& in) {
      part = in.get<Part>();
      if (!is_right(part)) in.refuse();
    });
    return part;
  }
  /// The same for parts that are read piece by piece.
  void read(const std::string& unit, const std::string& name,
            const std::function<void(io::WorkStore::Reader&)>& fill) const;
  /// Reads a file of mesh/, which `gpvc tiles` makes.
  void read_mesh_file(const std::string& name, const std::function<void(io::WorkStore::Reader&)>& fill) const;

 private:
  std::filesystem::path folder_;
  std::shared_ptr<DoneList> mesh_list_;  ///< of mesh_files()
};

}  // namespace gpvc::tiles
