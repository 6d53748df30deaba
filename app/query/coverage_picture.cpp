// The picture of a mesh from above, coloured by the number of photos.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "app/query/coverage_files.h"
#include "io/reference_system.h"

namespace gpvc::query {
namespace {

using Color = std::array<std::uint8_t, 3>;

struct Shade {
  std::uint32_t photos;  ///< at least
  Color color;
  const char* label;
};
// From red to blue through light colours, which people who cannot tell red from green tell apart by their brightness.
constexpr Shade kShades[] = {{0, {120, 0, 40}, "none"},          {1, {215, 48, 39}, "1"},
                             {2, {252, 141, 89}, "2"},           {3, {254, 224, 144}, "3"},
                             {4, {224, 243, 248}, "4-5"},        {6, {145, 191, 219}, "6-9"},
                             {10, {69, 117, 180}, "10 and more"}};
constexpr Color kNothing{255, 255, 255}, kText{30, 30, 30}, kHatch{0, 0, 0};
constexpr int kLegend = 92, kMargin = 12, kHatchStep = 8, kLeastWidth = 760;
constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
constexpr double kLetters = 0.45;

Color color_of(std::uint32_t photos) {
  Color color = kShades[0].color;
  for (const Shade& shade : kShades)
    if (photos >= shade.photos) color = shade.color;
  return color;
}

cv::Scalar scalar(const Color& c) {
  return {static_cast<double>(c[0]), static_cast<double>(c[1]), static_cast<double>(c[2])};
}

void write_text(cv::Mat& canvas, const std::string& text, int x, int y) {
  cv::putText(canvas, text, {x, y}, kFont, kLetters, scalar(kText), 1, cv::LINE_AA);
}

int width_of(const std::string& text) { return cv::getTextSize(text, kFont, kLetters, 1, nullptr).width; }

// 1, 2 or 5 times a power of ten, at most a quarter of the picture.
double bar_length(double width) {
  const double power = std::pow(10.0, std::floor(std::log10(width / 4)));
  for (const double step : {5.0, 2.0})
    if (step * power <= width / 4) return step * power;
  return power;
}

void draw_legend(cv::Mat& canvas, int top, const Wanted& wanted, const CellGrid& grid, const Ground& ground) {
  int x = kMargin;
  write_text(canvas, "photos that see it:", x, top + 22);
  x += width_of("photos that see it:") + 14;
  for (const Shade& shade : kShades) {
    cv::rectangle(canvas, {x, top + 9}, {x + 18, top + 25}, scalar(shade.color), cv::FILLED);
    cv::rectangle(canvas, {x, top + 9}, {x + 18, top + 25}, scalar(kText));
    write_text(canvas, shade.label, x + 24, top + 22);
    x += 24 + width_of(shade.label) + 14;
  }
  cv::rectangle(canvas, {kMargin, top + 35}, {kMargin + 18, top + 51}, scalar(kText));
  cv::line(canvas, {kMargin, top + 51}, {kMargin + 18, top + 35}, scalar(kHatch));
  write_text(canvas,
             fmt::format("hatched: enough photos, but coarser than {:.3g} or more than {:.3g} degrees off", wanted.gsd,
                         wanted.angle),
             kMargin + 24, top + 48);
  const double bar = bar_length(grid.width * grid.cell);
  const int pixels = static_cast<int>(std::lround(bar / grid.cell));
  cv::rectangle(canvas, {kMargin, top + 66}, {kMargin + pixels, top + 71}, scalar(kText), cv::FILLED);
  const std::string unit = ground.wkt.empty() ? "" : io::system_name(ground.wkt).unit;
  write_text(canvas,
             fmt::format("{:g} {}{}; white: no surface", bar,
                         unit == "metre" ? "m"
                         : unit.empty()  ? "units"
                                         : unit,
                         ground.wkt.empty() ? "" : ", north is up"),
             kMargin + pixels + 10, top + 73);
}

}  // namespace

Image coverage_picture(const Ground& ground, const FaceCoverage& coverage, const std::vector<Lack>& lacks,
                       const Wanted& wanted, const CellGrid& grid) {
  const std::size_t cells = static_cast<std::size_t>(grid.width) * static_cast<std::size_t>(grid.height);
  std::vector<double> height(cells, -std::numeric_limits<double>::infinity());
  std::vector<FaceId> face(cells, kNoFace);
  for (std::uint32_t f = 0; f < ground.mesh.faces.size(); ++f) {
    const auto [a, b, c] = ground.mesh.faces[f];
    for_each_cell_in(grid, {ground.mesh.positions[a], ground.mesh.positions[b], ground.mesh.positions[c]},
                     [&](int i, int j, double z) {
                       const std::size_t at = pixel_index(i, j, grid.width);
                       if (z <= height[at]) return;
                       height[at] = z;
                       face[at] = FaceId{f};
                     });
  }
  Image picture{std::max(grid.width, kLeastWidth), grid.height + kLegend, 3, {}};
  picture.pixels.assign(3 * pixel_index(0, picture.height, picture.width), 255);
  for (int j = 0; j < grid.height; ++j)
    for (int i = 0; i < grid.width; ++i) {
      const FaceId shown = face[pixel_index(i, grid.height - 1 - j, grid.width)];
      Color color = kNothing;
      if (shown != kNoFace) {
        const Lack lack = lacks[index(shown)];
        const bool hatched = (lack == Lack::coarse || lack == Lack::grazing) && (i + j) % kHatchStep == 0;
        color = hatched ? kHatch : color_of(coverage.photos[index(shown)]);
      }
      std::ranges::copy(color, picture.at(i, j));
    }
  cv::Mat canvas(picture.height, picture.width, CV_8UC3, picture.pixels.data());
  draw_legend(canvas, grid.height, wanted, grid, ground);
  return picture;
}

}  // namespace gpvc::query
