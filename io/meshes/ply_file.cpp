// PLY, after Greg Turk's description: a text header that declares elements and their properties, then the elements in
// that order, as text or packed binary.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <span>
#include <utility>

#include "io/error.h"
#include "io/files/text_scan.h"
#include "io/meshes/mesh_file.h"

namespace gpvc::io {

namespace {

enum class Scalar { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

constexpr std::size_t size_of(Scalar type) {
  constexpr std::array<std::size_t, 8> kSizes{1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[static_cast<std::size_t>(type)];
}

constexpr bool is_integer(Scalar type) { return type < Scalar::float32; }

struct Property {
  std::string name;
  Scalar type = Scalar::float32;     ///< of the value, or of the list's items
  std::optional<Scalar> count_type;  ///< set for lists
};

struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;

  std::optional<std::size_t> find(std::initializer_list<std::string_view> names) const {
    for (std::size_t i = 0; i < properties.size(); ++i)
      if (std::find(names.begin(), names.end(), properties[i].name) != names.end()) return i;
    return std::nullopt;
  }
};

enum class Encoding { ascii, little, big };

struct Header {
  Encoding encoding = Encoding::ascii;
  std::vector<Element> elements;
  std::size_t size = 0;  ///< bytes up to the first element
  std::size_t lines = 0;
  std::vector<std::string> texture_files;
  std::vector<std::string> warnings;
};

// --- header

class HeaderParser {
 public:
  HeaderParser(const std::filesystem::path& file, std::string_view text) : file_(file), text_(text) {}

  Header parse() {
    std::string_view rest = text_;
    bool have_format = false;
    for (bool first = true;; first = false) {
      ++header_.lines;
      if (rest.find('\n') == std::string_view::npos) fail("the file ends inside the header");
      std::string_view line = next_line(rest);
      const std::string_view keyword = next_word(line);
      if (first) {
        if (keyword != "ply") fail("expected 'ply'");
      } else if (keyword == "end_header") {
        break;
      } else if (keyword == "format") {
        header_.encoding = encoding_from(next_word(line));
        have_format = true;
      } else if (keyword == "element") {
        element(line);
      } else if (keyword == "property") {
        property(line);
      } else if (keyword == "comment") {
        if (next_word(line) == "TextureFile") header_.texture_files.emplace_back(trimmed(line));
      } else if (!keyword.empty() && keyword != "obj_info") {
        // Some versions of Blender forget the word 'comment' before who they are.
        if (!header_.elements.empty()) fail("expected a header keyword, found " + quote(keyword));
        header_.warnings.push_back("line " + std::to_string(header_.lines) + " of the header, which begins with " +
                                   quote(keyword) + ", is taken for a comment");
      }
    }
    if (!have_format) fail("the header has no format line");
    header_.size = static_cast<std::size_t>(rest.data() - text_.data());
    return std::move(header_);
  }

 private:
  Encoding encoding_from(std::string_view word) const {
    if (word == "ascii") return Encoding::ascii;
    if (word == "binary_little_endian") return Encoding::little;
    if (word == "binary_big_endian") return Encoding::big;
    fail("expected format ascii, binary_little_endian or binary_big_endian, found " + quote(word));
  }

  void element(std::string_view line) {
    Element element;
    element.name = next_word(line);
    const std::string_view count = next_word(line);
    const std::optional<std::uint64_t> number = integer_from<std::uint64_t>(count);
    if (element.name.empty() || !number) fail("expected 'element NAME COUNT', found the count " + quote(count));
    element.count = *number;
    header_.elements.push_back(std::move(element));
  }

  void property(std::string_view line) {
    if (header_.elements.empty()) fail("a property before the first element");
    Property property;
    std::string_view word = next_word(line);
    if (word == "list") {
      property.count_type = type_from(next_word(line));
      if (!is_integer(*property.count_type)) fail("the count of a list must have an integer type");
      word = next_word(line);
    }
    property.type = type_from(word);
    property.name = next_word(line);
    if (property.name.empty()) fail("a property without a name");
    header_.elements.back().properties.push_back(std::move(property));
  }

