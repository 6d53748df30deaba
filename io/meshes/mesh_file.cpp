// Reads meshes of any format, and cuts their polygons into triangles.
#include "io/meshes/mesh_file.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "io/file_bytes.h"
#include "io/files/paths.h"
#include "io/mesh.h"
#include "io/number_text.h"
#include "io/vector.h"

namespace gpvc::io {

namespace {

/// Twice the area vector of a polygon: that of its fan, summed.
WorldPoint area_vector(const std::vector<WorldPoint>& corners) {
  WorldPoint sum;
  for (std::size_t i = 2; i < corners.size(); ++i) {
    const WorldPoint n = cross(corners[i - 1] - corners[0], corners[i] - corners[0]);
    sum = {sum.x + n.x, sum.y + n.y, sum.z + n.z};
  }
  return sum;
}

/// Ear clipping (Meisters 1975) in projection along the polygon's area vector. A hole may be joined to the outline by an
/// edge there and back: corners at the place of an ear's own corner do not lie within it. Empty when the polygon is not
/// simple and no ear is left.
std::vector<std::array<std::size_t, 3>> cut_ears(const std::vector<WorldPoint>& at) {
  const WorldPoint normal = area_vector(at);
  std::vector<std::size_t> left(at.size());
  std::iota(left.begin(), left.end(), std::size_t{0});
  const auto side = [&](std::size_t a, std::size_t b, std::size_t c) {
    return dot(cross(at[b] - at[a], at[c] - at[a]), normal);
  };
  std::vector<std::array<std::size_t, 3>> triangles;
  while (left.size() > 3) {
    const std::size_t n = left.size();
    std::size_t ear = n;
    for (std::size_t i = 0; i < n && ear == n; ++i) {
      const std::size_t a = left[(i + n - 1) % n], b = left[i], c = left[(i + 1) % n];
      if (!(side(a, b, c) > 0)) continue;
      const bool free = std::none_of(left.begin(), left.end(), [&](std::size_t p) {
        return at[p] != at[a] && at[p] != at[b] && at[p] != at[c] && side(a, b, p) >= 0 && side(b, c, p) >= 0 &&
               side(c, a, p) >= 0;
      });
      if (free) ear = i;
    }
    if (ear == n) return {};
    triangles.push_back({left[(ear + n - 1) % n], left[ear], left[(ear + 1) % n]});
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(ear));
  }
  if (side(left[0], left[1], left[2]) < 0) return {};
  triangles.push_back({left[0], left[1], left[2]});
  return triangles;
}

/// Ear clipping takes up to O(corners^3), so polygons with more corners keep their fan.
constexpr std::size_t kMostCorners = 256;

/// The corners of a polygon that was added as a fan.
std::vector<std::uint32_t> corners_of(std::span<const Triangle> fan) {
  std::vector<std::uint32_t> corners{fan[0][0], fan[0][1]};
  for (const Triangle& triangle : fan) corners.push_back(triangle[2]);
  return corners;
}

constexpr const char* kCloudAdvice =
    " points without faces; make a mesh of it first, by Poisson reconstruction (COLMAP's poisson_mesher, MeshLab, "
    "CloudCompare) or the meshing of the program that it comes from";

/// Throws for the formats that hold point clouds alone.
void refuse_clouds(const std::filesystem::path& file, std::string_view bytes) {
  for (const std::string_view magic : {"LASF", "ASTM-E57", "# .PCD"})
    if (bytes.starts_with(magic)) throw InputError(file, "", std::string("is a point cloud,") + kCloudAdvice);
}

Mesh read_by_content(const std::filesystem::path& file, std::string_view text) {
  refuse_clouds(file, text);
  if (text.starts_with("ply\n") || text.starts_with("ply\r") || text.starts_with("ply ") || text == "ply")
    return read_ply(file, text);
  if (is_gltf(file) || text.starts_with("glTF")) return read_gltf_mesh(file);
  if (is_stl(text)) return read_stl(file, text);
  if (is_off(text)) return read_off(file, text);
  return read_obj(file, text);
}

}  // namespace

bool is_gltf(const std::filesystem::path& file) {
  const std::string extension = lower_case(file.extension().string());
  return extension == ".glb" || extension == ".gltf";
}

bool is_mesh_name(const std::filesystem::path& file) {
  const std::string extension = lower_case(file.extension().string());
  return is_gltf(file) || extension == ".ply" || extension == ".obj" || extension == ".stl" || extension == ".off";
}

