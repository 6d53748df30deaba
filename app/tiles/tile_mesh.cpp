#include "app/tiles/tile_mesh.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <numeric>

#include "app/tileset/simplify.h"
#include "labeling/labeling.h"

namespace gpvc::tiles {
namespace {

void sort_distinct(std::vector<std::uint32_t>& values) {
  std::ranges::sort(values);
  values.erase(std::unique(values.begin(), values.end()), values.end());
}

}  // namespace

std::vector<std::uint8_t> TileMesh::border(std::uint32_t number) const {
  std::vector<std::uint8_t> flags;
  for (const std::uint32_t of : tile) flags.push_back(of == number ? 0 : 1);
  return flags;
}

std::vector<std::uint32_t> TileMesh::own(std::uint32_t number) const {
  std::vector<std::uint32_t> faces;
  for (std::uint32_t f = 0; f < tile.size(); ++f)
    if (tile[f] == number) faces.push_back(f);
  return faces;
}

TileCutter::TileCutter(const Mesh& mesh, std::span<const std::uint32_t> tile, std::size_t tiles)
    : mesh_(mesh), tile_(tile), taken_(mesh.faces.size(), 0) {
  faces_ = group_items<std::uint32_t>(tiles, [&](const auto& add) {
    for (std::uint32_t f = 0; f < tile.size(); ++f) add(tile[f], f);
  });
  neighbours_ = group_neighbours(mesh.faces.size(), labeling::face_graph(mesh).edges);
  place_.resize(mesh.faces.size());
  for (std::size_t t = 0; t < tiles; ++t)
    for (std::uint32_t place = 0; const std::uint32_t f : faces_[t]) place_[f] = place++;
}

TileMesh TileCutter::cut(std::uint32_t number) {
  const std::span<const std::uint32_t> own = faces_[number];
  std::vector<std::uint32_t> faces(own.begin(), own.end());
  for (const std::uint32_t f : faces) taken_[f] = 1;
  for (std::size_t begin = 0, ring = 0; ring < kBorderEdges && begin < faces.size(); ++ring) {
    const std::size_t end = faces.size();
    for (; begin < end; ++begin)
      for (const std::uint32_t next : neighbours_[faces[begin]])
        if (std::exchange(taken_[next], std::uint8_t{1}) == 0) faces.push_back(next);
  }
  for (const std::uint32_t f : faces) taken_[f] = 0;
  std::ranges::sort(faces);
  TileMesh result;
  for (const std::uint32_t f : faces)
    result.vertex.insert(result.vertex.end(), mesh_.faces[f].begin(), mesh_.faces[f].end());
  sort_distinct(result.vertex);
  result.mesh.file_srs = mesh_.file_srs;
  for (const std::uint32_t v : result.vertex) {
    result.mesh.positions.push_back(mesh_.positions[v]);
    if (!mesh_.file_positions.empty()) result.mesh.file_positions.push_back(mesh_.file_positions[v]);
  }
  for (const std::uint32_t f : faces) {
    Triangle corners = mesh_.faces[f];
    for (std::uint32_t& v : corners)
      v = static_cast<std::uint32_t>(std::ranges::lower_bound(result.vertex, v) - result.vertex.begin());
    result.mesh.faces.push_back(corners);
    result.face.push_back(f);
    result.tile.push_back(tile_[f]);
    result.place.push_back(place_[f]);
  }
  return result;
}

std::vector<std::uint32_t> TileCutter::beside(std::uint32_t number) const {
  std::vector<std::uint32_t> tiles;
  for (const std::uint32_t f : faces_[number])
    for (const std::uint32_t next : neighbours_[f])
      if (tile_[next] != number) tiles.push_back(tile_[next]);
  sort_distinct(tiles);
  return tiles;
}

void TileUnion::add(const TileMesh& tile, std::uint32_t number) {
  std::vector<std::uint8_t> used(tile.vertex.size(), 0);
  for (const std::uint32_t f : tile.own(number)) {
    Triangle corners = tile.mesh.faces[f];
    for (std::uint32_t& v : corners) {
      used[v] = 1;
      v = tile.vertex[v];
    }
    faces_.emplace_back(tile.face[f], corners);
  }
  for (std::size_t v = 0; v < used.size(); ++v)
    if (used[v] != 0) vertices_.push_back({tile.vertex[v], tile.mesh.positions[v]});
}

void TileUnion::finish() {
  tbb::parallel_sort(faces_.begin(), faces_.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  tbb::parallel_sort(vertices_.begin(), vertices_.end(),
                     [](const Vertex& a, const Vertex& b) { return a.number < b.number; });
  const auto same = [](const Vertex& a, const Vertex& b) { return a.number == b.number; };
  vertices_.erase(std::unique(vertices_.begin(), vertices_.end(), same), vertices_.end());
  for (const Vertex& vertex : vertices_) {
    mesh_.positions.push_back(vertex.at);
    vertex_numbers_.push_back(vertex.number);
  }
  for (const auto& [number, global] : faces_) {
    Triangle corners = global;
    for (std::uint32_t& v : corners)
      v = static_cast<std::uint32_t>(std::ranges::lower_bound(vertices_, v, {}, &Vertex::number) - vertices_.begin());
    mesh_.faces.push_back(corners);
    numbers_.push_back(number);
  }
  faces_ = {};
  vertices_ = {};
}

std::vector<std::uint32_t> TileUnion::places_of(std::span<const std::uint64_t> faces) const {
  std::vector<std::uint32_t> places;
  places.reserve(faces.size());
  for (auto at = numbers_.begin(); const std::uint64_t face : faces) {
    at = std::lower_bound(at, numbers_.end(), face);
    const bool found = at != numbers_.end() && *at == face;
    places.push_back(found ? static_cast<std::uint32_t>(at - numbers_.begin()) : kNowhere);
  }
  return places;
}

namespace {

std::uint32_t tile_of(std::uint64_t face) { return static_cast<std::uint32_t>(face >> 32); }
std::uint32_t place_of(std::uint64_t face) { return static_cast<std::uint32_t>(face); }

}  // namespace

CoarseTile coarse_tile(const TileUnion& children, std::uint32_t number) {
  const Mesh& all = children.mesh();
  std::vector<std::uint32_t> faces(all.faces.size());
  std::iota(faces.begin(), faces.end(), 0u);
  tileset::Simplified simplified = tileset::simplified(all, faces);
  CoarseTile result;
  TileMesh& tile = result.tile;
  for (const Triangle& face : simplified.faces) tile.vertex.insert(tile.vertex.end(), face.begin(), face.end());
  sort_distinct(tile.vertex);
  for (Triangle& face : simplified.faces) {
    for (std::uint32_t& v : face)
      v = static_cast<std::uint32_t>(std::ranges::lower_bound(tile.vertex, v) - tile.vertex.begin());
    tile.face.push_back(face_number(number, tile.mesh.faces.size()));
    tile.place.push_back(static_cast<std::uint32_t>(tile.mesh.faces.size()));
    tile.tile.push_back(number);
    tile.mesh.faces.push_back(face);
  }
  for (std::uint32_t& v : tile.vertex) {
    tile.mesh.positions.push_back(all.positions[v]);
    v = children.vertex_numbers()[v];
  }
  result.error = simplified.error;
  return result;
}

TileMesh with_border(const TileUnion& around, std::uint32_t number) {
  std::vector<std::uint32_t> tiles;
  for (const std::uint64_t face : around.face_numbers()) tiles.push_back(tile_of(face));
  const std::uint32_t most = tiles.empty() ? number : *std::ranges::max_element(tiles);
  TileMesh tile = TileCutter(around.mesh(), tiles, std::size_t{std::max(most, number)} + 1).cut(number);
  for (std::uint64_t& face : tile.face) face = around.face_numbers()[face];
  for (std::uint32_t& v : tile.vertex) v = around.vertex_numbers()[v];
  for (std::size_t f = 0; f < tile.face.size(); ++f) tile.place[f] = place_of(tile.face[f]);
  return tile;
}

}  // namespace gpvc::tiles
