#include "app/evaluate/texture_islands.h"

#include <array>
#include <boost/pending/disjoint_sets.hpp>
#include <map>
#include <utility>

namespace gpvc::evaluate {
namespace {

struct Corner {
  std::uint32_t vertex = 0;
  float u = 0, v = 0;
  auto operator<=>(const Corner&) const = default;
};

using Edge = std::pair<std::uint32_t, std::array<Corner, 2>>;  // page, corners in ascending order

}  // namespace

std::size_t texture_islands(const io::TexturedModel& model) {
  const std::size_t faces = model.face_page.size();
  boost::disjoint_sets_with_storage<> groups(faces);
  std::map<Edge, std::size_t> first_face;
  std::size_t islands = 0;
  for (std::size_t f = 0; f < faces; ++f) {
    if (model.face_page[f] == io::kNoPage) continue;
    ++islands;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto corner = [&](std::size_t at) {
        const io::TexCoord& t = model.texcoords[model.face_texcoords[f][at]];
        return Corner{model.mesh->faces[f][at], t.u, t.v};
      };
      Edge edge{model.face_page[f], {corner(i), corner((i + 1) % 3)}};
      if (edge.second[1] < edge.second[0]) std::swap(edge.second[0], edge.second[1]);
      const auto [at, fresh] = first_face.try_emplace(edge, f);
      if (fresh || groups.find_set(f) == groups.find_set(at->second)) continue;
      groups.union_set(f, at->second);
      --islands;
    }
  }
  return islands;
}

}  // namespace gpvc::evaluate
