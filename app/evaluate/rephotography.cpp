#include "app/evaluate/rephotography.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "app/pipeline/undistort.h"
#include "io/color_difference.h"
#include "io/photos.h"
#include "io/vector.h"
#include "visibility/item_buffer.h"

namespace gpvc::evaluate {
namespace {

constexpr int kWindow = 11;
constexpr double kSigma = 1.5;

// 255 at the centres of windows that hold scored pixels only.
cv::Mat whole_windows(const cv::Mat& scored) {
  cv::Mat eroded;
  cv::erode(scored, eroded, cv::Mat::ones(kWindow, kWindow, CV_8U), {-1, -1}, 1, cv::BORDER_CONSTANT, cv::Scalar(0));
  return eroded;
}

// The mean of each reduction x reduction block, unrounded; a remainder at the right and bottom is cut.
cv::Mat reduce(const Image& image, int reduction) {
  const int width = image.width / reduction, height = image.height / reduction;
  const cv::Mat full(image.height, image.width, CV_8UC3, const_cast<std::uint8_t*>(image.pixels.data()));
  cv::Mat exact;
  full(cv::Rect(0, 0, width * reduction, height * reduction)).convertTo(exact, CV_32F);
  cv::Mat reduced;
  cv::resize(exact, reduced, {width, height}, 0, 0, cv::INTER_AREA);
  return reduced;
}

// 255 for blocks all of whose pixels are marked in both.
cv::Mat reduce_mask(std::span<const std::uint8_t> a, std::span<const std::uint8_t> b, cv::Size size, int reduction) {
  cv::Mat reduced(size.height / reduction, size.width / reduction, CV_8U);
  for (int y = 0; y < reduced.rows; ++y)
    for (int x = 0; x < reduced.cols; ++x) {
      bool whole = true;
      for (int dy = 0; dy < reduction && whole; ++dy)
        for (int dx = 0; dx < reduction && whole; ++dx) {
          const std::size_t i = pixel_index(x * reduction + dx, y * reduction + dy, size.width);
          whole = a[i] != 0 && b[i] != 0;
        }
      reduced.at<std::uint8_t>(y, x) = whole ? 255 : 0;
    }
  return reduced;
}

cv::Mat luma(const cv::Mat& rgb) {
  cv::Mat grey;
  cv::cvtColor(rgb, grey, cv::COLOR_RGB2GRAY);  // BT.601
  cv::Mat exact;
  grey.convertTo(exact, CV_64F);
  return exact;
}

struct Moments {
  cv::Mat mean_a, mean_b, variance_a, variance_b, covariance;
};

template <class Filter>
Moments moments(const cv::Mat& a, const cv::Mat& b, Filter filter) {
  Moments m;
  cv::Mat aa, bb, ab;
  filter(a, m.mean_a);
  filter(b, m.mean_b);
  filter(a.mul(a), aa);
  filter(b.mul(b), bb);
  filter(a.mul(b), ab);
  m.variance_a = cv::max(aa - m.mean_a.mul(m.mean_a), 0.0);
  m.variance_b = cv::max(bb - m.mean_b.mul(m.mean_b), 0.0);
  m.covariance = ab - m.mean_a.mul(m.mean_b);
  return m;
}

double mean_ssim(const cv::Mat& a, const cv::Mat& b, const cv::Mat& windows) {
  const double c1 = 0.01 * 255 * 0.01 * 255, c2 = 0.03 * 255 * 0.03 * 255;
  const Moments m = moments(a, b, [](const cv::Mat& in, cv::Mat& out) {
    cv::GaussianBlur(in, out, {kWindow, kWindow}, kSigma, kSigma, cv::BORDER_REFLECT);
  });
  cv::Mat numerator = (2 * m.mean_a.mul(m.mean_b) + c1).mul(2 * m.covariance + c2);
  cv::Mat denominator = (m.mean_a.mul(m.mean_a) + m.mean_b.mul(m.mean_b) + c1).mul(m.variance_a + m.variance_b + c2);
  cv::Mat ssim = numerator / denominator;
  return cv::mean(ssim, windows)[0];
}

// 1 - NCC per window. The NCC of a window without contrast is 0, or 1 if the other has none either.
cv::Mat ncc_errors(const cv::Mat& a, const cv::Mat& b) {
  const Moments m = moments(a, b, [](const cv::Mat& in, cv::Mat& out) {
    cv::boxFilter(in, out, CV_64F, {kWindow, kWindow}, {-1, -1}, true, cv::BORDER_REFLECT);
  });
  // Sums of squares of 8-bit values cancel to about 255^2 * 2^-52 * window area ~ 2e-9 grey levels squared.
  constexpr double kFlat = 1e-8;
  cv::Mat errors(a.size(), CV_64F);
  for (int y = 0; y < a.rows; ++y)
    for (int x = 0; x < a.cols; ++x) {
      const double va = m.variance_a.at<double>(y, x), vb = m.variance_b.at<double>(y, x);
      double ncc = va < kFlat && vb < kFlat ? 1.0 : 0.0;
      if (va >= kFlat && vb >= kFlat) ncc = m.covariance.at<double>(y, x) / std::sqrt(va * vb);
      errors.at<double>(y, x) = 1.0 - std::clamp(ncc, -1.0, 1.0);
    }
  return errors;
}

Image to_image(const cv::Mat& rgb) {
  cv::Mat bytes;
  rgb.convertTo(bytes, CV_8UC3);
  Image image;
  image.width = bytes.cols;
  image.height = bytes.rows;
  image.channels = 3;
  image.pixels.assign(bytes.datastart, bytes.dataend);
  return image;
}

std::vector<TileError> tile_errors(const cv::Mat& errors, const cv::Mat& windows) {
  std::vector<TileError> tiles(static_cast<std::size_t>(kErrorTiles) * kErrorTiles);
  for (int y = 0; y < errors.rows; ++y)
    for (int x = 0; x < errors.cols; ++x) {
      if (windows.at<std::uint8_t>(y, x) == 0) continue;
      TileError& tile =
          tiles[static_cast<std::size_t>(y * kErrorTiles / errors.rows * kErrorTiles + x * kErrorTiles / errors.cols)];
      tile.sum += errors.at<double>(y, x);
      ++tile.windows;
    }
  return tiles;
}

Image error_picture(const cv::Mat& errors, const cv::Mat& windows) {
  cv::Mat picture(errors.size(), CV_8UC3, cv::Scalar(60, 70, 90));
  for (int y = 0; y < errors.rows; ++y)
    for (int x = 0; x < errors.cols; ++x) {
      if (windows.at<std::uint8_t>(y, x) == 0) continue;
      const auto grey = static_cast<std::uint8_t>(std::lround(255 * std::min(errors.at<double>(y, x), 1.0)));
      picture.at<cv::Vec3b>(y, x) = {grey, grey, grey};
    }
  return to_image(picture);
}

double squared_error_over_channels(const cv::Mat& a, const cv::Mat& b, const cv::Mat& scored) {
  cv::Mat difference = a - b;
  const cv::Scalar mean = cv::mean(difference.mul(difference), scored);
  return (mean[0] + mean[1] + mean[2]) / 3;
}

double psnr(double squared_error) { return squared_error > 0 ? 10 * std::log10(255.0 * 255.0 / squared_error) : 99.0; }

/// CIEDE2000 of the scored pixels, row by row.
std::vector<float> color_errors(const cv::Mat& a, const cv::Mat& b, const cv::Mat& scored) {
  std::vector<std::vector<float>> rows(static_cast<std::size_t>(a.rows));
  tbb::parallel_for(0, a.rows, [&](int y) {
    const auto lab = [y](const cv::Mat& image, int x) {
      const auto& v = image.at<cv::Vec3f>(y, x);
      return lab_from_srgb({v[0], v[1], v[2]});
    };
    for (int x = 0; x < a.cols; ++x)
      if (scored.at<std::uint8_t>(y, x) != 0)
        rows[static_cast<std::size_t>(y)].push_back(static_cast<float>(color_difference(lab(a, x), lab(b, x))));
  });
  std::vector<float> all;
  for (const std::vector<float>& row : rows) all.insert(all.end(), row.begin(), row.end());
  return all;
}

double mean_of(const std::vector<float>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

void score_colors(const cv::Mat& taken, const cv::Mat& made, const cv::Mat& scored, RephotographyScore& score) {
  score.raw_psnr = psnr(squared_error_over_channels(taken, made, scored));
  std::vector<float> errors = color_errors(taken, made, scored);
  score.color_error = mean_of(errors);
  const auto most = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() * 95 / 100);
  std::nth_element(errors.begin(), most, errors.end());
  score.color_error_95 = *most;
}

// Mean absolute Laplacian of luma over its mean.
double relative_detail(const Image& image, const cv::Mat& scored) {
  const cv::Mat rgb(image.height, image.width, CV_8UC3, const_cast<std::uint8_t*>(image.pixels.data()));
  cv::Mat grey, laplacian;
  cv::cvtColor(rgb, grey, cv::COLOR_RGB2GRAY);
  cv::Laplacian(grey, laplacian, CV_16S);
  const double mean = cv::mean(grey, scored)[0];
  return mean > 0 ? cv::mean(cv::abs(laplacian), scored)[0] / mean : 0;
}

double sharpness_of(const Image& made, const Image& taken, const cv::Mat& scored) {
  cv::Mat inner;  // the Laplacian of a pixel has its neighbours
  cv::erode(scored, inner, cv::Mat::ones(3, 3, CV_8U), {-1, -1}, 1, cv::BORDER_CONSTANT, cv::Scalar(0));
  const double detail = relative_detail(taken, inner);
  return detail > 0 ? relative_detail(made, inner) / detail : 0;
}

// Those that only windows give.
constexpr double RephotographyScore::*kComparedFigures[] = {
    &RephotographyScore::psnr,        &RephotographyScore::gained_color_error, &RephotographyScore::ssim,
    &RephotographyScore::ncc_error,   &RephotographyScore::sharpness,          &RephotographyScore::raw_psnr,
    &RephotographyScore::color_error, &RephotographyScore::color_error_95};

}  // namespace

RephotographyScore mean_score(std::span<const RephotographyScore> scores) {
  RephotographyScore mean;
  double compared = 0, covering = 0;
  for (const RephotographyScore& score : scores) {
    mean.covered += score.covered;
    mean.windows += score.windows;
    if (score.covered > 0) {
      mean.completeness += score.completeness;
      ++covering;
    }
    if (score.windows == 0) continue;
    for (double RephotographyScore::*figure : kComparedFigures) mean.*figure += score.*figure;
    ++compared;
  }
  if (covering > 0) mean.completeness /= covering;
  if (compared > 0)
    for (double RephotographyScore::*figure : kComparedFigures) mean.*figure /= compared;
  return mean;
}

Json score_json(const RephotographyScore& score) {
  const auto known = [](std::size_t count, double value) { return count > 0 ? Json(value) : Json(nullptr); };
  const auto compared = [&](double value) { return known(score.windows, value); };
  return {{"completeness", known(score.covered, score.completeness)},
          {"psnr_db", compared(score.psnr)},
          {"ssim", compared(score.ssim)},
          {"one_minus_ncc", compared(score.ncc_error)},
          {"ciede2000_with_gain", compared(score.gained_color_error)},
          {"sharpness", compared(score.sharpness)},
          {"psnr_without_gain_db", compared(score.raw_psnr)},
          {"ciede2000", compared(score.color_error)},
          {"ciede2000_95", compared(score.color_error_95)},
          {"windows", score.windows}};
}

ComparedPhoto photo_to_compare(const Image& photo, const io::PhotoExclusion* excluded, const View& view,
                               const Mesh& mesh, const WorldPoint& offset) {
  const Camera& camera = view.camera;
  ComparedPhoto result;
  result.photo = pipeline::undistort_photo(photo, camera, {0, 0, camera.width, camera.height}, result.inside);
  result.covered = covered_pixels(mesh, view, offset);
  if (excluded == nullptr) return result;
  std::size_t pixel = 0;
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x, ++pixel) {
      if (result.inside[pixel] == 0) continue;
      const PhotoPoint p = *photo_from_pixel(camera, {x + 0.5, y + 0.5});
      if (excluded->excludes(std::min(static_cast<int>(p.x), excluded->width - 1),
                             std::min(static_cast<int>(p.y), excluded->height - 1)))
        result.inside[pixel] = 0;
    }
  return result;
}

