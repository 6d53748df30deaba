#include "atlas/baking/blend_field.h"

#include <tbb/parallel_for.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <utility>

namespace gpvc::atlas {

namespace {

static_assert(kBandRows % kBlendStep == 0);
constexpr int kCellRows = kBandRows / kBlendStep;

TexelTriangle cell_corners(const TexelTriangle& t) {
  const double scale = 1.0 / kBlendStep;
  return {{{t[0].x * scale, t[0].y * scale}, {t[1].x * scale, t[1].y * scale}, {t[2].x * scale, t[2].y * scale}}};
}

/// Calls visit(x, at) for the texels of a chart's row, and of its ring, that lie in the chart's blocks, with their index on
/// the page.
template <typename Visit>
void for_own_texels(const Page& page, const ChartPlace& place, std::uint32_t chart, int width, int y,
                    const Visit& visit) {
  const ChartPlace::Texel origin = place.texel(0, y), next = place.texel(1, y);
  const int dx = next.x - origin.x, dy = next.y - origin.y;
  for (int x = -1, end = 0; x <= width; x = end) {
    const int px = origin.x + x * dx, py = origin.y + x * dy;
    end = x + 1;
    if (px < 0 || py < 0 || px >= page.image.width || py >= page.image.height) continue;
    const int in_block = (dx != 0 ? px : py) % page.block;
    end = std::min(x + (dx + dy > 0 ? page.block - in_block : in_block + 1), width + 1);
    if (page.owner(px, py) != chart) continue;
    const std::ptrdiff_t stride = dx + std::ptrdiff_t{dy} * page.image.width;
    auto at = static_cast<std::ptrdiff_t>(page.at(px, py));
    for (; x < end; ++x, at += stride) visit(x, static_cast<std::size_t>(at));
  }
}

}  // namespace

std::size_t blend_bytes(const ChartSet& set, std::uint32_t chart) {
  // Of a cell its sums and place; of a face its cells and numbers, of some the range of colours, and some three cells of its own along its edges.
  constexpr double kCell = 10, kFace = 12 + 64 / ColorHulls::kSampled + 3 * kCell;
  const Chart& c = set.charts[chart];
  double twice_area = 0;
  for (const std::uint32_t face : c.faces) {
    const TexelTriangle& t = set.corners[face];
    twice_area += std::abs((t[1].x - t[0].x) * (t[2].y - t[0].y) - (t[2].x - t[0].x) * (t[1].y - t[0].y));
  }
  const double cells = twice_area / 2 / (kBlendStep * kBlendStep);
  return static_cast<std::size_t>(kCell * cells + kFace * static_cast<double>(c.faces.size()));
}

BlendField::BlendField(const AtlasBuild& build, std::uint32_t chart)
    : build_(build), number_(chart), chart_(build.set.charts[chart]) {}

/// A row more than the band's texels lie in on both sides, between which they take colours, and columns likewise.
CellBox BlendField::box_of(std::size_t band) const {
  const int first = static_cast<int>(band) * kCellRows;
  return {-1, first - 1, chart_.width / kBlendStep + 2,
          std::min(first + kCellRows + 1, chart_.height / kBlendStep + 2)};
}

void BlendField::open() {
  faces_ = face_bands(chart_, build_.set.corners);
  bands_.resize(faces_.groups());
  tbb::parallel_for(std::size_t{0}, bands_.size(), [&](std::size_t band) { open_band(band); });
}

void BlendField::open_band(std::size_t number) {
  Band& band = bands_[number];
  std::vector<TexelTriangle> corners;
  std::vector<std::uint32_t> numbers;
  std::vector<std::uint8_t> shown(build_.input.scene.views.size(), 0);  // by view
  for (const std::uint32_t face : std::as_const(faces_)[number]) {
    bool any = false;
    for (const std::uint32_t vertex : build_.input.mesh.faces[face])
      for (const BlendView& item : build_.blending.at(vertex)) {
        any = true;
        shown[item.view] = 1;
      }
    if (!any) continue;
    numbers.push_back(static_cast<std::uint32_t>(numbers.size()));
    band.faces.push_back(face);
    corners.push_back(cell_corners(build_.set.corners[face]));
  }
  if (numbers.empty()) return;
  for (std::uint32_t v = 0; v < shown.size(); ++v)
    if (shown[v]) band.views.push_back(v);
  const ChartRaster raster = rasterize(numbers, corners, box_of(number));
  band.cells = group_items<Cell>(numbers.size(), [&](const auto& emit) {
    std::size_t at = 0;
    for (int y = 0; y < raster.height(); ++y)
      for (int x = 0; x < raster.width(); ++x, ++at)
        if (raster.owner[at] != kNoOwner)
          emit(raster.owner[at], {static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y)});
  });
  band.sums.resize(band.cells.items.size());
  band.hulls = ColorHulls(build_, chart_, band.faces);
}

