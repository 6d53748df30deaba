#include "app/checks/mesh_frame.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <optional>
#include <stdexcept>
#include <utility>

#include "app/checks/frame_check.h"
#include "io/error.h"
#include "io/mesh.h"
#include "io/reference_system.h"
#include "io/scene_files.h"
#include "io/vector.h"

namespace gpvc::checks {
namespace {

namespace fs = std::filesystem;

// Some of the faces, with the vertices that they have.
Mesh thinned(const Mesh& mesh) {
  constexpr std::size_t kFaces = 20000;
  const std::size_t step = std::max<std::size_t>(1, mesh.faces.size() / kFaces);
  Mesh few;
  for (std::size_t f = 0; f < mesh.faces.size(); f += step) {
    Triangle face;
    for (std::size_t i = 0; i < 3; ++i) {
      face[i] = static_cast<std::uint32_t>(few.positions.size());
      few.positions.push_back(mesh.positions[mesh.faces[f][i]]);
    }
    few.faces.push_back(face);
  }
  return few;
}

bool fits(const Scene& scene, const Mesh& mesh, std::span<const ViewId> used) {
  constexpr std::size_t kVertices = 500;
  try {
    check_frames(mesh, "", scene, used);
    const std::vector<double> sampling = sampling_distances(mesh, scene, used, kVertices);
    check_scale(mesh, sampling, "");
    return !sampling.empty();
  } catch (const InputError&) {
    return false;
  }
}

void take_cameras_to(const SceneFrame& frame, Scene& scene) {
  const auto& r = frame.rotation;
  const auto turned = [&r](double x, double y, double z) {
    return std::array<double, 3>{r[0] * x + r[1] * y + r[2] * z, r[3] * x + r[4] * y + r[5] * z,
                                 r[6] * x + r[7] * y + r[8] * z};
  };
  for (View& view : scene.views) {
    WorldPoint& c = view.pose.centre;
    const auto moved = turned(c.x - frame.origin.x, c.y - frame.origin.y, c.z - frame.origin.z);
    c = {frame.scale * moved[0], frame.scale * moved[1], frame.scale * moved[2]};
    for (double& length : view.camera.distortion.motion.step) length *= frame.scale;
    // x_camera = R (x_scene - c): each row of R is a direction of the scene.
    for (std::size_t row = 0; row < 9; row += 3) {
      auto& m = view.pose.rotation;
      const auto direction = turned(m[row], m[row + 1], m[row + 2]);
      std::copy(direction.begin(), direction.end(), m.begin() + static_cast<std::ptrdiff_t>(row));
    }
  }
  scene.srs = frame.srs;
  scene.offset = {};
  scene.other_frames.clear();
}

// The share of the frames' area that the mesh lies in, occlusion aside: of cells so large that some faces of a thinned
// mesh lie in each.
double covered_share(const Scene& scene, const Mesh& mesh, std::span<const ViewId> used) {
  constexpr std::size_t kColumns = 8, kRows = 6, kMostViews = 64;
  const std::size_t views = std::min(used.size(), kMostViews);
  std::size_t covered = 0;
  for (std::size_t n = 0; n < views; ++n) {
    const View& view = scene.views[index(used[n * used.size() / views])];
    std::array<bool, kColumns * kRows> cells{};
    for (const Triangle& face : mesh.faces) {
      const auto& at = mesh.positions;
      const WorldPoint middle = (at[face[0]] + at[face[1]] + at[face[2]]) * (1.0 / 3);
      const auto pixel = pixel_from_world(view, middle);
      if (!pixel) continue;
      const double column = std::floor(pixel->x / view.camera.width * kColumns);
      const double row = std::floor(pixel->y / view.camera.height * kRows);
      if (column >= 0 && column < kColumns && row >= 0 && row < kRows)
        cells[static_cast<std::size_t>(row) * kColumns + static_cast<std::size_t>(column)] = true;
    }
    covered += static_cast<std::size_t>(std::ranges::count(cells, true));
  }
  return static_cast<double>(covered) / static_cast<double>(std::max<std::size_t>(1, views * kColumns * kRows));
}

// How much of the mesh the cameras frame, less what they see from behind, and of the frames the mesh fills: a mesh that is
// too large is framed in part, one that is too small fills a part.
double agreement(const Scene& scene, const Mesh& mesh, std::span<const ViewId> used) {
  return framed_share(mesh, scene, used) * (1 - back_share(mesh, scene, used).value_or(Backs{1}).share) *
         covered_share(scene, mesh, used);
}

// Between meshes that lie right and wrong the difference is large as a rule; where it is small, the coordinates that
// the files state are the likelier.
constexpr double kClearlyMore = 1.5;

// From glTF's axes, with y up, to those of surveys.
void turn_z_up(std::vector<WorldPoint>& positions) {
  for (WorldPoint& p : positions) p = {p.x, -p.z, p.y};
}

// A mesh that was made from the photos lies in their frames but for what was closed or continued at its rim. One that is
// moved by an offset which no file states may fit a frame in part: that is no reason to take it to be there.
constexpr double kLeastFramed = 0.9;

bool is_framed(const Scene& scene, const Mesh& mesh) {
  return framed_share(mesh, scene, all_views(scene)) >= kLeastFramed;
}

// The one of `frames` of most agreement; null where the mesh fits in none, or in none clearly better than in the scene's
// own, and where it is not framed in that one.
const SceneFrame* best_frame(const Scene& scene, const Mesh& mesh, std::span<const ViewId> used, bool fits_own,
                             std::span<const SceneFrame> frames) {
  const SceneFrame* best = nullptr;
  double most = fits_own && !frames.empty() ? kClearlyMore * agreement(scene, mesh, used) : 0;
  for (const SceneFrame& frame : frames) {
    Scene moved = scene;
    take_cameras_to(frame, moved);
    if (!fits(moved, mesh, used)) continue;
    const double share = agreement(moved, mesh, used);
    if (share <= most) continue;
    most = share;
    best = &frame;
  }
  if (best == nullptr) return nullptr;
  Scene moved = scene;
  take_cameras_to(*best, moved);
  return is_framed(moved, mesh) ? best : nullptr;
}

void subtract(std::vector<WorldPoint>& points, const WorldPoint& offset) {
  for (WorldPoint& p : points) p = {p.x - offset.x, p.y - offset.y, p.z - offset.z};
}

// The positions in the scene's coordinates, if they are of such a system. Throws what transform_points() throws.
std::vector<WorldPoint> from_system(const std::string& crs, const Scene& scene, std::vector<WorldPoint> positions,
                                    io::HeightsAbove heights = io::HeightsAbove::own_ellipsoid) {
  io::transform_points(crs, scene.srs, positions, heights);
  subtract(positions, scene.offset);
  return positions;
}

// What a WKT calls the system.
std::string short_name(const std::string& crs) {
  const std::size_t begin = crs.find('"'), end = crs.find('"', begin + 1);
  return end == std::string::npos ? crs : crs.substr(begin + 1, end - begin - 1);
}

void take_mesh_from(const std::string& crs, const Scene& scene, io::HeightsAbove heights, Mesh& mesh) {
  std::vector<WorldPoint> moved = from_system(crs, scene, mesh.positions, heights);
  mesh.file_positions = std::exchange(mesh.positions, std::move(moved));
  mesh.file_srs = crs;
}

WorldPoint mean_centre(const Scene& scene, std::span<const ViewId> used) {
  WorldPoint sum;
  for (const ViewId id : used) {
    const WorldPoint& c = scene.views[index(id)].pose.centre;
    sum = {sum.x + c.x, sum.y + c.y, sum.z + c.z};
  }
  const auto n = static_cast<double>(std::max<std::size_t>(1, used.size()));
  return {sum.x / n, sum.y / n, sum.z / n};
}

// The positions in the scene's coordinates, if they are relative to the origin. Throws what transform_points() throws.
std::vector<WorldPoint> from_origin(const io::MeshOrigin& origin, const Scene& scene,
                                    std::vector<WorldPoint> positions) {
  for (WorldPoint& p : positions) p = {p.x + origin.origin.x, p.y + origin.origin.y, p.z + origin.origin.z};
  if (!origin.srs.empty() && !scene.srs.empty() && origin.srs != scene.srs)
    return from_system(origin.srs, scene, std::move(positions));
  subtract(positions, scene.offset);
  return positions;
}

// True and moves the mesh if it fits the cameras with the origin that is stated for it.
bool take_mesh_from(const io::MeshOrigin& origin, const Scene& scene, std::span<const ViewId> used, const Mesh& few,
                    Mesh& mesh) {
  Mesh moved = few;
  try {
    moved.positions = from_origin(origin, scene, few.positions);
    if (!fits(scene, moved, used)) return false;
    std::vector<WorldPoint> positions = from_origin(origin, scene, mesh.positions);
    mesh.file_positions = std::exchange(mesh.positions, std::move(positions));
    return true;
  } catch (const std::runtime_error&) {
    return false;  // the systems cannot be brought together
  }
}

bool is_geocentric(const Scene& scene) { return scene.srs == io::kGeocentric; }

// How well the mesh fits the cameras if its positions are of such a system: 0 where it does not.
double agreement_from(const std::string& crs, const Scene& scene, std::span<const ViewId> used, const Mesh& few,
                      io::HeightsAbove heights) {
  Mesh moved = few;
  try {
    moved.positions = from_system(crs, scene, few.positions, heights);
  } catch (const std::runtime_error&) {
    return 0;  // the points are none of that system
  }
  // In metres. Local coordinates that are taken for degrees make a mesh of the size of the earth.
  constexpr double kLargest = 1e5;
  const Box box = box_of(moved);
  if (is_geocentric(scene) && length(box.high - box.low) > kLargest) return 0;
  return fits(scene, moved, used) ? agreement(scene, moved, used) : 0;
}

// What the heights of such a mesh are above; the system's own ellipsoid unless the mesh fits clearly better otherwise.
io::HeightsAbove heights_of(const std::string& crs, const Scene& scene, std::span<const ViewId> used, const Mesh& few) {
  using io::HeightsAbove;
  const double own = agreement_from(crs, scene, used, few, HeightsAbove::own_ellipsoid),
               other = agreement_from(crs, scene, used, few, HeightsAbove::ellipsoid_of_target);
  return other > kClearlyMore * own ? HeightsAbove::ellipsoid_of_target : HeightsAbove::own_ellipsoid;
}

std::optional<io::MissingGrid> missing_grid(const std::string& crs, const Scene& scene, io::HeightsAbove heights,
                                            const Mesh& mesh) {
  try {
    return io::missing_grid(crs, scene.srs, mesh.positions.at(0), heights);
  } catch (const std::runtime_error&) {
    return std::nullopt;  // PROJ does not know the system
  }
}

// "PROJ lacks the grid ..."; empty where it lacks none.
std::string note_on_grid(const std::string& crs, const Scene& scene, io::HeightsAbove heights, const Mesh& mesh) {
  const std::optional<io::MissingGrid> grid = missing_grid(crs, scene, heights, mesh);
  return grid ? io::sentence_on(*grid, crs, scene.srs) : "";
}

// Another system is no way out of heights that cannot be taken over: the mesh would fit some 50 m too low or high.
void refuse_without_grid(const Scene& scene, const Mesh& few, const fs::path& mesh_file) {
  if (scene.reference.empty()) return;
  const auto grid = missing_grid(scene.reference, scene, io::HeightsAbove::own_ellipsoid, few);
  if (grid && grid->accuracy_m < 0)
    throw InputError(mesh_file, "", io::sentence_on(*grid, scene.reference, scene.srs), {Cure::name_mesh_crs});
}

// "EPSG:27700, with heights above its ellipsoid"
std::string named(const std::string& crs, io::HeightsAbove heights, const Scene& scene) {
  const bool own = heights == io::HeightsAbove::own_ellipsoid;
  return fmt::format("{}, with heights above {}", short_name(crs),
                     own ? "the ellipsoid" : "the ellipsoid of " + short_name(scene.srs) + " instead of its own");
}

}  // namespace

Remark match_frames(Scene& scene, Mesh& mesh, std::span<const ViewId> used, const fs::path& mesh_file,
                    const std::string& mesh_crs) {
  if (!mesh_crs.empty()) {
    if (scene.srs.empty())
      throw InputError(scene.source, "",
                       "names no reference system, so a mesh cannot be brought from another one to it");
    const io::HeightsAbove heights = heights_of(mesh_crs, scene, used, thinned(mesh));
    std::string grid = note_on_grid(mesh_crs, scene, heights, mesh);
    try {
      take_mesh_from(mesh_crs, scene, heights, mesh);
    } catch (const InputError&) {
      throw;
    } catch (const std::runtime_error& error) {
      throw InputError(mesh_file, "", fmt::format("cannot be brought to the scene's {}: {}", scene.srs, error.what()));
    }
    if (heights == io::HeightsAbove::own_ellipsoid) return {std::move(grid)};
    return {fmt::format("the mesh fits the cameras if its coordinates are those of {}: they are taken for that{}{}",
                        named(mesh_crs, heights, scene), grid.empty() ? "" : "; ", grid)};
  }
  Mesh few = thinned(mesh);
  if (few.faces.empty()) return {};
  const bool fits_own = fits(scene, few, used);
  if (io::is_gltf(mesh_file)) {
    Mesh turned = few;
    turn_z_up(turned.positions);
    if (fits(scene, turned, used) &&
        (!fits_own || agreement(scene, turned, used) > kClearlyMore * agreement(scene, few, used))) {
      turn_z_up(mesh.positions);
      return {"the mesh has y up, as glTF asks, and fits the cameras with z up: it is turned"};
    }
  }
  std::vector<SceneFrame> frames = scene.other_frames;
  std::ranges::move(io::read_parser_frames(scene, mesh_file), std::back_inserter(frames));
  if (const SceneFrame* frame = best_frame(scene, few, used, fits_own, frames)) {
    const std::string own = scene.srs.empty() ? "their own coordinates" : scene.srs;
    std::string text =
        fits_own
            ? fmt::format("the mesh fits the cameras better in {} than in {}: they are taken there", frame->name, own)
            : fmt::format("the mesh does not fit the cameras in {}, but in {}: they are taken there", own, frame->name);
    take_cameras_to(*frame, scene);
    return {std::move(text)};
  }
  if (fits_own) return {};
  if (const auto origin = io::read_mesh_origin(mesh_file); origin && take_mesh_from(*origin, scene, used, few, mesh))
    return {fmt::format("the mesh fits the cameras with the origin that {} states: its coordinates are taken for that",
                        origin->file.string())};
  std::vector<std::string> systems;
  if (!scene.reference.empty()) systems.push_back(scene.reference);
  if (is_geocentric(scene)) systems.push_back(io::utm_zone(mean_centre(scene, used)));
  for (const std::string& crs : systems) {
    const io::HeightsAbove heights = heights_of(crs, scene, used, few);
    if (agreement_from(crs, scene, used, few, heights) == 0) continue;
    refuse_without_grid(scene, few, mesh_file);
    const std::string grid = note_on_grid(crs, scene, heights, few);
    take_mesh_from(crs, scene, heights, mesh);
    return {
        fmt::format("the mesh fits the cameras in {} if its coordinates are those of {}: they are taken for that{}{}",
                    scene.srs, named(crs, heights, scene), grid.empty() ? "" : "; ", grid),
        {Cure::name_mesh_crs}};
  }
  return {};
}

bool fits_cameras(const Scene& scene, const Mesh& mesh, std::span<const ViewId> used) {
  return fits(scene, thinned(mesh), used);
}

Remark ways_out(const Scene& scene) {
  if (scene.format == "transforms.json")
    return {
        "if nerfstudio exported the mesh, it is in the coordinates of its training: put the dataparser_transforms.json "
        "of the training's folder, which states them, beside the mesh",
        {}};
  if (scene.format.starts_with("RealityCapture"))
    return {
        "RealityScan exports in several coordinate systems: export the mesh in that of the cameras, which is 'Same as "
        "XMP' "
        "for .xmp files, and for a .csv the one that was chosen for it, not in degrees",
        {}};
  if (!is_geocentric(scene)) return {};
  return {
      "the scene is georeferenced, with cameras in geocentric coordinates (EPSG:4978): export the mesh in those or in "
      "the chunk's local ones, without an offset, or export the cameras as BlocksExchange XML in the mesh's system",
      {Cure::name_mesh_crs}};
}

}  // namespace gpvc::checks
