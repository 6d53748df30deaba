// Reads the geometry of OBJ files.
#include <cstring>

#include "io/error.h"
#include "io/files/text_scan.h"
#include "io/meshes/mesh_file.h"

namespace gpvc::io {

namespace {

class ObjParser {
 public:
  ObjParser(const std::filesystem::path& file, std::string_view text) : file_(file), rest_(text) {}

  Mesh parse() {
    // A vertex takes at least 7 bytes ("v 0 0 0"); most files spend 25 or more on one, and half of that on a face.
    mesh_.positions.reserve(rest_.size() / 80);
    mesh_.faces.reserve(rest_.size() / 80);
    while (!rest_.empty()) {
      ++line_number_;
      const char* begin = rest_.data();
      std::string_view line = next_line(rest_);
      while (!line.empty() && (line.front() == ' ' || line.front() == '\t')) line.remove_prefix(1);
      if (line.size() < 2 || (line[1] != ' ' && line[1] != '\t') || (line[0] != 'v' && line[0] != 'f')) continue;
      const std::size_t first_line = line_number_;
      if (is_continued(line)) line = joined(begin);
      const char keyword = line.front();
      line.remove_prefix(1);
      keyword == 'v' ? vertex(line, first_line) : face(line, first_line);
    }
    if (highest_forward_ >= mesh_.positions.size() && highest_forward_line_ != 0)
      out_of_range(highest_forward_line_, static_cast<std::int64_t>(highest_forward_) + 1);
    if (mesh_.positions.empty() && mesh_.faces.empty())
      throw InputError(file_, "", "is no mesh that can be read: expected PLY, OBJ, STL, OFF, GLB or glTF");
    warn_of_lines(mesh_, lines_, "in line " + std::to_string(first_line_));
    return std::move(mesh_);
  }

 private:
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
    std::string_view whole = joined_;
    while (!whole.empty() && is_blank(whole.front())) whole.remove_prefix(1);
    return whole;
  }

  void vertex(std::string_view line, std::size_t at) {
    double values[3];
    for (double& value : values) {
      const std::string_view word = next_word(line);
      const std::optional<double> number = number_from(word);
      if (!number) fail(at, word.empty() ? "a vertex needs three coordinates" : quote(word) + " is not a coordinate");
      value = *number;
    }
    if (mesh_.positions.size() == kMaxElements) fail(at, "more than 2^32 - 2 vertices");
    const WorldPoint position{values[0], values[1], values[2]};
    check_position(file_, "line " + std::to_string(at) + ": ", mesh_.positions.size(), position);
    mesh_.positions.push_back(position);
  }

  void face(std::string_view line, std::size_t at) {
    std::uint32_t first = 0, previous = 0;
    std::size_t corners = 0;
    for (std::string_view word = next_word(line); !word.empty() && word.front() != '#'; word = next_word(line)) {
      const std::uint32_t corner = corner_of(word, at);
      if (corners == 0) first = corner;
      if (corners >= 2) {
        if (mesh_.faces.size() == kMaxElements) fail(at, "more than 2^32 - 2 triangles");
        mesh_.faces.push_back({first, previous, corner});
      }
      previous = corner;
      ++corners;
    }
    if (corners == 0) fail(at, "a face without vertices");
    note_source(mesh_, corners < 3 ? 0 : corners - 2, file_faces_++);
    if (corners < 3 && lines_++ == 0) first_line_ = at;
  }

  /// Vertex of "7", "7/1", "7//2", "7/1/2" or a negative index counted back from the last vertex.
  std::uint32_t corner_of(std::string_view word, std::size_t at) {
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
};

}  // namespace

Mesh read_obj(const std::filesystem::path& file, std::string_view bytes) { return ObjParser(file, bytes).parse(); }

}  // namespace gpvc::io
