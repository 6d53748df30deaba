#include "app/ortho/tile.h"

#include <algorithm>
#include <cmath>

#include "io/bilinear.h"
#include "io/error.h"

namespace gpvc::ortho {
namespace {

constexpr std::uint32_t kEmpty = 0xFFFFFFFFU;

std::int64_t floor_divided(std::int64_t a, std::int64_t b) {
  return a / b - (a % b != 0 && (a < 0) != (b < 0) ? 1 : 0);
}
std::int64_t ceil_divided(std::int64_t a, std::int64_t b) { return -floor_divided(-a, b); }

// The columns of samples in a row that lie in a triangle; none where first > last.
struct Span {
  std::int64_t first, last;
};

// A triangle in plan, without its right and lower edges: of two triangles that share an edge, a sample on it lies in one.
class PlanTriangle {
 public:
  PlanTriangle(const PlanPoint& a, const PlanPoint& b, const PlanPoint& c) : corners_{a, b, c} {
    area_ = side(a, b, c.x, c.y);
    if (area_ < 0) std::swap(corners_[1], corners_[2]);
  }
  bool has_area() const { return area_ != 0; }
  std::int64_t first_row() const { return ceil_divided(least(&PlanPoint::y) - kPlanUnit / 2, kPlanUnit); }
  std::int64_t last_row() const { return floor_divided(most(&PlanPoint::y) - kPlanUnit / 2, kPlanUnit); }

  // Between two columns.
  Span in_row(std::int64_t row, Span span) const {
    for (std::size_t i = 0; i < 3; ++i) {
      const PlanPoint &a = corners_[i], &b = corners_[(i + 1) % 3];
      const std::int64_t dx = std::int64_t{b.x} - a.x, dy = std::int64_t{b.y} - a.y;
      const bool included = dy < 0 || (dy == 0 && dx > 0);
      const std::int64_t y = row * kPlanUnit + kPlanUnit / 2;
      // Inside where at_first + column * step >= 0.
      const std::int64_t at_first = side(a, b, kPlanUnit / 2, y) - (included ? 0 : 1), step = -dy * kPlanUnit;
      if (step > 0) span.first = std::max(span.first, ceil_divided(-at_first, step));
      if (step < 0) span.last = std::min(span.last, floor_divided(at_first, -step));
      if (step == 0 && at_first < 0) span.last = span.first - 1;
    }
    return span;
  }

 private:
  // Positive on the inner side of an edge. Differences are below 2^31, so that nothing overflows.
  static std::int64_t side(const PlanPoint& a, const PlanPoint& b, std::int64_t x, std::int64_t y) {
    return (std::int64_t{b.x} - a.x) * (y - a.y) - (std::int64_t{b.y} - a.y) * (x - a.x);
  }
  std::int64_t least(std::int32_t PlanPoint::*axis) const {
    return std::min({corners_[0].*axis, corners_[1].*axis, corners_[2].*axis});
  }
  std::int64_t most(std::int32_t PlanPoint::*axis) const {
    return std::max({corners_[0].*axis, corners_[1].*axis, corners_[2].*axis});
  }
  std::array<PlanPoint, 3> corners_;
  std::int64_t area_;
};

// Weights of a face's corners at the middles of samples.
class Weights {
 public:
  Weights(const Surface& surface, const Grid& grid, std::uint32_t face) {
    const Triangle& corners = surface.mesh.faces[face];
    std::array<std::array<double, 2>, 3> at{};
    for (std::size_t i = 0; i < 3; ++i) {
      const WorldPoint& p = surface.mesh.positions[corners[i]];
      at[i] = {(p.x - grid.west) / grid.spacing(), (grid.north - p.y) / grid.spacing()};
    }
    origin_ = at[0];
    const double bx = at[1][0] - at[0][0], by = at[1][1] - at[0][1], cx = at[2][0] - at[0][0], cy = at[2][1] - at[0][1];
    const double area = bx * cy - by * cx;
    if (area == 0) return;  // and still some samples in it, whose corners are rounded: it is seen edge-on
    b_ = {cy / area, -cx / area};
    c_ = {-by / area, bx / area};
  }
  // Corners that are rounded let samples lie outside: they take the colours of the rim.
  std::array<double, 3> at(std::int64_t column, std::int64_t row) const {
    const double x = static_cast<double>(column) + 0.5 - origin_[0], y = static_cast<double>(row) + 0.5 - origin_[1];
    const double b = std::max(b_[0] * x + b_[1] * y, 0.0), c = std::max(c_[0] * x + c_[1] * y, 0.0);
    if (b + c <= 1) return {1 - b - c, b, c};
    return {0, b / (b + c), c / (b + c)};
  }

