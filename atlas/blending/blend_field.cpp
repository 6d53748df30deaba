#include "atlas/blending/blend_field.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>
#include <utility>

#include "atlas/baking/plane_map.h"

namespace gpvc::atlas {

namespace {

/// Steps a grey level. A sum is at most twice a grey level of 255 times a gain of 2.5, which fits 16 bits; rounding is a
/// 32nd of a grey level a view.
constexpr float kUnit = 16;

/// Faces whose projection is smaller than this, in texels, are mapped to other views by interpolating between their corners:
/// perspective changes by some hundredth over so few pixels of a photo of thousands, which moves a position by some
/// hundredths of a pixel.
constexpr double kAffine = 16;

/// Rounded; kShift makes what is truncated positive.
int in_units(float level) {
  constexpr int kShift = 1 << 15;
  return static_cast<int>(kUnit * level + (kShift + 0.5f)) - kShift;
}

TexelTriangle cell_corners(const TexelTriangle& t) {
  const double scale = 1.0 / kBlendStep;
  return {{{t[0].x * scale, t[0].y * scale}, {t[1].x * scale, t[1].y * scale}, {t[2].x * scale, t[2].y * scale}}};
}

}  // namespace

/// What a view adds to a face: where it shows the face, and with which factor.
class BlendField::FaceShare {
 public:
  FaceShare(const BlendField& field, ViewId id, const View& view) : field_(field), id_(id), view_(view) {}

  /// False if the view adds nothing to the face.
  bool prepare(std::uint32_t face) {
    const AtlasBuild& build = field_.build_;
    const Triangle& vertices = build.input.mesh.faces[face];
    const auto view = static_cast<std::uint32_t>(index(id_)),
               main = static_cast<std::uint32_t>(index(field_.chart_.view));
    std::array<BlendWeights::Share, 3> shares;
    for (std::size_t i = 0; i < 3; ++i) shares[i] = build.blending.share(vertices[i], view, main);
    if (std::ranges::all_of(shares, [](const auto& share) { return share.factor == 0; })) return false;
    corners_ = build.set.corners[face];
    const double area = doubled_area(corners_);
    if (area == 0) return false;
    second_ = Barycentric(corners_[0], corners_[2], 1 / area);
    third_ = Barycentric(corners_[0], corners_[1], -1 / area);
    bool exact = shows_pole(view_.camera.distortion.model);
    for (std::size_t i = 0; i < 3; ++i) {
      factor_[i] = {shares[i].factor, shares[i].factor, shares[i].factor};
      if (shares[i].at == nullptr) {
        // The view has no share at this corner, but one between it and the others.
        exact |= !find_place(build.input.mesh.positions[vertices[i]], photo_[i]);
        continue;
      }
      photo_[i] = {double{shares[i].at->x}, double{shares[i].at->y}};
      if (build.correction.exposure.empty()) continue;
      const CameraPoint c = camera_from_world(view_.pose, build.input.mesh.positions[vertices[i]]);
      factor_[i] = gain_at(build.correction.exposure[view], pixel_from_camera(view_.camera, c)) * factor_[i];
    }
    FrameBox bounds;
    bounds.add(corners_);
    exact |= std::max(bounds.x1 - bounds.x0, bounds.y1 - bounds.y0) > kAffine;
    exact_.reset();
    if (!exact) return true;
    const auto map = plane_map(build.input.mesh, build.input.scene, build.set, face);
    if (!map) return false;
    exact_ = frame_from_texel(*map, view_);
    return true;
  }

  /// At a position in texels; the face's border beyond the face.
  Color at(double x, double y, const CoarsePhoto& coarse) const {
    double b = second_.at(x, y), c = third_.at(x, y);
    if (b < 0 || c < 0 || b + c > 1) {
      b = std::max(b, 0.0);
      c = std::max(c, 0.0);
      const double sum = std::max(1.0, b + c);
      b /= sum;
      c /= sum;
    }
    PhotoPoint q{photo_[0].x + b * (photo_[1].x - photo_[0].x) + c * (photo_[2].x - photo_[0].x),
                 photo_[0].y + b * (photo_[1].y - photo_[0].y) + c * (photo_[2].y - photo_[0].y)};
    if (exact_) {
      const auto frame =
          (*exact_)(corners_[0].x + b * (corners_[1].x - corners_[0].x) + c * (corners_[2].x - corners_[0].x),
                    corners_[0].y + b * (corners_[1].y - corners_[0].y) + c * (corners_[2].y - corners_[0].y));
      const auto place = frame ? photo_from_pixel(view_.camera, *frame) : std::nullopt;
      if (!place) return {};
      q = *place;
    }
    const Color factor = factor_[0] + static_cast<float>(b) * (factor_[1] - factor_[0]) +
                         static_cast<float>(c) * (factor_[2] - factor_[0]);
    return factor * coarse.at(q);
  }

