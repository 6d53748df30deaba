// Reads STL, binary and ASCII: triangles without shared vertices. "StereoLithography Interface Specification", 3D Systems
// 1989; fabbers.com/tech/STL_Format.
//
//   binary   80 bytes of anything; count as u32; a triangle: normal and three corners as 3 floats each, u16 of anything
//   ASCII    solid NAME / facet normal X Y Z / outer loop / vertex X Y Z (three) / endloop / endfacet / endsolid NAME
//
// Corners of the same coordinates become one vertex.
#include <array>
#include <cstring>

#include "io/error.h"
#include "io/files/paths.h"
#include "io/files/text_scan.h"
#include "io/meshes/merged_vertices.h"
#include "io/meshes/mesh_file.h"

namespace gpvc::io {

namespace {

constexpr std::size_t kHeader = 80, kTriangle = 50;

std::uint32_t stl_count(std::string_view bytes) {
  std::uint32_t count = 0;
  std::memcpy(&count, bytes.data() + kHeader, sizeof count);
  return count;
}

/// Some writers pad the end.
bool is_binary_stl(std::string_view bytes) {
  if (bytes.size() < kHeader + 4) return false;
  const std::size_t size = kHeader + 4 + kTriangle * std::size_t{stl_count(bytes)};
  return bytes.size() >= size && bytes.size() < size + kTriangle;
}

bool is_ascii_stl(std::string_view bytes) {
  const std::string begin = lower_case(trimmed(bytes.substr(0, 4096)));
  return begin.starts_with("solid") && begin.find("facet") != std::string::npos;
}

Mesh read_binary_stl(std::string_view bytes) {
  Mesh mesh;
  MergedVertices vertices(mesh.positions);
  const std::uint32_t count = stl_count(bytes);
  mesh.faces.reserve(count);
  vertices.reserve(count / 2);  // as a closed surface has
  for (std::uint32_t f = 0; f < count; ++f) {
    std::array<float, 12> values;  // normal, corners
    std::memcpy(values.data(), bytes.data() + kHeader + 4 + kTriangle * f, sizeof values);
    Triangle corners;
    for (std::size_t k = 0; k < 3; ++k) {
      corners[k] = vertices.add({values[3 + 3 * k], values[4 + 3 * k], values[5 + 3 * k]});
    }
    mesh.faces.push_back(corners);
  }
  return mesh;
}

Mesh read_ascii_stl(const std::filesystem::path& file, std::string_view text) {
  Mesh mesh;
  MergedVertices vertices(mesh.positions);
  Triangle corners{};
  std::size_t corner = 0, line_number = 0;
  const auto fail = [&](const std::string& what) {
    throw InputError(file, "line " + std::to_string(line_number), what);
  };
  while (!text.empty()) {
    std::string_view line = next_line(text);
    ++line_number;
    const std::string word = lower_case(std::string(next_word(line)));
    if (word == "vertex") {
      if (corner == 3) fail("expected endloop after three vertices");
      std::array<double, 3> at{};
      for (double& value : at) {
        const std::optional<double> number = number_from(next_word(line));
        if (!number) fail("expected three coordinates after 'vertex'");
        value = *number;
      }
      corners[corner++] = vertices.add({at[0], at[1], at[2]});
    } else if (word == "endloop") {
      if (corner != 3) fail("expected three vertices before endloop");
      mesh.faces.push_back(corners);
      corner = 0;
    }
  }
  if (corner != 0) fail("ends within a triangle");
  return mesh;
}

}  // namespace

bool is_stl(std::string_view bytes) {
  // Some binary files begin with "solid" too, and all have at least the size that their count tells.
  return is_binary_stl(bytes) || is_ascii_stl(bytes);
}

Mesh read_stl(const std::filesystem::path& file, std::string_view bytes) {
  return is_binary_stl(bytes) ? read_binary_stl(bytes) : read_ascii_stl(file, bytes);
}

}  // namespace gpvc::io