 private:
  std::array<double, 2> origin_{}, b_{}, c_{};
};

// The textured face that is looked at.
class ShownFace {
 public:
  explicit ShownFace(const Drawing& of) : of_(of), weights_(of.surface, of.grid, 0) {}

  void take(std::uint32_t face) {
    if (face == face_) return;
    face_ = face;
    weights_ = Weights(of_.surface, of_.grid, face);
    page_ = of_.pages[of_.surface.model.face_page[face]];
    repeats_ = io::reaches_beyond_page(of_.surface.model, face);
    for (std::size_t i = 0; i < 3; ++i) {
      const io::TexCoord& at = of_.surface.model.texcoords[of_.surface.model.face_texcoords[face][i]];
      u_[i] = double{at.u} * page_.width;
      v_[i] = double{at.v} * page_.height;
    }
  }
  const StoredPage& page() const { return page_; }
  /// The place of a sample on the page, in texels.
  std::array<double, 2> place_of(std::int64_t column, std::int64_t row) const {
    const auto [a, b, c] = weights_.at(column, row);
    const double u = a * u_[0] + b * u_[1] + c * u_[2], v = a * v_[0] + b * v_[1] + c * v_[2];
    if (!repeats_) return {u, v};
    return {page_.width * repeated(u / page_.width), page_.height * repeated(v / page_.height)};
  }

 private:
  const Drawing& of_;
  std::uint32_t face_ = kEmpty;
  Weights weights_;
  StoredPage page_;
  bool repeats_ = false;
  std::array<double, 3> u_{}, v_{};
};

}  // namespace

void Rows::reset(int first_row, int rows, int row_width, std::size_t band_count) {
  first = first_row;
  width = row_width;
  const std::size_t pixels = pixel_index(0, rows, row_width);
  rgb.assign(3 * pixels, 0);
  mask.assign(pixels, 0);
  photo.assign(pixels, kNoPhoto);
  height.assign(pixels, kNoHeight);
  bands = band_count;
  samples.assign(bands * pixels, 0);
}

std::vector<PlanPoint> plan_points(const Surface& surface, const Grid& grid) {
  std::vector<PlanPoint> points(surface.mesh.positions.size());
  const double scale = kPlanUnit / grid.spacing();
  for (std::size_t v = 0; v < points.size(); ++v) {
    const WorldPoint& p = surface.mesh.positions[v];
    const double x = std::round((p.x - grid.west) * scale), y = std::round((grid.north - p.y) * scale);
    if (std::max(std::abs(x), std::abs(y)) > 0x1p30)
      throw InputError(
          surface.source, "vertex " + std::to_string(v),
          "is too far away for pixels as small as that: expected larger pixels, or a mesh without outliers");
    points[v] = {static_cast<std::int32_t>(x), static_cast<std::int32_t>(y)};
  }
  return points;
}

TileRenderer::TileRenderer(const Drawing& drawing)
    : of_(drawing), bands_(drawing.pages.bands() ? drawing.pages.bands()->bands.size() : 0) {
  const int n = of_.grid.samples, middle = n / 2;
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) from_middle_.push_back({x, y});
  const auto distance = [&](const std::array<int, 2>& s) {
    return (s[0] - middle) * (s[0] - middle) + (s[1] - middle) * (s[1] - middle);
  };
  std::ranges::stable_sort(from_middle_, {}, distance);
}

void TileRenderer::draw(const PixelBox& box, std::span<const std::uint32_t> faces, Rows& rows) {
  if (faces.empty()) return;  // rows are empty as they are
  box_ = box;
  columns_ = (box.x1 - box.x0) * of_.grid.samples;
  rows_ = (box.y1 - box.y0) * of_.grid.samples;
  samples_.assign(sample_index(0, rows_), {0, kEmpty});
  for (const std::uint32_t face : faces) draw_face(face);
  add_colors();
  write_pixels(rows);
}

