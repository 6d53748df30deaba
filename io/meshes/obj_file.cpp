// Reads OBJ files: geometry, texture coordinates and the names of materials.
#include <algorithm>

#include "io/error.h"
#include "io/files/text_scan.h"
#include "io/meshes/mesh_file.h"

namespace gpvc::io {

namespace {

class ObjParser {
 public:
  ObjParser(const std::filesystem::path& file, std::string_view text, ObjTexture* texture)
      : file_(file), rest_(text), texture_(texture) {}

  Mesh parse() {
    // A vertex takes at least 7 bytes ("v 0 0 0"); most files spend 25 or more on one, and half of that on a face.
    mesh_.positions.reserve(rest_.size() / 80);
    mesh_.faces.reserve(rest_.size() / 80);
    while (!rest_.empty()) {
      ++line_number_;
      const char* begin = rest_.data();
      std::string_view line = next_line(rest_);
      std::string_view keyword = next_word(line);
      if (line.empty() || !is_read(keyword)) continue;
      const std::size_t first_line = line_number_;
      if (is_continued(line)) {
        line = joined(begin);
        keyword = next_word(line);
      }
      statement(keyword, line, first_line);
    }
    if (highest_forward_ >= mesh_.positions.size() && highest_forward_line_ != 0)
      out_of_range(highest_forward_line_, static_cast<std::int64_t>(highest_forward_) + 1);
    if (mesh_.positions.empty() && mesh_.faces.empty())
      throw InputError(file_, "", "is no mesh that can be read: expected PLY, OBJ, STL, OFF, GLB or glTF");
    warn_of_lines(mesh_, lines_, "in line " + std::to_string(first_line_));
    return std::move(mesh_);
  }

 private:
  static constexpr std::uint32_t kNone = ObjTexture::kNone;
  struct Corner {
    std::uint32_t vertex = 0, texcoord = kNone;
  };

  bool is_read(std::string_view keyword) const {
    if (keyword == "v" || keyword == "f") return true;
    return texture_ != nullptr && (keyword == "vt" || keyword == "usemtl" || keyword == "mtllib");
  }

  void statement(std::string_view keyword, std::string_view line, std::size_t at) {
    if (keyword == "v") return vertex(line, at);
    if (keyword == "f") return face(line, at);
    if (keyword == "vt") return texcoord(line, at);
    const std::string name(name_behind(line));
    if (keyword == "usemtl")
      material_ =
          texture_->materials.try_emplace(name, static_cast<std::uint32_t>(texture_->materials.size())).first->second;
    else if (std::ranges::find(texture_->libraries, name) == texture_->libraries.end())
      texture_->libraries.push_back(name);
  }

  /// Blanks may follow the '\', though by the letter it ends the line.
  static bool is_continued(std::string_view line) {
    const std::size_t last = line.find_last_not_of(" \t");
    return last != std::string_view::npos && line[last] == '\\';
  }

  /// The statement that starts at `begin` with its continuation lines, each '\' before a line end blanked.
  std::string_view joined(const char* begin) {
    joined_.clear();
    std::string_view line;
    std::string_view text(begin, static_cast<std::size_t>(rest_.data() + rest_.size() - begin));
    --line_number_;
    do {
      line = next_line(text);
      ++line_number_;
      joined_ += line;
      if (is_continued(line)) joined_[joined_.find_last_of('\\')] = ' ';
    } while (is_continued(line) && !text.empty());
    rest_ = text;
    return joined_;
  }

  void vertex(std::string_view line, std::size_t at) {
    double values[3];
    for (double& value : values) value = coordinate(line, at, "a vertex needs three coordinates");
    if (mesh_.positions.size() == kMaxElements) fail(at, "more than 2^32 - 2 vertices");
    mesh_.positions.push_back({values[0], values[1], values[2]});
  }

  /// v, if it is missing, is 0; w is of no use.
  void texcoord(std::string_view line, std::size_t at) {
    const double u = coordinate(line, at, "a texture coordinate needs a number");
    const std::string_view more = trimmed(line);
    const double v = more.empty() || more.front() == '#' ? 0 : coordinate(line, at, "");
    if (texture_->texcoords.size() == kMaxElements) fail(at, "more than 2^32 - 2 texture coordinates");
    texture_->texcoords.push_back({static_cast<float>(u), static_cast<float>(1 - v)});
    if (texture_->states_all) texture_->stated.push_back({u, v});
  }

