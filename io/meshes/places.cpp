// Vertices that lie nowhere, and the faces that use them.
#include <algorithm>
#include <cmath>

#include "io/error.h"
#include "io/mesh.h"
#include "io/meshes/mesh_file.h"
#include "io/number_text.h"

namespace gpvc::io {
namespace {

/// "12 vertices have no place, the first vertex 7, as a coordinate is not finite"
std::string description(const Mesh& mesh, std::size_t count, std::size_t first, const char* which) {
  const WorldPoint& p = mesh.positions[first];
  std::string reason = "as a coordinate is not finite";
  for (const double value : {p.x, p.y, p.z})
    if (std::isfinite(value) && std::abs(value) > kMostCoordinate)
      reason = "whose coordinate " + shortest_text(value) + " is above " + shortest_text(kMostCoordinate) +
               ", the most that graphics in single precision can take";
  return std::to_string(count) + " vertices" + which + " have no place, the first vertex " + std::to_string(first) +
         ", " + reason;
}

/// Some that have no place, of those in faces or of the others.
struct Unplaced {
  std::size_t count = 0, first = 0;
  void add(std::size_t vertex) {
    if (count++ == 0) first = vertex;
  }
};

}  // namespace

void settle_places(const std::filesystem::path& file, Mesh& mesh) {
  if (std::ranges::all_of(mesh.positions, has_place)) return;
  const auto placed = [&](std::uint32_t v) { return has_place(mesh.positions[v]); };
  std::vector<bool> used(mesh.positions.size(), false);
  const Triangle* whole = nullptr;
  for (const Triangle& face : mesh.faces) {
    for (const std::uint32_t v : face) used[v] = true;
    if (whole == nullptr && std::ranges::all_of(face, placed)) whole = &face;
  }
  Unplaced in_faces, others;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v)
    if (!has_place(mesh.positions[v])) (used[v] ? in_faces : others).add(v);
  if (whole == nullptr)
    throw InputError(file, "", "has no face with a place: " + description(mesh, in_faces.count, in_faces.first, ""));
  if (others.count > 0)
    mesh.warnings.push_back(description(mesh, others.count, others.first, " that no face uses") +
                            ": they are left out of consideration");
  const std::string of_faces = in_faces.count > 0 ? description(mesh, in_faces.count, in_faces.first, "") : "";
  // A place within the mesh, so that its extent is that of the rest.
  const WorldPoint within = mesh.positions[(*whole)[0]];
  std::size_t faces = 0;
  for (Triangle& face : mesh.faces) {
    if (std::ranges::all_of(face, placed)) continue;
    ++faces;
    const auto instead = std::ranges::find_if(face, placed);
    const std::uint32_t other = instead != face.end() ? *instead : face[0];
    for (std::uint32_t& v : face)
      if (!placed(v)) v = other;
  }
  if (faces > 0)
    mesh.warnings.push_back(of_faces + ": the " + std::to_string(faces) +
                            " faces that use them are kept without an area, and no photo shows them");
  for (WorldPoint& p : mesh.positions)
    if (!has_place(p)) p = within;
}

}  // namespace gpvc::io