  Scalar type_from(std::string_view word) const {
    constexpr std::array<std::array<std::string_view, 2>, 8> kNames{{{"char", "int8"},
                                                                     {"uchar", "uint8"},
                                                                     {"short", "int16"},
                                                                     {"ushort", "uint16"},
                                                                     {"int", "int32"},
                                                                     {"uint", "uint32"},
                                                                     {"float", "float32"},
                                                                     {"double", "float64"}}};
    for (std::size_t i = 0; i < kNames.size(); ++i)
      if (word == kNames[i][0] || word == kNames[i][1]) return static_cast<Scalar>(i);
    fail("expected a property type (char .. double), found " + quote(word));
  }

  [[noreturn]] void fail(const std::string& reason) const {
    throw InputError(file_, "line " + std::to_string(header_.lines), reason);
  }

  const std::filesystem::path& file_;
  std::string_view text_;
  Header header_;
};

// --- values, one source an encoding; both answer number(type), integer(type) and count(type)

class AsciiValues {
 public:
  /// \param by_lines every element has a line of its own, which may go on with values that the header does not declare
  AsciiValues(const std::filesystem::path& file, std::string_view text, const Header& header, bool by_lines)
      : file_(file),
        rest_(text.substr(header.size)),
        body_(rest_.data()),
        first_line_(header.lines + 1),
        by_lines_(by_lines) {}
  /// Every value takes a digit and a blank.
  std::uint64_t capacity() const { return (rest_.size() + 1) / 2; }
  std::size_t bytes_of(Scalar) const { return 1; }

  double number(Scalar) {
    const std::string_view word = next();
    const std::optional<double> value = number_from(word);
    if (!value) fail("expected a number, found " + quote(word));
    return *value;
  }
  std::int64_t integer(Scalar) {
    const std::string_view word = next();
    const std::optional<std::int64_t> value = integer_from(word);
    if (!value) fail("expected an integer, found " + quote(word));
    return *value;
  }
  void skip(Scalar type, std::uint64_t count) {
    for (; count > 0; --count) number(type);
  }
  void end_element() {
    if (!by_lines_) return;
    if (!trimmed(next_line(rest_)).empty()) ++undeclared_;
    within_element_ = false;
  }
  std::string warning() const {
    return undeclared_ == 0
               ? ""
               : "values that the header does not declare are left out in " + std::to_string(undeclared_) + " lines";
  }
  std::string place() const {
    return "line " + std::to_string(first_line_ + static_cast<std::size_t>(std::count(body_, rest_.data(), '\n')));
  }
  [[noreturn]] void fail(const std::string& reason) const { throw InputError(file_, place(), reason); }

 private:
  std::string_view next() {
    const char* before = rest_.data();
    const std::string_view word = next_word(rest_);
    if (word.empty()) fail("the file ends before the last element that its header declares");
    if (by_lines_ && within_element_ && std::find(before, word.data(), '\n') != word.data())
      fail("the line ends before the values that the header declares");
    within_element_ = true;
    return word;
  }

  const std::filesystem::path& file_;
  std::string_view rest_;
  const char* body_;
  std::size_t first_line_;
  bool by_lines_;
  bool within_element_ = false;  ///< a value of it has been read
  std::uint64_t undeclared_ = 0;
};

template <bool kSwap>
class BinaryValues {
 public:
  BinaryValues(const std::filesystem::path& file, std::string_view bytes, const Header& header)
      : file_(file), begin_(bytes.data()), at_(bytes.data() + header.size), end_(bytes.data() + bytes.size()) {}

  std::uint64_t capacity() const { return static_cast<std::uint64_t>(end_ - at_); }
  std::size_t bytes_of(Scalar type) const { return size_of(type); }

  double number(Scalar type) {
    if (type == Scalar::float32) return static_cast<double>(take<float>());
    return type == Scalar::float64 ? take<double>() : static_cast<double>(integer(type));
  }
  std::int64_t integer(Scalar type) {
    switch (type) {
      case Scalar::int8:
        return take<std::int8_t>();
      case Scalar::uint8:
        return take<std::uint8_t>();
      case Scalar::int16:
        return take<std::int16_t>();
      case Scalar::uint16:
        return take<std::uint16_t>();
      case Scalar::int32:
        return take<std::int32_t>();
      default:
        return take<std::uint32_t>();
    }
  }
  void skip(Scalar type, std::uint64_t count) {
    if (count > capacity() / size_of(type)) fail_at_end();
    at_ += count * size_of(type);
  }
  void end_element() {}
  std::string warning() const { return ""; }
  std::string place() const { return "byte " + std::to_string(at_ - begin_); }
  [[noreturn]] void fail(const std::string& reason) const { throw InputError(file_, place(), reason); }