  double coordinate(std::string_view& line, std::size_t at, const char* missing) const {
    const std::string_view word = next_word(line);
    const std::optional<double> number = number_from(word);
    if (!number) fail(at, word.empty() ? missing : quote(word) + " is not a coordinate");
    return *number;
  }

  void face(std::string_view line, std::size_t at) {
    Corner first, previous;
    std::size_t corners = 0;
    for (std::string_view word = next_word(line); !word.empty() && word.front() != '#'; word = next_word(line)) {
      const Corner corner{vertex_of(word, at), texture_ != nullptr ? texcoord_of(word, at) : kNone};
      if (corners == 0) first = corner;
      if (corners >= 2) {
        if (mesh_.faces.size() == kMaxElements) fail(at, "more than 2^32 - 2 triangles");
        mesh_.faces.push_back({first.vertex, previous.vertex, corner.vertex});
        if (texture_ != nullptr) {
          texture_->corners.push_back({first.texcoord, previous.texcoord, corner.texcoord});
          texture_->material.push_back(material_);
        }
      }
      previous = corner;
      ++corners;
    }
    if (corners == 0) fail(at, "a face without vertices");
    note_source(mesh_, corners < 3 ? 0 : corners - 2, file_faces_++);
    if (corners < 3 && lines_++ == 0) first_line_ = at;
  }

  /// Vertex of "7", "7/1", "7//2", "7/1/2" or a negative index counted back from the last vertex.
  std::uint32_t vertex_of(std::string_view word, std::size_t at) {
    const std::optional<std::int64_t> parsed = integer_from(word.substr(0, word.find('/')));
    if (!parsed) fail(at, quote(word) + " is not a vertex of a face");
    const auto count = static_cast<std::int64_t>(mesh_.positions.size());
    const std::int64_t vertex = *parsed < 0 ? count + *parsed : *parsed - 1;
    if (*parsed == 0 || vertex < 0 || vertex > static_cast<std::int64_t>(kMaxElements)) out_of_range(at, *parsed);
    if (vertex >= count && static_cast<std::uint64_t>(vertex) >= highest_forward_) {
      // Some writers list vertices after the faces: decided at the end of the file.
      highest_forward_ = static_cast<std::uint64_t>(vertex);
      highest_forward_line_ = at;
    }
    return static_cast<std::uint32_t>(vertex);
  }

  /// Texture coordinate of "7/1" or "7/1/2", which may come later; kNone of "7", "7//2" and "7/0".
  std::uint32_t texcoord_of(std::string_view word, std::size_t at) const {
    const std::size_t slash = word.find('/');
    if (slash == std::string_view::npos || slash + 1 == word.size() || word[slash + 1] == '/') return kNone;
    const std::string_view number = word.substr(slash + 1, word.find('/', slash + 1) - slash - 1);
    const std::optional<std::int64_t> parsed = integer_from(number);
    if (!parsed) fail(at, quote(word) + " has no number of a texture coordinate");
    const auto count = static_cast<std::int64_t>(texture_->texcoords.size());
    const std::int64_t texcoord = *parsed < 0 ? count + *parsed : *parsed - 1;
    if (*parsed == 0) return kNone;
    if (texcoord < 0 || texcoord >= kNone)
      fail(at, "texture coordinate " + std::to_string(*parsed) + " of a face does not exist, the file has " +
                   std::to_string(count) + " up to there");
    return static_cast<std::uint32_t>(texcoord);
  }

  [[noreturn]] void out_of_range(std::size_t line, std::int64_t vertex) const {
    fail(line, "vertex " + std::to_string(vertex) + " of a face does not exist, the file has " +
                   std::to_string(mesh_.positions.size()) + " vertices up to there");
  }
  [[noreturn]] void fail(std::size_t line, const std::string& reason) const {
    throw InputError(file_, "line " + std::to_string(line), reason);
  }

  const std::filesystem::path& file_;
  std::string_view rest_;
  std::size_t line_number_ = 0;
  std::string joined_;
  std::uint64_t highest_forward_ = 0;
  std::size_t highest_forward_line_ = 0;
  std::size_t file_faces_ = 0;
  std::size_t lines_ = 0, first_line_ = 0;  ///< faces of fewer than three vertices, and where the first one is
  Mesh mesh_;
  ObjTexture* texture_;  ///< null: not read
  std::uint32_t material_ = kNone;
};

}  // namespace

Mesh read_obj(const std::filesystem::path& file, std::string_view bytes, ObjTexture* texture) {
  return ObjParser(file, bytes, texture).parse();
}

}  // namespace gpvc::io
