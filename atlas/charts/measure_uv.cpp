// What is known of a layout before a photo is read.
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "atlas/charts/chart_merging.h"
#include "atlas/charts/given_charts.h"
#include "io/grouping.h"
#include "io/image.h"

namespace gpvc::atlas {
namespace {

/// In pages, whose y points down, the corners of a face turn counter-clockwise as drawn, where they do so seen from outside.
bool is_mirrored(const io::UvLayout& layout, std::size_t face) { return doubled_area(page_corners(layout, face)) > 0; }

void count_islands(const Mesh& mesh, const FaceNeighbours& neighbours, const io::UvLayout& layout, UvFigures& figures) {
  std::vector<char> taken(mesh.faces.size(), 0);
  for (std::uint32_t seed = 0; seed < taken.size(); ++seed) {
    if (taken[seed] || !takes_texels(layout, seed)) continue;
    const bool mirrored = is_mirrored(layout, seed);
    ++figures.islands;
    figures.mirrored_islands += mirrored ? 1 : 0;
    taken[seed] = 1;
    std::vector<std::uint32_t> island{seed};
    for (std::size_t next = 0; next < island.size(); ++next)
      for (const std::uint32_t face = island[next]; const std::uint32_t other : neighbours[face]) {
        if (taken[other] || !takes_texels(layout, other) || is_mirrored(layout, other) != mirrored ||
            !continues(mesh, layout, face, other))
          continue;
        taken[other] = 1;
        island.push_back(other);
      }
  }
}

/// Texels of a page whose middle lies inside of several faces, and marks these.
std::size_t count_overlaps(std::span<const std::uint32_t> faces, const io::UvLayout& layout, const io::UvPage& page,
                           std::vector<char>& overlaps) {
  constexpr std::uint32_t kFree = 0xFFFFFFFFu;
  std::vector<std::uint32_t> owner(pixel_index(0, page.height, page.width), kFree);
  std::size_t texels = 0;
  for (const std::uint32_t face : faces)
    covered_spans(page_corners(layout, face), [&](int y, int first, int last) {
      if (y < 0 || y >= page.height) return;
      for (int x = std::max(first, 0); x <= std::min(last, page.width - 1); ++x) {
        std::uint32_t& known = owner[pixel_index(x, y, page.width)];
        if (known == kFree) {
          known = face;
          continue;
        }
        ++texels;
        overlaps[known] = overlaps[face] = 1;
      }
    });
  return texels;
}

}  // namespace

UvFigures measure_uv(const Mesh& mesh, const labeling::FaceGraph& graph, const io::UvLayout& layout) {
  UvFigures figures;
  for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
    const bool has_page = layout.face_page[face] != io::kNoPage;
    figures.faces_without += has_page ? 0 : 1;
    figures.flat_faces += has_page && !takes_texels(layout, face) ? 1 : 0;
  }
  count_islands(mesh, group_neighbours(mesh.faces.size(), graph.edges), layout, figures);
  const auto of_page = group_items<std::uint32_t>(layout.pages.size(), [&](const auto& add) {
    for (std::uint32_t face = 0; face < mesh.faces.size(); ++face)
      if (takes_texels(layout, face)) add(layout.face_page[face], face);
  });
  std::vector<char> overlaps(mesh.faces.size(), 0);  // faces of other pages on other threads
  std::vector<std::size_t> texels(layout.pages.size(), 0);
  tbb::parallel_for(std::size_t{0}, layout.pages.size(),
                    [&](std::size_t p) { texels[p] = count_overlaps(of_page[p], layout, layout.pages[p], overlaps); });
  for (const std::size_t count : texels) figures.overlapping_texels += count;
  figures.overlapping_faces = static_cast<std::size_t>(std::ranges::count(overlaps, 1));
  return figures;
}

void check_layout(const Mesh& mesh, const io::UvLayout& layout) {
  constexpr int kMostEdge = 32768;
  const auto require = [](bool holds, const char* what) {
    if (!holds) throw std::invalid_argument(what);
  };
  require(layout.face_texcoords.size() == mesh.faces.size() && layout.face_page.size() == mesh.faces.size(),
          "a layout must have one entry per face");
  require(layout.obj_texcoords.empty() || layout.obj_texcoords.size() == layout.texcoords.size(),
          "obj_texcoords of a layout must be empty or have one entry per texture coordinate");
  for (const io::UvPage& page : layout.pages)
    require(page.width >= 1 && page.height >= 1 && page.width <= kMostEdge && page.height <= kMostEdge,
            "pages of a layout must have 1 to 32768 texels an edge");
  const auto in_page = [](float c) { return c >= 0 && c <= 1; };
  require(std::ranges::all_of(layout.texcoords, [&](const io::TexCoord& t) { return in_page(t.u) && in_page(t.v); }),
          "texture coordinates of a layout must lie in 0 .. 1");
  for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
    if (layout.face_page[face] == io::kNoPage) continue;
    require(layout.face_page[face] < layout.pages.size(), "a face's page in a layout does not exist");
    for (const std::uint32_t t : layout.face_texcoords[face])
      require(t < layout.texcoords.size(), "a face's texture coordinate in a layout does not exist");
  }
}

}  // namespace gpvc::atlas
