// What the parts of the benchmark of the whole program share.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace gpvc::scaling {

// --- scenes

struct SceneSize {
  int photos = 0;
  std::size_t faces = 0;  ///< aimed at
  int width = 0, height = 0;
  bool nadir = false;  ///< a flight that looks straight down, where photos overlap by 80 %, instead of one over a city
};

/// "400-photos-2000000-faces-4000x3000", the folder's name, with "-nadir" if it is.
std::string name_of(const SceneSize& size);

struct SceneFiles {
  std::filesystem::path folder, mesh;  ///< the folder is what `gpvc texture` takes for SCENE
  std::size_t faces = 0;
};

/// The scene of this size below `scenes`: a city and a flight over it, whose area grows with the number of photos. What
/// an earlier call has not completed is made; as many photos are in memory as there are threads. Progress on stderr.
SceneFiles make_scene(const SceneSize& size, const std::filesystem::path& scenes);

// --- measuring

struct StageSeconds {
  double see = 0, choose = 0, bake = 0, write = 0, other = 0;
};

/// The least that a texturing program must do with its files, in wall seconds on all threads.
struct Floor {
  double decode_s = 0;    ///< every photo once
  double encode_s = 0;    ///< every texel of the pages once
  double megatexels = 0;  ///< of the pages
  double seconds() const { return decode_s + encode_s; }
};

struct Measured {
  SceneSize size;
  std::size_t faces = 0;  ///< of the mesh
  double wall_s = 0, cpu_s = 0, peak_gb = 0;
  StageSeconds stages;
  Floor floor;
  double megapixels() const { return 1e-6 * size.photos * size.width * size.height; }
  double ratio() const { return wall_s / floor.seconds(); }
};

struct RunOptions {
  std::filesystem::path gpvc;  ///< the executable
  std::string memory;          ///< for --memory; empty: not given
  int runs = 1;
  bool keep = false;  ///< keep the textured model
};

/// Textures the scene `options.runs` times into a folder below `results` and takes the run of the median wall time;
/// then measures the floor. Throws std::runtime_error when a run fails.
Measured measure(const SceneSize& size, const SceneFiles& scene, const RunOptions& options,
                 const std::filesystem::path& results);

// --- results

/// Rows in two series: of growing photos, of growing faces.
struct Series {
  std::vector<Measured> by_photos, by_faces;
};

/// Seconds by megapixels, and by faces, with their stages stacked over the floor; peak memory by photos.
void write_plot(const Series& series, const std::filesystem::path& file);

}  // namespace gpvc::scaling
