// Reads OFF, the Object File Format of Geomview in ASCII: geomview.org/docs/html/OFF.html.
//
//   [ST][C][N]OFF, then VERTICES FACES EDGES, on the same line or the next
//   a line a vertex: x y z, then what the letters stand for; a line a face: CORNERS INDEX ... and perhaps a colour
//
// '#' begins a comment. Files of four or n coordinates (4OFF, nOFF) and binary ones are refused.
#include "io/error.h"
#include "io/files/text_scan.h"
#include "io/meshes/mesh_file.h"

namespace gpvc::io {

namespace {

class OffParser {
 public:
  OffParser(const std::filesystem::path& file, std::string_view text) : file_(file), rest_(text) {}

  Mesh parse() {
    std::string_view header = line();
    const std::string_view word = next_word(header);
    if (word.find_first_of("4n") != std::string_view::npos)
      fail("is in " + std::string(word) + ", expected OFF of x y z");
    if (trimmed(header).starts_with("BINARY")) fail("is binary, expected ASCII");
    if (trimmed(header).empty()) header = line();
    std::array<std::uint64_t, 2> counts{};
    for (std::uint64_t& count : counts) {
      const auto number = integer_from<std::uint64_t>(next_word(header));
      if (!number || *number > kMaxElements) fail("expected the numbers of vertices, faces and edges");
      count = *number;
    }
    for (std::uint64_t v = 0; v < counts[0]; ++v) vertex();
    for (std::uint64_t f = 0; f < counts[1]; ++f) face(f);
    warn_of_lines(mesh_, lines_, "in line " + std::to_string(first_line_));
    return std::move(mesh_);
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw InputError(file_, "line " + std::to_string(line_number_), what);
  }

  /// The next line with something in it, without its comment; empty at the end.
  std::string_view line() {
    std::string_view found;
    while (found.empty() && !rest_.empty()) {
      found = next_line(rest_);
      found = trimmed(found.substr(0, found.find('#')));
      ++line_number_;
    }
    return found;
  }

  void vertex() {
    std::string_view text = line();
    if (text.empty()) fail("ends before its last vertex");
    std::array<double, 3> at{};
    for (double& value : at) {
      const std::optional<double> number = number_from(next_word(text));
      if (!number) fail("expected the coordinates x y z of a vertex");
      value = *number;
    }
    mesh_.positions.push_back({at[0], at[1], at[2]});
  }

  void face(std::uint64_t number) {
    std::string_view text = line();
    if (text.empty()) fail("ends before its last face");
    const auto corners = integer_from<std::uint32_t>(next_word(text));
    if (!corners) fail("expected the number of a face's corners");
    Triangle fan{};
    std::size_t triangles = 0;
    for (std::uint32_t k = 0; k < *corners; ++k) {
      const auto index = integer_from<std::uint64_t>(next_word(text));
      if (!index || *index >= mesh_.positions.size())
        fail("expected " + std::to_string(*corners) + " numbers of vertices below " +
             std::to_string(mesh_.positions.size()));
      const auto corner = static_cast<std::uint32_t>(*index);
      if (k < 2) {
        fan[k] = corner;
        continue;
      }
      fan[2] = corner;
      mesh_.faces.push_back(fan);
      fan[1] = corner;
      ++triangles;
    }
    if (triangles == 0 && lines_++ == 0) first_line_ = line_number_;
    note_source(mesh_, triangles, number);
  }

  const std::filesystem::path& file_;
  std::string_view rest_;
  std::size_t line_number_ = 0, lines_ = 0, first_line_ = 0;
  Mesh mesh_;
};

}  // namespace

bool is_off(std::string_view bytes) {
  std::string_view word = next_word(bytes);
  while (word.starts_with('#')) {  // a comment
    next_line(bytes);
    word = next_word(bytes);
  }
  return word.size() <= 8 && word.ends_with("OFF") &&
         word.substr(0, word.size() - 3).find_first_not_of("STCN4n") == std::string_view::npos;
}

Mesh read_off(const std::filesystem::path& file, std::string_view bytes) { return OffParser(file, bytes).parse(); }

}  // namespace gpvc::io
