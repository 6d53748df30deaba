// Pages for texture coordinates that a mesh already has.
#include "io/uv_layout.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include "io/error.h"
#include "io/files/paths.h"
#include "io/files/text_scan.h"
#include "io/number_text.h"

namespace gpvc::io {
namespace {

/// What rounding leaves beyond the rim of a tile.
constexpr double kRounding = 1e-4;
constexpr int kUdimColumns = 10, kFirstUdim = 1001;
constexpr std::size_t kMostPages = 1000;
constexpr int kMostEdge = 32768;  ///< of a page

/// The unit square of a face, by its lower left corner.
struct Tile {
  double u = 0, v = 0;
  bool is_first() const { return u == 0 && v == 0; }
};

/// The whole number below the middle of two coordinates. One on a rim belongs to the square before it, as 1 belongs to 0 .. 1.
double square_of(double low, double high) {
  const double middle = (low + high) / 2, whole = std::floor(middle);
  return middle == whole && middle > 0 ? whole - 1 : whole;
}

/// A name that file systems take everywhere.
std::string file_part(const std::string& name) {
  constexpr std::size_t kLongest = 60;
  std::string part;
  for (const char c : name.substr(0, kLongest)) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-';
    part += plain ? c : '_';
  }
  return part.empty() ? "material" : part;
}

/// Gives each name that was taken already a number.
class UniqueNames {
 public:
  std::string take(const std::string& wanted) {
    std::string name = wanted;
    for (std::size_t n = 2; !taken_.insert(lower_case(name)).second; ++n) name = wanted + "_" + std::to_string(n);
    return name;
  }

 private:
  std::set<std::string> taken_;
};

class LayoutMaker {
 public:
  LayoutMaker(const StatedUv& uv, const UvPageSize& size, const fs::path& file)
      : uv_(uv), size_(size), file_(file), tiles_(uv.face_texcoords.size()) {}

  UvLayout make() {
    find_tiles();
    add_pages();
    place_faces();
    return std::move(layout_);
  }

 private:
  bool has_coordinates(std::size_t face) const {
    return std::ranges::all_of(uv_.face_texcoords[face], [&](std::uint32_t t) {
      return t < uv_.texcoords.size() && std::isfinite(uv_.texcoords[t][0]) && std::isfinite(uv_.texcoords[t][1]);
    });
  }

  std::uint32_t material_of(std::size_t face) const {
    const std::uint32_t material = uv_.face_material.empty() ? StatedUv::kNone : uv_.face_material[face];
    return material < uv_.materials.size() ? material : StatedUv::kNone;
  }

  Tile tile_of(std::size_t face) const {
    std::array<double, 2> tile{};
    for (std::size_t k = 0; k < 2; ++k) {
      double low = std::numeric_limits<double>::infinity(), high = -low;
      for (const std::uint32_t t : uv_.face_texcoords[face]) {
        low = std::min(low, uv_.texcoords[t][k]);
        high = std::max(high, uv_.texcoords[t][k]);
      }
      tile[k] = square_of(low, high);
      if (low < tile[k] - kRounding || high > tile[k] + 1 + kRounding)
        throw InputError(file_, "face " + std::to_string(face),
                         std::string("has the texture coordinates ") + (k == 0 ? "u" : "v") + " = " +
                             general_text(low) + " to " + general_text(high) +
                             ", across the rim of a texture that repeats or of a tile; expected each face between two "
                             "whole numbers that follow each other, as what is baked does not repeat");
    }
    return {tile[0], tile[1]};
  }

  void find_tiles() {
    bool repeats = false;
    std::size_t outside = 0;
    for (std::size_t face = 0; face < tiles_.size(); ++face) {
      if (!has_coordinates(face)) continue;
      const Tile tile = tiles_[face].emplace(tile_of(face));
      outside += tile.is_first() ? 0 : 1;
      repeats |= tile.u < 0 || tile.v < 0 || tile.u >= kUdimColumns || tile.v >= static_cast<double>(kMostPages);
    }
    layout_.has_udim_tiles = outside > 0 && !repeats;
    layout_.repeated_faces = repeats ? outside : 0;
  }

  using Key = std::tuple<std::uint32_t, double, double>;  // material, rows and columns of tiles
  Key key_of(std::size_t face) const {
    const Tile& tile = *tiles_[face];
    return layout_.has_udim_tiles ? Key{material_of(face), tile.v, tile.u} : Key{material_of(face), 0, 0};
  }

  void add_pages() {
    std::set<std::uint32_t> materials;
    for (std::size_t face = 0; face < tiles_.size(); ++face) {
      if (!tiles_[face]) continue;
      pages_.try_emplace(key_of(face), 0);
      materials.insert(material_of(face));
      if (pages_.size() > kMostPages)
        throw InputError(file_, "", "has texture coordinates on more than " + std::to_string(kMostPages) + " pages");
    }
    UniqueNames suffixes, names;
    std::map<std::uint32_t, std::string> parts;  // of file names
    for (const std::uint32_t material : materials) parts[material] = suffixes.take("_" + file_part(name_of(material)));
    std::uint32_t count = 0;
    for (auto& [key, page] : pages_) {
      page = count++;
      const auto& [material, row, column] = key;
      const int number = kFirstUdim + static_cast<int>(column) + kUdimColumns * static_cast<int>(row);
      const std::string tile = layout_.has_udim_tiles ? "." + std::to_string(number) : "";
      UvPage made;
      made.suffix = (materials.size() > 1 ? parts[material] : layout_.has_udim_tiles ? "" : "_0") + tile;
      made.material = names.take(name_of(material) + tile);
      set_size(material, made);
      layout_.pages.push_back(std::move(made));
    }
  }