void BlendField::add(std::size_t number, ViewId id, const CoarseRows& coarse, int step) {
  Band& band = bands_[number];
  const CellBox box = box_of(number);
  band.hulls.add(build_, id, coarse);
  FaceShare share(build_, chart_, id, coarse, step, band.faces.size());
  for (std::size_t f = 0; f < band.faces.size(); ++f) {
    const std::span<const Cell> cells = std::as_const(band.cells)[f];
    if (cells.empty() || !share.prepare(band.faces[f])) continue;
    const std::span<ColorSum> sums = std::span(band.sums).subspan(band.cells.first[f], cells.size());
    for (std::size_t i = 0, end = 0; i < cells.size(); i = end) {
      const Cell& first = cells[i];
      for (end = i + 1; end < cells.size() && cells[end].y == first.y; ++end)
        if (cells[end].x != cells[end - 1].x + 1) break;
      share.add_row((box.x0 + first.x + 0.5) * kBlendStep, (box.y0 + first.y + 0.5) * kBlendStep,
                    sums.subspan(i, end - i));
    }
  }
}

void BlendField::apply(AtlasBuild& build) const {
  tbb::parallel_for(std::size_t{0}, bands_.size(), [&](std::size_t band) { apply_band(band, build); });
}

InventedColor BlendField::invented_color() const {
  InventedColor invented;
  for (const Band& band : bands_) invented.add(band.hulls.count(build_, build_.correction.strip(number_)));
  return invented;
}

void BlendField::apply_band(std::size_t number, AtlasBuild& build) const {
  const Band& band = bands_[number];
  if (band.sums.empty()) return;
  // Red, green, blue and, where there is a sum, 1.
  using Mean = Eigen::Array4f;
  const CellBox box = box_of(number), texels = band_box(chart_, static_cast<int>(number));
  const int width = box.x1 - box.x0;
  std::vector<Mean> cells(pixel_index(0, box.y1 - box.y0, width), Mean::Zero()),
      columns(static_cast<std::size_t>(width));
  for (std::size_t i = 0; i < band.sums.size(); ++i) {
    const Cell& cell = band.cells.items[i];
    const ColorSum& sum = band.sums[i];
    cells[pixel_index(cell.x, cell.y, width)] =
        Mean(static_cast<float>(sum[0]) / kSumUnit, static_cast<float>(sum[1]) / kSumUnit,
             static_cast<float>(sum[2]) / kSumUnit, 1);
  }
  Page& page = build.page_of(number_);
  const std::size_t layers = build.painting.are_colors() ? build.painting.layers() : 1;
  constexpr double kStep = kBlendStep;
  for (int y = texels.y0; y < texels.y1; ++y) {
    // Bilinear between cells, those without a sum left out: first down, then across.
    const double v = (y + 0.5) / kStep - 0.5 - box.y0;
    const int row = static_cast<int>(v);
    const auto down = static_cast<float>(v - row);
    const Mean *upper = cells.data() + pixel_index(0, row, width), *lower = upper + width;
    for (std::size_t i = 0; i < columns.size(); ++i) columns[i] = (1 - down) * upper[i] + down * lower[i];
    for_own_texels(page, build.places[number_], number_, chart_.width, y, [&](int x, std::size_t at) {
      if (page.state[at] == TexelState::empty) return;
      const double u = (x + 0.5) / kStep - 0.5 - box.x0;
      const auto column = static_cast<std::size_t>(u);
      const auto across = static_cast<float>(u - static_cast<double>(column));
      const Mean mean = (1 - across) * columns[column] + across * columns[column + 1];
      if (!(mean[3] > 0)) return;
      const Color change = (1 / mean[3]) * Color{mean[0], mean[1], mean[2]};
      std::uint8_t* to = page.image.pixels.data() + 3 * at;
      store(to, load(to) + change);
      for (std::size_t later = 1; later < layers; ++later) {
        const PageLayer layer = page.layer(later);
        layer.put(at, layer.at(at) + build.painting.change_in_bands(later, change));
      }
    });
  }
}

}  // namespace gpvc::atlas
