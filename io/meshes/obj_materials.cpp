#include "io/meshes/obj_materials.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <system_error>

#include "io/error.h"
#include "io/file_bytes.h"
#include "io/files/paths.h"
#include "io/files/text_scan.h"
#include "io/meshes/mesh_file.h"

namespace gpvc::io {
namespace {

namespace fs = std::filesystem;

/// Options of a map_Kd that move a texture or change its colours, with the numbers that do not.
struct TextureOption {
  std::string_view name;
  std::array<double, 3> neutral;
};
constexpr TextureOption kTextureOptions[] = {
    {"-s", {1, 1, 1}}, {"-o", {0, 0, 0}}, {"-t", {0, 0, 0}}, {"-mm", {0, 1, 0}}};

/// Reads a map_Kd: options, each of which takes a word or up to three numbers, and the name of the image behind them.
void read_texture(const fs::path& file, std::string_view line, ObjMaterial& material) {
  material.clamped = false;
  for (line = trimmed(line); line.starts_with('-');) {
    std::string_view rest = line;
    const std::string_view name = next_word(rest);
    const auto* known = std::ranges::find(kTextureOptions, name, &TextureOption::name);
    const std::string_view word = next_word(rest);
    std::size_t count = 0;
    bool changes = false;
    std::string_view more = rest;
    for (auto number = number_from(word); number; number = number_from(next_word(more))) {
      changes |=
          known != std::end(kTextureOptions) && count < known->neutral.size() && *number != known->neutral[count];
      rest = more;
      ++count;
    }
    if (trimmed(rest).empty()) break;
    if (changes)
      throw InputError(file, "material " + material.name,
                       "the option " + std::string(trimmed(line.substr(0, line.size() - rest.size()))) +
                           " of its texture moves it or changes its colours, expected a texture without");
    if (name == "-clamp") material.clamped = word == "on";
    line = trimmed(rest);
  }
  material.image = line;
}

/// Adds the materials of a file. Lines may end in CR alone.
void read_library(const fs::path& file, std::vector<ObjMaterial>& materials) {
  const FileBytes bytes(file);
  for (std::string_view text = without_byte_order_mark(bytes.view()); !text.empty();) {
    std::string_view line = text.substr(0, text.find_first_of("\r\n"));
    text.remove_prefix(std::min(line.size() + 1, text.size()));
    const std::string_view keyword = next_word(line);
    if (keyword == "newmtl") materials.push_back({std::string(name_behind(line)), ""});
    if (keyword == "map_Kd" && !materials.empty()) read_texture(file, line, materials.back());
  }
}

}  // namespace

std::vector<ObjMaterial> read_materials(const fs::path& obj_file, const std::vector<std::string>& libraries) {
  std::vector<ObjMaterial> materials;
  const auto read = [&](std::string_view name) {
    const fs::path library = folder_of(obj_file) / with_slashes(name);
    refuse_special_file(library);
    if (is_file(library)) read_library(library, materials);
    return is_file(library);
  };
  for (std::string_view names : libraries)
    if (!read(names))
      while (!trimmed(names).empty()) read(next_word(names));
  return materials;
}

fs::path image_beside(const fs::path& model, const std::string& name) {
  const fs::path folder = model.parent_path(), path = with_slashes(name);
  std::error_code error;
  return fs::exists(folder / path, error) ? folder / path : folder / path.filename();
}

}  // namespace gpvc::io
