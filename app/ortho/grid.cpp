#include "app/ortho/grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "io/box.h"
#include "io/error.h"

namespace gpvc::ortho {
namespace {

constexpr int kLeastSamples = 5, kMostSamples = 63;
constexpr double kMostPixels = 1e7;  // along an edge

// Edges of texels on the ground, and how much of it has them.
class TexelSizes {
 public:
  TexelSizes(const Surface& surface, const PageStore& pages) {
    constexpr std::size_t kFaces = 200000;  // are enough
    const std::size_t step = 1 + surface.mesh.faces.size() / kFaces;
    for (std::size_t f = 0; f < surface.mesh.faces.size(); f += step)
      if (surface.kind[f] == FaceKind::textured) add(surface, f, pages[surface.model.face_page[f]]);
    std::ranges::sort(sizes_);
  }
  // The size that so much of the ground has smaller ones than; 0 where none is known.
  double at_share(double share) const {
    double all = 0, smaller = 0;
    for (const auto& [size, area] : sizes_) all += area;
    for (const auto& [size, area] : sizes_)
      if ((smaller += area) >= share * all) return size;
    return 0;
  }

 private:
  void add(const Surface& surface, std::size_t f, const StoredPage& page) {
    const auto& [a, b, c] = surface.mesh.faces[f];
    const auto& p = surface.mesh.positions;
    const auto& [s, t, u] = surface.model.face_texcoords[f];
    const auto& q = surface.model.texcoords;
    const double area = std::abs((p[b].x - p[a].x) * (p[c].y - p[a].y) - (p[c].x - p[a].x) * (p[b].y - p[a].y));
    const double uv =
        std::abs(double{q[t].u - q[s].u} * double{q[u].v - q[s].v} - double{q[u].u - q[s].u} * double{q[t].v - q[s].v});
    const double texels = uv * page.width * page.height;
    if (area > 0 && texels > 0) sizes_.emplace_back(std::sqrt(area / texels), area);
  }
  std::vector<std::pair<double, double>> sizes_;
};

double with_two_digits(double value) {
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - 1);
  // Divided where that is exact in decimals: 0.035 rather than 0.035000000000000003.
  return unit < 1 ? std::round(value / unit) / std::round(1 / unit) : std::round(value / unit) * unit;
}

Bounds bounds_of_textured(const Surface& surface) {
  Box box;
  for (std::size_t f = 0; f < surface.mesh.faces.size(); ++f)
    if (surface.kind[f] == FaceKind::textured)
      for (const std::uint32_t v : surface.mesh.faces[f]) box.add(surface.mesh.positions[v]);
  return {box.low.x, box.low.y, box.high.x, box.high.y};
}

std::string text(const Bounds& b) { return fmt::format("{}, {} to {}, {}", b.west, b.south, b.east, b.north); }

}  // namespace

Grid grid_of(const Surface& surface, const PageStore& pages, const OrthoSettings& settings) {
  const TexelSizes texels(surface, pages);
  Grid grid;
  grid.gsd = settings.gsd > 0 ? settings.gsd : texels.at_share(0.5);
  if (!(grid.gsd > 0)) throw InputError(surface.source, "", "is seen edge-on from above: it has no ground to show");
  if (!(settings.gsd > 0)) grid.gsd = with_two_digits(grid.gsd);
  const Bounds all = bounds_of_textured(surface);
  const Bounds shown = settings.bounds.value_or(all);
  if (shown.east <= all.west || shown.west >= all.east || shown.north <= all.south || shown.south >= all.north)
    throw InputError(surface.source, "", fmt::format("lies within {}, beside the bounds {}", text(all), text(shown)));
  // A bound that is a multiple of the pixel size but for rounding is taken for one.
  const auto below = [&](double edge) { return std::floor(edge / grid.gsd + 1e-6); };
  const auto above = [&](double edge) { return std::ceil(edge / grid.gsd - 1e-6); };
  const double columns = std::max(1.0, above(shown.east) - below(shown.west));
  const double rows = std::max(1.0, above(shown.north) - below(shown.south));
  if (std::max(columns, rows) > kMostPixels)
    throw InputError(
        surface.source, "",
        fmt::format("has {:.0f} x {:.0f} pixels of {} units within {}, expected {:.0f} along an edge at most", columns,
                    rows, grid.gsd, text(shown), kMostPixels));
  grid.west = below(shown.west) * grid.gsd;
  grid.north = above(shown.north) * grid.gsd;
  grid.width = static_cast<int>(columns);
  grid.height = static_cast<int>(rows);
  const double fine = texels.at_share(0.1);
  const double wanted = fine > 0 ? std::ceil(grid.gsd / fine) : kLeastSamples;
  const int samples = static_cast<int>(std::clamp(wanted, double{kLeastSamples}, double{kMostSamples}));
  grid.samples = samples | 1;
  return grid;
}

}  // namespace gpvc::ortho