 private:
  /// A corner's barycentric coordinate: 0 along the edge between the other two, 1 at the corner.
  struct Barycentric {
    Barycentric() = default;
    /// \param scale 1 / (doubled area), negative for a corner to the other side of the edge
    Barycentric(const TexelPoint& from, const TexelPoint& to, double scale)
        : per_x((to.y - from.y) * scale),
          per_y((from.x - to.x) * scale),
          constant(-(from.x * per_x + from.y * per_y)) {}
    double at(double x, double y) const { return constant + per_x * x + per_y * y; }
    double per_x = 0, per_y = 0, constant = 0;
  };

  /// False beyond where the lens ends.
  bool find_place(const WorldPoint& p, PhotoPoint& place) const {
    const CameraPoint c = camera_from_world(view_.pose, p);
    const auto q = c.z > 0 ? photo_from_pixel(view_.camera, pixel_from_camera(view_.camera, c)) : std::nullopt;
    place = q.value_or(PhotoPoint{});
    return q.has_value();
  }

  const BlendField& field_;
  ViewId id_;
  const View& view_;
  TexelTriangle corners_;
  Barycentric second_, third_;
  std::array<PhotoPoint, 3> photo_;
  std::array<Color, 3> factor_;
  std::optional<FrameFromTexel> exact_;
};

BlendField::BlendField(const AtlasBuild& build, std::uint32_t chart)
    : build_(build), number_(chart), chart_(build.set.charts[chart]), place_(build.places[chart]) {
  // A cell more on every side, which texels of the ring reach.
  box_ = {-1, -1, chart_.width / kBlendStep + 2, chart_.height / kBlendStep + 2};
  const int bands = (box_.y1 - box_.y0 + kBlendRows - 1) / kBlendRows;
  const auto band_of = [&](double y) {
    return std::clamp(static_cast<int>(std::floor((y - box_.y0) / kBlendRows)), 0, bands - 1);
  };
  faces_ = group_items<std::uint32_t>(static_cast<std::size_t>(bands), [&](const auto& add) {
    for (const std::uint32_t face : chart_.faces) {
      const Triangle& vertices = build.input.mesh.faces[face];
      if (std::ranges::all_of(vertices, [&](std::uint32_t v) { return build.blending.at(v).empty(); })) continue;
      const TexelTriangle t = cell_corners(build.set.corners[face]);
      const int low = band_of(std::min({t[0].y, t[1].y, t[2].y}) - 1.5);
      const int high = band_of(std::max({t[0].y, t[1].y, t[2].y}) + 1.5);
      for (int b = low; b <= high; ++b) add(static_cast<std::size_t>(b), face);
    }
  });
  if (faces_.items.empty()) {
    faces_ = {};
    return;
  }
  row_cells_ = (box_.x1 - box_.x0 + 63) / 64 * 64;
  face_cells_.resize(faces_.groups());
  has_.assign(pixel_index(0, box_.y1 - box_.y0, row_cells_) / 64, 0);
}

std::vector<std::uint32_t> BlendField::views_of(std::size_t band) const {
  std::vector<std::uint8_t> has(build_.input.scene.views.size(), 0);
  for (const std::uint32_t face : faces_[band])
    for (const std::uint32_t vertex : build_.input.mesh.faces[face])
      for (const BlendView& item : build_.blending.at(vertex)) has[item.view] = 1;
  std::vector<std::uint32_t> views;
  for (std::uint32_t v = 0; v < has.size(); ++v)
    if (has[v]) views.push_back(v);
  return views;
}

void BlendField::open(std::size_t band) {
  const int first = box_.y0 + static_cast<int>(band) * kBlendRows;
  const CellBox rows{box_.x0, first, box_.x1, std::min(box_.y1, first + kBlendRows)};
  std::vector<TexelTriangle> corners;
  std::vector<std::uint32_t> numbers;
  for (const std::uint32_t face : faces_[band]) {
    numbers.push_back(static_cast<std::uint32_t>(corners.size()));
    corners.push_back(cell_corners(build_.set.corners[face]));
  }
  const ChartRaster raster = rasterize(numbers, corners, rows);
  const int width = raster.width();
  face_cells_[band] = group_items<std::uint32_t>(numbers.size(), [&](const auto& emit) {
    for (int y = rows.y0; y < rows.y1; ++y)
      for (int x = 0; x < width; ++x) {
        const std::uint32_t owner = raster.owner[pixel_index(x, y - rows.y0, width)];
        if (owner != kNoOwner) emit(owner, static_cast<std::uint32_t>(cell_at(rows.x0 + x, y)));
      }
  });
  for (const std::uint32_t cell : face_cells_[band].items) has_[cell / 64] |= std::uint64_t{1} << (cell % 64);
}

void BlendField::begin() {
  std::uint32_t count = 0;
  before_.reserve(has_.size());
  for (const std::uint64_t word : has_) {
    before_.push_back(count);
    count += static_cast<std::uint32_t>(std::popcount(word));
  }
  sums_.resize(count);
}

std::size_t BlendField::sum_of(std::size_t cell) const {
  const std::uint64_t lower = (std::uint64_t{1} << (cell % 64)) - 1;
  return before_[cell / 64] + static_cast<std::size_t>(std::popcount(has_[cell / 64] & lower));
}

void BlendField::add(std::size_t band, ViewId id, const CoarsePhoto& coarse) {
  FaceShare share(*this, id, build_.input.scene.views[index(id)]);
  constexpr double kStep = kBlendStep;
  const auto columns = static_cast<std::uint32_t>(row_cells_);
  for (std::size_t f = 0; f < faces_[band].size(); ++f) {
    const std::span<const std::uint32_t> cells = std::as_const(face_cells_[band])[f];
    if (cells.empty() || !share.prepare(faces_[band][f])) continue;
    std::uint32_t before = cells.front();
    std::size_t at = sum_of(before);
    int column = box_.x0 + static_cast<int>(before % columns), row = box_.y0 + static_cast<int>(before / columns);
    for (const std::uint32_t cell : cells) {
      // A face's cells follow each other in rows, and so do their sums.
      if (cell == before + 1 && cell % 64 != 0) {
        ++at;
        ++column;
      } else if (cell != before) {
        at = sum_of(cell);
        column = box_.x0 + static_cast<int>(cell % columns);
        row = box_.y0 + static_cast<int>(cell / columns);
      }
      before = cell;
      const Color color = share.at((column + 0.5) * kStep, (row + 0.5) * kStep, coarse);
      Sum& sum = sums_[at];
      sum[0] = static_cast<std::int16_t>(sum[0] + in_units(color.r));
      sum[1] = static_cast<std::int16_t>(sum[1] + in_units(color.g));
      sum[2] = static_cast<std::int16_t>(sum[2] + in_units(color.b));
    }
  }
}

void BlendField::add_row(int row, float weight, std::span<ColorMean> columns) const {
  if (row < box_.y0 || row >= box_.y1) return;
  std::size_t sum = 0;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const std::size_t cell = cell_at(box_.x0, row) + i;
    if (i % 64 == 0) sum = before_[cell / 64];
    if (!has_sum(cell)) continue;
    const auto [r, g, b] = sums_[sum++];
    columns[i].add({static_cast<float>(r), static_cast<float>(g), static_cast<float>(b)}, weight);
  }
}