  std::string name_of(std::uint32_t material) const {
    std::string name = material == StatedUv::kNone ? "" : uv_.materials[material].name;
    std::ranges::replace_if(
        name, [](char c) { return static_cast<unsigned char>(c) < ' '; }, '_');  // an OBJ names it in a line
    return name.empty() ? "page_" + std::to_string(material == StatedUv::kNone ? 0 : material) : name;
  }

  /// The longer edge is the one that is given; images say how long the other one is.
  void set_size(std::uint32_t material, UvPage& page) const {
    page.width = page.height = size_.edge;
    if (material == StatedUv::kNone) return;
    const auto& [name, width, height] = uv_.materials[material];
    if (width <= 0 || height <= 0) return;
    const int longer = std::max(width, height), edge = size_.as_images ? std::min(longer, kMostEdge) : size_.edge;
    const double scale = static_cast<double>(edge) / longer;
    page.width = std::max(1, static_cast<int>(std::lround(width * scale)));
    page.height = std::max(1, static_cast<int>(std::lround(height * scale)));
  }

  /// A corner of faces of several tiles lies at another place of each tile's page.
  void place_faces() {
    layout_.texcoords.resize(uv_.texcoords.size());
    layout_.obj_texcoords = uv_.texcoords;
    std::vector<std::optional<Tile>> placed(uv_.texcoords.size());
    std::map<std::tuple<std::uint32_t, double, double>, std::uint32_t> copies;
    layout_.face_texcoords.assign(tiles_.size(), {});
    layout_.face_page.assign(tiles_.size(), kNoPage);
    for (std::size_t face = 0; face < tiles_.size(); ++face) {
      if (!tiles_[face]) continue;
      const Tile& tile = *tiles_[face];
      layout_.face_page[face] = pages_.at(key_of(face));
      for (std::size_t i = 0; i < 3; ++i) {
        std::uint32_t t = uv_.face_texcoords[face][i];
        if (!placed[t])
          place(t, t, placed[t].emplace(tile));
        else if (placed[t]->u != tile.u || placed[t]->v != tile.v)
          t = copy_in(tile, t, copies);
        layout_.face_texcoords[face][i] = t;
      }
    }
  }

  std::uint32_t copy_in(const Tile& tile, std::uint32_t t,
                        std::map<std::tuple<std::uint32_t, double, double>, std::uint32_t>& copies) {
    const auto [known, fresh] =
        copies.try_emplace({t, tile.u, tile.v}, static_cast<std::uint32_t>(layout_.texcoords.size()));
    if (fresh) {
      layout_.texcoords.emplace_back();
      layout_.obj_texcoords.push_back(uv_.texcoords[t]);
      place(known->second, t, tile);
    }
    return known->second;
  }

  void place(std::uint32_t at, std::uint32_t stated, const Tile& tile) {
    const auto within = [](double c) { return static_cast<float>(std::clamp(c, 0.0, 1.0)); };
    const auto& [u, v] = uv_.texcoords[stated];
    layout_.texcoords[at] = {within(u - tile.u), within(1 - (v - tile.v))};
  }

  const StatedUv& uv_;
  const UvPageSize& size_;
  const fs::path& file_;
  std::vector<std::optional<Tile>> tiles_;  ///< per face; none: it has no texture coordinates
  std::map<Key, std::uint32_t> pages_;      ///< in their order, with their numbers
  UvLayout layout_;
};

}  // namespace

void set_corners(std::span<const Triangle> faces, std::span<const std::array<double, 2>> corners, StatedUv& uv) {
  std::vector<std::uint32_t> first, next;  // of a vertex's coordinates, and after each
  uv.face_texcoords.resize(faces.size());
  for (std::size_t at = 0; at < corners.size(); ++at) {
    const std::uint32_t vertex = faces[at / 3][at % 3];
    const std::array<double, 2>& stated = corners[at];
    std::uint32_t& corner = uv.face_texcoords[at / 3][at % 3];
    corner = StatedUv::kNone;
    if (!std::isfinite(stated[0]) || !std::isfinite(stated[1])) continue;
    if (vertex >= first.size()) first.resize(std::size_t{vertex} + 1, StatedUv::kNone);
    corner = first[vertex];
    while (corner != StatedUv::kNone && uv.texcoords[corner] != stated) corner = next[corner];
    if (corner != StatedUv::kNone) continue;
    corner = static_cast<std::uint32_t>(uv.texcoords.size());
    uv.texcoords.push_back(stated);
    next.push_back(std::exchange(first[vertex], corner));
  }
}

UvLayout lay_out(const StatedUv& uv, const UvPageSize& size, const fs::path& file) {
  return LayoutMaker(uv, size, file).make();
}

}  // namespace gpvc::io