 private:
  template <typename T>
  T take() {
    if (static_cast<std::size_t>(end_ - at_) < sizeof(T)) fail_at_end();
    std::array<char, sizeof(T)> raw;
    std::memcpy(raw.data(), at_, sizeof(T));
    if constexpr (kSwap) std::reverse(raw.begin(), raw.end());
    at_ += sizeof(T);
    return std::bit_cast<T>(raw);
  }
  [[noreturn]] void fail_at_end() const { fail("the file ends before the last element that its header declares"); }

  const std::filesystem::path& file_;
  const char *begin_, *at_, *end_;
};

// --- elements

template <typename Values>
class MeshReader {
 public:
  MeshReader(const std::filesystem::path& file, const Header& header, Values values, PlyTexture* texture)
      : file_(file), header_(header), values_(values), texture_(texture) {
    if (texture_ != nullptr) *texture_ = {header.texture_files, {}, {}, {}};
  }

  Mesh read() {
    for (const Element& element : header_.elements)
      if (element.name == "vertex") vertex_count_ = element.count;
    for (const Element& element : header_.elements) {
      check_count(element);
      if (element.name == "vertex" && mesh_.positions.empty())
        read_vertices(element);
      else if (element.name == "face" && mesh_.faces.empty())
        read_faces(element);
      else if (element.name == "tristrips" && mesh_.faces.empty())
        read_strips(element);
      else
        skip(element);
    }
    mesh_.warnings = header_.warnings;
    warn_of_lines(mesh_, lines_, "face " + std::to_string(first_line_));
    if (const std::string undeclared = values_.warning(); !undeclared.empty()) mesh_.warnings.push_back(undeclared);
    return std::move(mesh_);
  }

 private:
  /// Before anything of that size is allocated: can the rest of the file hold so many?
  void check_count(const Element& element) const {
    std::uint64_t least = 0;
    for (const Property& property : element.properties)
      least += values_.bytes_of(property.count_type.value_or(property.type));
    if (least > 0 && element.count > values_.capacity() / least)
      values_.fail("the header declares " + std::to_string(element.count) + " of element " + quote(element.name) +
                   ", the rest of the file cannot hold so many");
    if (element.count > kMaxElements && (element.name == "vertex" || element.name == "face"))
      values_.fail("more than 2^32 - 2 elements " + quote(element.name));
  }

  void read_vertices(const Element& element) {
    const std::size_t none = element.properties.size();
    std::array<std::size_t, 5> axes{none, none, none, none, none};  // x, y, z, u, v
    constexpr std::array<std::string_view, 3> kNames{"x", "y", "z"};
    for (std::size_t i = 0; i < 3; ++i) {
      const std::optional<std::size_t> found = element.find({kNames[i]});
      if (!found || element.properties[*found].count_type)
        throw InputError(file_, "", "element 'vertex' has no scalar property '" + std::string(kNames[i]) + "'");
      axes[i] = *found;
    }
    const bool has_uv = texture_ != nullptr && find_uv(element, axes[3], axes[4]);
    mesh_.positions.reserve(element.count);
    for (std::uint64_t v = 0; v < element.count; ++v) {
      std::array<double, 5> position{};
      for (std::size_t i = 0; i < element.properties.size(); ++i) {
        const Property& property = element.properties[i];
        const std::size_t axis = static_cast<std::size_t>(std::find(axes.begin(), axes.end(), i) - axes.begin());
        if (axis < axes.size())
          position[axis] = values_.number(property.type);
        else
          skip(property);
      }
      values_.end_element();
      mesh_.positions.push_back({position[0], position[1], position[2]});
      if (has_uv) texture_->vertices.push_back({static_cast<float>(position[3]), static_cast<float>(position[4])});
    }
  }

  /// By the names that Blender, others and MeshLab give them.
  static bool find_uv(const Element& element, std::size_t& u, std::size_t& v) {
    constexpr std::array<std::array<std::string_view, 2>, 3> kPairs{
        {{"s", "t"}, {"u", "v"}, {"texture_u", "texture_v"}}};
    for (const auto& [name_u, name_v] : kPairs) {
      const std::optional<std::size_t> first = element.find({name_u}), second = element.find({name_v});
      if (!first || !second || element.properties[*first].count_type || element.properties[*second].count_type)
        continue;
      u = *first;
      v = *second;
      return true;
    }
    return false;
  }