std::vector<std::uint8_t> covered_pixels(const Mesh& mesh, const View& view, const WorldPoint& offset) {
  const visibility::Ivm ivm =
      visibility::draw_item_buffer(mesh, view.camera, {view.pose.rotation, view.pose.centre - offset});
  std::vector<std::uint8_t> covered(ivm.faces.size());
  std::transform(ivm.faces.begin(), ivm.faces.end(), covered.begin(),
                 [](FaceId face) -> std::uint8_t { return face == kNoFace ? 0 : 255; });
  return covered;
}

pipeline::RenderResult render_view(const io::TexturedModel& model, const std::vector<Image>& pages, const View& view,
                                   const WorldPoint& offset) {
  return pipeline::render_model(model, pages, view.camera, {view.pose.rotation, view.pose.centre - offset});
}

Rephotography compare_with_photo(const ComparedPhoto& photo, const pipeline::RenderResult& render, int reduction) {
  assert(photo.photo.width == render.image.width && photo.photo.height == render.image.height);
  Rephotography result;
  std::size_t textured = 0;
  for (std::size_t i = 0; i < photo.covered.size(); ++i) {
    if (photo.covered[i] == 0 || photo.inside[i] == 0) continue;
    ++result.score.covered;
    textured += render.textured[i] != 0 ? 1 : 0;
  }
  if (result.score.covered > 0)
    result.score.completeness = static_cast<double>(textured) / static_cast<double>(result.score.covered);

  reduction = std::min({reduction, photo.photo.width, photo.photo.height});
  const cv::Mat taken = reduce(photo.photo, reduction);
  cv::Mat made = reduce(render.image, reduction);
  const cv::Mat scored =
      reduce_mask(photo.inside, render.textured, {render.image.width, render.image.height}, reduction);
  const cv::Scalar taken_mean = cv::mean(taken, scored), made_mean = cv::mean(made, scored);
  cv::Scalar gain;
  for (int c = 0; c < 3; ++c) {
    gain[c] = made_mean[c] > 0 ? taken_mean[c] / made_mean[c] : 1.0;
    result.gain[static_cast<std::size_t>(c)] = gain[c];
  }
  const cv::Mat windows = whole_windows(scored);
  result.score.windows = static_cast<std::size_t>(cv::countNonZero(windows));
  if (result.score.windows > 0) score_colors(taken, made, scored, result.score);
  result.render = to_image(made);
  cv::multiply(made, gain, made);
  const cv::Mat errors = ncc_errors(luma(taken), luma(made));
  if (result.score.windows > 0) {
    result.score.psnr = psnr(squared_error_over_channels(taken, made, scored));
    result.score.gained_color_error = mean_of(color_errors(taken, made, scored));
    result.score.ssim = mean_ssim(luma(taken), luma(made), windows);
    result.score.ncc_error = cv::mean(errors, windows)[0];
    const cv::Size size(render.image.width, render.image.height);
    result.score.sharpness =
        sharpness_of(render.image, photo.photo, reduce_mask(photo.inside, render.textured, size, 1));
  }
  result.tiles = tile_errors(errors, windows);
  result.photo = to_image(taken);
  result.error = error_picture(errors, windows);
  return result;
}

}  // namespace gpvc::evaluate
