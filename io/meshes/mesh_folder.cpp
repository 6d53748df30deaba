// Meshes in several files, and what metadata.xml says of them. The file is described in ContextCapture's manual ("3D mesh
// production formats") and written by other programs as well:
//
//   <ModelMetadata version="1"><SRS>EPSG:32631</SRS><SRSOrigin>448000,5411000,0</SRSOrigin>...</ModelMetadata>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>

#include "io/box.h"
#include "io/file_bytes.h"
#include "io/files/paths.h"
#include "io/files/text_scan.h"
#include "io/mesh.h"
#include "io/scenes/xml_file.h"

namespace gpvc::io {
namespace {

WorldPoint origin_from(const XmlFile& xml, const pugi::xml_node& root) {
  const pugi::xml_node node = root.child("SRSOrigin");
  if (!node) return {};
  std::string_view text = XmlFile::text(root, "SRSOrigin");
  std::array<double, 3> values{};
  for (double& value : values) {
    const std::size_t end = std::min(text.find(','), text.size());
    const std::optional<double> number = number_from(trimmed(text.substr(0, end)));
    if (!number || !std::isfinite(*number)) xml.fail(node, "expected SRSOrigin to be three numbers, X,Y,Z");
    value = *number;
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return {values[0], values[1], values[2]};
}

/// Versions of a mesh end where its photos do, up to some faces at the rim and strays below it. Tiles beside or above each
/// other share a rim alone, on one axis at least.
bool fill_same_place(const Box& a, const Box& b) {
  constexpr double kShare = 0.8;
  constexpr double WorldPoint::*kAxes[] = {&WorldPoint::x, &WorldPoint::y, &WorldPoint::z};
  return std::ranges::all_of(kAxes, [&](const auto axis) {
    const double shared = std::min(a.high.*axis, b.high.*axis) - std::max(a.low.*axis, b.low.*axis),
                 all = std::max(a.high.*axis, b.high.*axis) - std::min(a.low.*axis, b.low.*axis);
    return shared >= kShare * all;  // both are 0 where flat meshes lie in one plane
  });
}

void refuse_versions(std::span<const fs::path> files, std::span<const Mesh> meshes) {
  if (files.size() < 2) return;
  std::vector<Box> boxes(meshes.size());
  tbb::parallel_for(std::size_t{0}, meshes.size(),
                    [&](std::size_t m) { boxes[m] = box_of_faces(meshes[m], 0, meshes[m].faces.size()); });
  for (std::size_t m = 1; m < files.size(); ++m)
    for (std::size_t other = 0; other < m; ++other)
      if (fill_same_place(boxes[other], boxes[m]))
        throw InputError(files[m], "",
                         "fills the same place as " + files[other].string() +
                             ", as another version of the same mesh does; name the one that is meant");
}

}  // namespace

std::vector<Mesh> read_meshes(std::span<const std::vector<fs::path>> given) {
  std::vector<const fs::path*> files;
  for (const std::vector<fs::path>& some : given)
    for (const fs::path& file : some) files.push_back(&file);
  std::vector<Mesh> meshes(files.size());
  std::vector<std::exception_ptr> errors(files.size());
  tbb::parallel_for(std::size_t{0}, files.size(), [&](std::size_t m) {
    try {
      meshes[m] = read_mesh(*files[m]);
    } catch (...) {
      errors[m] = std::current_exception();  // of several, the first in their order is thrown, whichever came first
    }
  });
  for (const std::exception_ptr& error : errors)
    if (error) std::rethrow_exception(error);
  std::size_t first = 0;
  for (const std::vector<fs::path>& some : given) {
    refuse_versions(some, std::span(meshes).subspan(first, some.size()));
    first += some.size();
  }
  return meshes;
}

std::vector<fs::path> mesh_files(const fs::path& file_or_folder) {
  if (!is_folder(file_or_folder)) return {file_or_folder};
  std::vector<fs::path> files;
  std::error_code failed;
  for (fs::recursive_directory_iterator entry(file_or_folder, failed), end; entry != end && !failed;
       entry.increment(failed)) {
    // A result of ours, whose model is no tile of what it came from.
    if (is_folder(entry->path()) && is_file(entry->path() / "run.json")) entry.disable_recursion_pending();
    const std::string extension = lower_case(entry->path().extension().string());
    if ((extension == ".ply" || extension == ".obj") && is_file(entry->path()) && !is_apple_double(entry->path()))
      files.push_back(entry->path());
  }
  if (failed) throw InputError(file_or_folder, "", "cannot be read: " + failed.message());
  if (files.empty()) throw InputError(file_or_folder, "", "holds no mesh, expected files .ply or .obj in it");
  std::ranges::sort(files);
  return files;
}

std::optional<MeshOrigin> read_mesh_origin(const fs::path& mesh) {
  std::error_code failed;
  // A mesh that is a link may have the file beside the link or beside what it links to.
  for (const fs::path& path : {fs::absolute(mesh, failed).lexically_normal(), fs::weakly_canonical(mesh, failed)}) {
    if (path.empty()) continue;
    fs::path folder = is_folder(path) ? path : path.parent_path();
    for (int level = 0; level <= 2; ++level, folder = folder.parent_path()) {
      const fs::path file = folder / "metadata.xml";
      if (!is_file(file) || xml_root(file) != "ModelMetadata") continue;
      const FileBytes bytes(file);
      const XmlFile xml(file, bytes.view());
      const pugi::xml_node root = xml.root("ModelMetadata");
      return MeshOrigin{file, std::string(XmlFile::text(root, "SRS")), origin_from(xml, root)};
    }
  }
  return std::nullopt;
}

}  // namespace gpvc::io