  void read_faces(const Element& element) {
    const std::optional<std::size_t> corners = element.find({"vertex_indices", "vertex_index"});
    if (!corners || !element.properties[*corners].count_type || !is_integer(element.properties[*corners].type))
      throw InputError(file_, "", "element 'face' has no list of integers 'vertex_indices' or 'vertex_index'");
    const std::size_t none = element.properties.size();
    std::size_t texcoords = none, page = none;
    if (texture_ != nullptr) {
      texcoords = element.find({"texcoord"}).value_or(none);
      page = element.find({"texnumber"}).value_or(none);
      if (texcoords != none && !element.properties[texcoords].count_type) texcoords = none;
      if (page != none && element.properties[page].count_type) page = none;
    }
    mesh_.faces.reserve(element.count);
    std::vector<float> uv;
    for (std::uint64_t f = 0; f < element.count; ++f) {
      const std::size_t first = mesh_.faces.size();
      std::int64_t number = 0;
      uv.clear();
      for (std::size_t i = 0; i < element.properties.size(); ++i) {
        const Property& property = element.properties[i];
        if (i == *corners)
          read_polygon(property, f);
        else if (i == texcoords)
          read_list(property, uv);
        else if (i == page)
          number = static_cast<std::int64_t>(values_.number(property.type));
        else
          skip(property);
      }
      values_.end_element();
      if (texture_ != nullptr) add_texture(f, mesh_.faces.size() - first, number, uv);
    }
  }

  void read_list(const Property& property, std::vector<float>& list) {
    std::int64_t count = values_.integer(*property.count_type);
    if (count < 0) values_.fail("a list of " + std::to_string(count) + " items");
    for (; count > 0; --count) list.push_back(static_cast<float>(values_.number(property.type)));
  }

  /// Of a polygon that was cut into a fan of triangles. `uv`: two numbers a corner, or none at all.
  void add_texture(std::uint64_t face, std::size_t triangles, std::int64_t page, const std::vector<float>& uv) {
    if (triangles == 0) return;
    const std::size_t expected = 2 * (triangles + 2);
    if (!uv.empty() && uv.size() != expected)
      face_error(face, "has " + std::to_string(uv.size()) + " texture coordinates, expected " +
                           std::to_string(expected) + ", two a corner, or none");
    if (!std::ranges::all_of(uv, [](float value) { return std::isfinite(value); }))
      face_error(face, "has a texture coordinate that is not finite");
    if (page >= static_cast<std::int64_t>(texture_->files.size()) && !uv.empty() && !texture_->files.empty())
      face_error(face, "shows texture " + std::to_string(page) + ", the header names " +
                           std::to_string(texture_->files.size()));
    const auto at = [&](std::size_t corner) {
      return uv.empty() ? TexCoord{NAN, NAN} : TexCoord{uv[2 * corner], uv[2 * corner + 1]};
    };
    for (std::size_t i = 0; i < triangles; ++i) {
      texture_->corners.push_back({at(0), at(i + 1), at(i + 2)});
      texture_->page.push_back(page);
    }
  }

  /// Strips of triangles, each of which shares an edge with the one before; -1 begins another strip.
  void read_strips(const Element& element) {
    const std::optional<std::size_t> list = element.find({"vertex_indices", "vertex_index"});
    if (!list || !element.properties[*list].count_type || !is_integer(element.properties[*list].type))
      throw InputError(file_, "", "element 'tristrips' has no list of integers 'vertex_indices' or 'vertex_index'");
    for (std::uint64_t s = 0; s < element.count; ++s) {
      for (std::size_t i = 0; i < element.properties.size(); ++i) {
        if (i == *list)
          read_strip(element.properties[i]);
        else
          skip(element.properties[i]);
      }
      values_.end_element();
    }
  }

  void read_strip(const Property& property) {
    const std::int64_t count = values_.integer(*property.count_type);
    if (count < 0) values_.fail("a strip of " + std::to_string(count) + " vertices");
    std::uint32_t before = 0, last = 0;
    std::uint64_t length = 0;  // of this strip so far
    for (std::int64_t i = 0; i < count; ++i) {
      const std::int64_t vertex = values_.integer(property.type);
      if (vertex == -1) {
        length = 0;
        continue;
      }
      const std::uint32_t next = checked_corner(vertex, mesh_.faces.size());
      if (length >= 2) {
        if (mesh_.faces.size() == kMaxElements) face_error(mesh_.faces.size(), "is beyond 2^32 - 2 triangles");
        // Every other triangle of a strip is the other way round. Strips are joined by triangles without an area.
        const Triangle face = length % 2 == 0 ? Triangle{before, last, next} : Triangle{last, before, next};
        if (face[0] != face[1] && face[1] != face[2] && face[0] != face[2]) mesh_.faces.push_back(face);
      }
      before = std::exchange(last, next);
      ++length;
    }
  }