Mesh read_mesh(const std::filesystem::path& file) {
  if (is_folder(file)) {
    const std::vector<std::filesystem::path> files = mesh_files(file);
    Mesh all;
    for (Mesh& part : read_meshes({&files, 1})) append_mesh(all, std::exchange(part, {}));
    return all;
  }
  const FileBytes bytes(file);
  const std::string_view text = without_byte_order_mark(bytes.view());
  if (text.empty()) throw InputError(file, "", "is empty, expected a mesh: PLY, OBJ, STL, OFF, GLB or glTF");
  Mesh mesh = read_by_content(file, text);
  refuse_faceless(file, mesh);
  recut_concave(mesh);
  settle_places(file, mesh);
  return mesh;
}

void refuse_faceless(const std::filesystem::path& file, const Mesh& mesh) {
  if (!mesh.faces.empty()) return;
  if (mesh.positions.empty()) throw InputError(file, "", "is empty: it has no vertices and no faces");
  if (!mesh.warnings.empty()) throw InputError(file, "", "has no faces of three or more vertices");
  throw InputError(file, "", "is a point cloud, " + std::to_string(mesh.positions.size()) + kCloudAdvice);
}

void note_source(Mesh& mesh, std::size_t triangles, std::size_t face) {
  const std::size_t before = mesh.faces.size() - triangles;
  const bool own_source = triangles == 1 && face == before;
  if (!own_source && mesh.source_face.empty()) {
    // So far every face was a triangle, and its own source.
    mesh.source_face.resize(before);
    std::iota(mesh.source_face.begin(), mesh.source_face.end(), 0u);
    mesh.source_face.reserve(mesh.faces.capacity());
  }
  if (!own_source || !mesh.source_face.empty())
    mesh.source_face.insert(mesh.source_face.end(), triangles, static_cast<std::uint32_t>(face));
}

void warn_of_lines(Mesh& mesh, std::size_t count, const std::string& first) {
  if (count > 0)
    mesh.warnings.push_back(std::to_string(count) + " faces of fewer than three vertices are left out, the first " +
                            first);
}

void append_mesh(Mesh& all, const Mesh& more) {
  all.warnings.insert(all.warnings.end(), more.warnings.begin(), more.warnings.end());
  const auto vertices = static_cast<std::uint32_t>(all.positions.size());
  if (!all.source_face.empty() || !more.source_face.empty()) {
    if (all.source_face.empty()) {
      all.source_face.resize(all.faces.size());
      std::iota(all.source_face.begin(), all.source_face.end(), 0u);
    }
    const std::uint32_t polygons = all.source_face.empty() ? 0 : all.source_face.back() + 1;
    for (std::uint32_t f = 0; f < more.faces.size(); ++f)
      all.source_face.push_back(polygons + (more.source_face.empty() ? f : more.source_face[f]));
  }
  all.positions.insert(all.positions.end(), more.positions.begin(), more.positions.end());
  for (const Triangle& t : more.faces) all.faces.push_back({t[0] + vertices, t[1] + vertices, t[2] + vertices});
}

void recut_concave(Mesh& mesh, std::span<Triangle> texcoords) {
  std::size_t overlapping = 0;
  for (std::size_t begin = 0, end = 0; begin < mesh.source_face.size(); begin = end) {
    end = begin + 1;
    while (end < mesh.source_face.size() && mesh.source_face[end] == mesh.source_face[begin]) ++end;
    if (end - begin < 2) continue;
    const std::vector<std::uint32_t> corners = corners_of(std::span(mesh.faces).subspan(begin, end - begin));
    std::vector<WorldPoint> at;
    // Relative to the first corner: with georeferenced coordinates rounding would swamp the products.
    for (const std::uint32_t v : corners) at.push_back(mesh.positions[v] - mesh.positions[corners[0]]);
    const WorldPoint normal = area_vector(at);
    bool turned = false;
    for (std::size_t i = 2; i < at.size(); ++i) turned |= dot(cross(at[i - 1] - at[0], at[i] - at[0]), normal) < 0;
    if (!turned) continue;
    const auto triangles = corners.size() <= kMostCorners ? cut_ears(at) : std::vector<std::array<std::size_t, 3>>();
    if (triangles.size() != end - begin) {
      ++overlapping;
      continue;
    }
    for (const std::span<Triangle> all : {std::span(mesh.faces), texcoords}) {
      if (all.empty()) continue;
      const std::span<Triangle> fan = all.subspan(begin, end - begin);
      const std::vector<std::uint32_t> numbers = corners_of(fan);
      for (std::size_t i = 0; i < fan.size(); ++i)
        fan[i] = {numbers[triangles[i][0]], numbers[triangles[i][1]], numbers[triangles[i][2]]};
    }
  }
  if (overlapping > 0)
    mesh.warnings.push_back(std::to_string(overlapping) + " polygons cross themselves, or are concave with more than " +
                            std::to_string(kMostCorners) + " corners: their triangles overlap");
}

}  // namespace gpvc::io