void BlendField::apply(AtlasBuild& build) const {
  if (sums_.empty()) return;
  Page& page = build.page_of(number_);
  constexpr double kStep = kBlendStep;
  tbb::parallel_for(-1, chart_.height + 1, [&](int y) {
    // Bilinear between cells, those without a sum left out: first down, then across.
    const double v = (y + 0.5) / kStep - 0.5;
    const int row = static_cast<int>(std::floor(v));
    const auto down = static_cast<float>(v - row);
    std::vector<ColorMean> columns(static_cast<std::size_t>(box_.x1 - box_.x0));
    add_row(row, 1 - down, columns);
    add_row(row + 1, down, columns);
    for (int x = -1; x <= chart_.width; ++x) {
      const auto texel = place_.texel(x, y);
      if (texel.x < 0 || texel.y < 0 || texel.x >= page.image.width || texel.y >= page.image.height) continue;
      const std::size_t at = page.at(texel.x, texel.y);
      if (page.state[at] == TexelState::empty || page.owner(texel.x, texel.y) != number_) continue;
      const double u = (x + 0.5) / kStep - 0.5 - box_.x0;
      const auto column = static_cast<std::size_t>(u);
      const auto across = static_cast<float>(u - static_cast<double>(column));
      const ColorMean &left = columns[column], &right = columns[column + 1];
      const float weight = (1 - across) * left.weight + across * right.weight;
      if (!(weight > 0)) continue;
      const Color sum = (1 - across) * left.sum + across * right.sum;
      std::uint8_t* to = page.image.pixels.data() + 3 * at;
      store(to, load(to) + (1 / (kUnit * weight)) * sum);
    }
  });
}

}  // namespace gpvc::atlas