  void read_polygon(const Property& property, std::uint64_t face) {
    const std::int64_t count = values_.integer(*property.count_type);
    if (count < 0) face_error(face, "has " + std::to_string(count) + " vertices");
    if (count < 3) {
      for (std::int64_t i = 0; i < count; ++i) corner(property.type, face);
      if (lines_++ == 0) first_line_ = face;
      return note_source(mesh_, 0, face);
    }
    const std::uint32_t first = corner(property.type, face);
    std::uint32_t previous = corner(property.type, face);
    for (std::int64_t i = 2; i < count; ++i) {
      const std::uint32_t next = corner(property.type, face);
      if (mesh_.faces.size() == kMaxElements) face_error(face, "is beyond 2^32 - 2 triangles");
      mesh_.faces.push_back({first, previous, next});
      previous = next;
    }
    note_source(mesh_, static_cast<std::size_t>(count - 2), face);
  }

  std::uint32_t corner(Scalar type, std::uint64_t face) { return checked_corner(values_.integer(type), face); }

  std::uint32_t checked_corner(std::int64_t vertex, std::uint64_t face) const {
    if (vertex < 0 || static_cast<std::uint64_t>(vertex) >= vertex_count_)
      face_error(face, "refers to vertex " + std::to_string(vertex) + ", the mesh has " +
                           std::to_string(vertex_count_) + " vertices");
    return static_cast<std::uint32_t>(vertex);
  }

  void skip(const Property& property) {
    if (!property.count_type) return values_.skip(property.type, 1);
    const std::int64_t count = values_.integer(*property.count_type);
    if (count < 0) values_.fail("a list of " + std::to_string(count) + " items");
    values_.skip(property.type, static_cast<std::uint64_t>(count));
  }

  void skip(const Element& element) {
    if (element.properties.empty()) return;
    for (std::uint64_t i = 0; i < element.count; ++i) {
      for (const Property& property : element.properties) skip(property);
      values_.end_element();
    }
  }

  [[noreturn]] void face_error(std::uint64_t face, const std::string& reason) const {
    throw InputError(file_, "face " + std::to_string(face), reason);
  }

  const std::filesystem::path& file_;
  const Header& header_;
  Values values_;
  PlyTexture* texture_;
  std::uint64_t vertex_count_ = 0;
  std::uint64_t lines_ = 0, first_line_ = 0;  ///< faces of fewer than three vertices, and the first one
  Mesh mesh_;
};

bool has_line_for_each_element(std::string_view body, const Header& header) {
  std::uint64_t elements = 0, lines = 0;
  for (const Element& element : header.elements) elements += element.count;
  while (!body.empty()) lines += trimmed(next_line(body)).empty() ? 0 : 1;
  return lines == elements;
}

/// Some writers add values that the header does not declare, MeshLab the colours of wedges: where each element has a line,
/// they are what follows on it. They could be taken for faces, so that lines go first. Otherwise values may be on any.
Mesh read_ascii(const std::filesystem::path& file, std::string_view bytes, const Header& header, PlyTexture* texture) {
  if (has_line_for_each_element(bytes.substr(header.size), header)) try {
      return MeshReader(file, header, AsciiValues(file, bytes, header, true), texture).read();
    } catch (const InputError&) {
    }
  return MeshReader(file, header, AsciiValues(file, bytes, header, false), texture).read();
}

}  // namespace

Mesh read_ply(const std::filesystem::path& file, std::string_view bytes, PlyTexture* texture) {
  const Header header = HeaderParser(file, bytes).parse();
  switch (header.encoding) {
    case Encoding::ascii:
      return read_ascii(file, bytes, header, texture);
    case Encoding::little:
      return MeshReader(file, header, BinaryValues<false>(file, bytes, header), texture).read();
    case Encoding::big:
      return MeshReader(file, header, BinaryValues<true>(file, bytes, header), texture).read();
  }
  throw InputError(file, "", "has an unknown encoding");
}

}  // namespace gpvc::io