void TileRenderer::draw_face(std::uint32_t face) {
  const Triangle& corners = of_.surface.mesh.faces[face];
  const PlanTriangle triangle(of_.plan[corners[0]], of_.plan[corners[1]], of_.plan[corners[2]]);
  if (!triangle.has_area()) return;
  const std::int64_t x0 = std::int64_t{box_.x0} * of_.grid.samples, y0 = std::int64_t{box_.y0} * of_.grid.samples;
  const std::int64_t first = std::max(triangle.first_row(), y0), last = std::min(triangle.last_row(), y0 + rows_ - 1);
  if (first > last) return;
  const Weights weights(of_.surface, of_.grid, face);
  const auto z = [&](std::size_t i) { return of_.surface.mesh.positions[corners[i]].z; };
  const std::array<double, 3> heights{z(0), z(1), z(2)};
  for (std::int64_t row = first; row <= last; ++row) {
    const Span span = triangle.in_row(row, {x0, x0 + columns_ - 1});
    for (std::int64_t column = span.first; column <= span.last; ++column) {
      const auto [a, b, c] = weights.at(column, row);
      const auto height = static_cast<float>(a * heights[0] + b * heights[1] + c * heights[2]);
      Sample& sample = samples_[sample_index(static_cast<int>(column - x0), static_cast<int>(row - y0))];
      if (sample.face == kEmpty || height > sample.height) sample = {height, face};
    }
  }
}

void TileRenderer::add_colors() {
  const int n = of_.grid.samples, width = box_.x1 - box_.x0;
  pixels_.assign(pixel_index(0, box_.y1 - box_.y0, width), {});
  band_sums_.assign(bands_ * pixels_.size(), 0);
  ShownFace shown(of_);
  for (int row = 0; row < rows_; ++row) {
    const Sample* sample = samples_.data() + sample_index(0, row);
    Pixel* pixel = pixels_.data() + pixel_index(0, row / n, width);
    const std::int64_t y = std::int64_t{box_.y0} * n + row;
    std::int64_t x = std::int64_t{box_.x0} * n;
    for (int column = 0; column < width; ++column, ++pixel) {
      Pixel sum{};
      for (int i = 0; i < n; ++i, ++sample, ++x) {
        if (sample->face == kEmpty) continue;
        ++sum.covered;
        if (of_.surface.kind[sample->face] != FaceKind::textured) continue;
        ++sum.textured;
        shown.take(sample->face);
        const auto [u, v] = shown.place_of(x, y);
        const std::array<float, 3> color = shown.page().at(u, v);
        if (bands_ > 0) {
          const auto number = static_cast<std::size_t>(pixel - pixels_.data());
          of_.pages.add_samples(shown.page(), u, v, std::span(band_sums_).subspan(bands_ * number, bands_));
        }
        for (std::size_t c = 0; c < 3; ++c) sum.color[c] += color[c];
      }
      for (std::size_t c = 0; c < 3; ++c) pixel->color[c] += sum.color[c];
      pixel->textured += sum.textured;
      pixel->covered += sum.covered;
    }
  }
}

void TileRenderer::write_pixels(Rows& rows) const {
  const int n = of_.grid.samples, width = box_.x1 - box_.x0;
  for (int y = box_.y0; y < box_.y1; ++y)
    for (int x = box_.x0; x < box_.x1; ++x) {
      const std::size_t number = pixel_index(x - box_.x0, y - box_.y0, width);
      const Pixel& pixel = pixels_[number];
      const bool is_shown = 2 * pixel.textured >= n * n, is_covered = 2 * pixel.covered >= n * n;
      if (!is_shown && !is_covered) continue;
      const std::size_t at = pixel_index(x, y - rows.first, rows.width);
      const auto next_to_middle = [&](bool textured) {
        for (const auto& [dx, dy] : from_middle_) {
          const Sample& sample = samples_[sample_index((x - box_.x0) * n + dx, (y - box_.y0) * n + dy)];
          if (sample.face != kEmpty && (!textured || of_.surface.kind[sample.face] == FaceKind::textured))
            return sample;
        }
        return Sample{kNoHeight, kEmpty};  // not where there is one
      };
      if (is_covered) rows.height[at] = next_to_middle(false).height;
      if (!is_shown) continue;
      rows.mask[at] = 255;
      for (std::size_t i = 0; i < 3; ++i)
        rows.rgb[3 * at + i] = static_cast<std::uint8_t>(pixel.color[i] / static_cast<float>(pixel.textured) + 0.5f);
      for (std::size_t b = 0; b < bands_; ++b)
        rows.samples[bands_ * at + b] = band_sums_[bands_ * number + b] / static_cast<float>(pixel.textured);
      if (!of_.surface.photo.empty()) rows.photo[at] = of_.surface.photo[next_to_middle(true).face];
    }
}

}  // namespace gpvc::ortho
