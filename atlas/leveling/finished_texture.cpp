#include "atlas/leveling/finished_texture.h"

#include "atlas/charts/charts.h"

namespace gpvc::atlas {

const Image& finished_page(const AtlasInput& input, std::size_t face) {
  return input.finished->pages[input.finished->model.face_page[face]];
}

TexelPoint finished_place(const AtlasInput& input, std::size_t face, std::uint32_t vertex) {
  const Image& page = finished_page(input, face);
  const std::size_t corner = corner_of(input.mesh.faces[face], vertex);
  const io::TexCoord& at = input.finished->model.texcoords[input.finished->model.face_texcoords[face][corner]];
  return {static_cast<double>(at.u) * page.width, static_cast<double>(at.v) * page.height};
}

namespace {

Color color_at(const AtlasInput& input, std::size_t face, const TexelPoint& at, std::size_t layer) {
  if (layer == 0) return sample_bilinear(finished_page(input, face), at.x, at.y);
  const Samples& samples = input.finished->samples[input.finished->model.face_page[face]];
  return sample_bilinear(layer_of({}, &samples, layer), at.x, at.y);
}

}  // namespace

Color finished_color(const AtlasInput& input, std::size_t face, std::uint32_t vertex, std::size_t layer) {
  return color_at(input, face, finished_place(input, face, vertex), layer);
}

Color finished_color(const AtlasInput& input, std::size_t face, const std::array<std::uint32_t, 2>& edge, double t,
                     std::size_t layer) {
  const TexelPoint a = finished_place(input, face, edge[0]), b = finished_place(input, face, edge[1]);
  return color_at(input, face, {a.x + t * (b.x - a.x), a.y + t * (b.y - a.y)}, layer);
}

}  // namespace gpvc::atlas
