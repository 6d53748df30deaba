#include "io/meshes/mesh_file.h"

#include "io/files/file_bytes.h"
#include "io/mesh.h"

namespace gpvc::io {

Mesh read_mesh(const std::filesystem::path& file) {
  const FileBytes bytes(file);
  std::string_view text = bytes.view();
  // Windows editors begin UTF-8 files with a byte order mark, which would hide the first word, such as an OBJ's first
  // v.
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  if (text.empty()) throw InputError(file, "", "is empty, expected a PLY or OBJ mesh");
  Mesh mesh = text.starts_with("ply\n") || text.starts_with("ply\r") || text.starts_with("ply ") || text == "ply"
                  ? read_ply(file, text)
                  : read_obj(file, text);
  if (mesh.faces.empty()) throw InputError(file, "", "has no faces");
  recut_concave(mesh);
  return mesh;
}

}  // namespace gpvc::io
