#include "app/evaluate/score_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <opencv2/imgproc.hpp>

namespace gpvc::evaluate {
namespace {

constexpr int kBand = 44, kPanelGap = 8, kTextMargin = 6;
constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
constexpr double kLetters = 0.42;
constexpr int kMostEnlarged = 800;  // a photo's name may be longer than any picture is wide

struct Panel {
  const Image* image;
  std::array<std::string, 2> lines;
};

// Two lines, cut off where the panel ends, and the enlarged picture under them.
void draw_panel(const Panel& panel, int factor, cv::Mat part) {
  part.rowRange(0, kBand).setTo(cv::Scalar::all(24));
  for (int line = 0; line < 2; ++line)
    cv::putText(part.rowRange(0, kBand), panel.lines[static_cast<std::size_t>(line)], {kTextMargin, 17 + 18 * line},
                kFont, kLetters, cv::Scalar::all(line == 0 ? 255 : 190), 1, cv::LINE_AA);
  const Image& image = *panel.image;
  const cv::Mat small(image.height, image.width, CV_8UC3, const_cast<std::uint8_t*>(image.pixels.data()));
  cv::resize(small, part.rowRange(kBand, part.rows), {}, factor, factor, cv::INTER_NEAREST);
}

}  // namespace

Image score_picture(const std::string& view, const Rephotography& compared, int reduction) {
  const auto& [red, green, blue] = compared.gain;
  const RephotographyScore& score = compared.score;
  const std::array<Panel, 3> panels{
      Panel{&compared.photo,
            {"photo " + view, reduction == 1
                                  ? "as taken, without lens distortion"
                                  : fmt::format("as taken, without lens distortion, 1/{} of its size", reduction)}},
      Panel{&compared.render,
            {"render of the model",
             fmt::format("as it is; the photo is {:.2f}, {:.2f}, {:.2f} x as bright", red, green, blue)}},
      Panel{&compared.error,
            {score.windows == 0 ? "error: there is nothing to compare"
                                : fmt::format("error: 1 - NCC {:.4f}, SSIM {:.4f}", score.ncc_error, score.ssim),
             "around each pixel: black 0, white 1; blue: not compared"}}};
  const int width = compared.photo.width, height = compared.photo.height;
  int wanted = width;
  for (const Panel& panel : panels)
    for (const std::string& line : panel.lines)
      wanted = std::max(wanted, cv::getTextSize(line, kFont, kLetters, 1, nullptr).width + 2 * kTextMargin);
  const int factor = (std::min(std::max(width, kMostEnlarged), wanted) + width - 1) / width;
  Image picture{3 * factor * width + 2 * kPanelGap, kBand + factor * height, 3, {}};
  picture.pixels.assign(3 * pixel_index(0, picture.height, picture.width), 255);
  cv::Mat canvas(picture.height, picture.width, CV_8UC3, picture.pixels.data());
  for (int n = 0; n < 3; ++n) {
    const int x = n * (factor * width + kPanelGap);
    draw_panel(panels[static_cast<std::size_t>(n)], factor, canvas.colRange(x, x + factor * width));
  }
  return picture;
}

}  // namespace gpvc::evaluate
