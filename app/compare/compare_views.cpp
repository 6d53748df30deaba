#include "app/compare/compare_views.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace gpvc::compare {
namespace {

constexpr int kCropWidth = 480, kCropHeight = 360;
constexpr int kThumbnailWidth = 500;  ///< roughly; windows to show are searched in renders reduced to this width
constexpr int kRenderQuality = 95;

int thumbnail_factor(int width) { return std::max(1, width / kThumbnailWidth); }

// Luma of a smaller picture.
Image thumbnail(const Image& image) {
  const int factor = thumbnail_factor(image.width);
  Image small;
  small.width = image.width / factor;
  small.height = image.height / factor;
  small.channels = 1;
  small.pixels.resize(static_cast<std::size_t>(small.width) * static_cast<std::size_t>(small.height));
  for (int y = 0; y < small.height; ++y)
    for (int x = 0; x < small.width; ++x) {
      int sum = 0;
      for (int n = 0; n < factor * factor; ++n) {
        const std::uint8_t* rgb = image.at(x * factor + n % factor, y * factor + n / factor);
        sum += 299 * rgb[0] + 587 * rgb[1] + 114 * rgb[2];
      }
      *small.at(x, y) = static_cast<std::uint8_t>(sum / (1000 * factor * factor));
    }
  return small;
}

// Per pixel of the thumbnails the mean deviation of the models from their mean.
std::vector<double> disagreement(std::span<const ShownModel> models, std::size_t view) {
  const auto count = static_cast<double>(models.size());
  std::vector<double> result(models.front().thumbnails[view].pixels.size());
  for (std::size_t i = 0; i < result.size(); ++i) {
    double mean = 0;
    for (const ShownModel& model : models) mean += model.thumbnails[view].pixels[i] / count;
    for (const ShownModel& model : models) result[i] += std::abs(model.thumbnails[view].pixels[i] - mean) / count;
  }
  return result;
}

Image cut_out(const Image& image, int x0, int y0, int width, int height) {
  Image part;
  part.width = width;
  part.height = height;
  part.channels = 3;
  part.pixels.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3);
  for (int y = 0; y < height; ++y)
    std::copy_n(image.at(x0, y0 + y), static_cast<std::size_t>(width) * 3, part.at(0, y));
  return part;
}

// Mean absolute difference over the channels of the `counted` pixels; each channel of the render is first multiplied by
// one gain so that its mean equals the photo's.
double mean_difference(const Image& photo, const Image& render, const std::vector<bool>& counted) {
  double sum = 0;
  const auto pixels = static_cast<double>(std::count(counted.begin(), counted.end(), true));
  for (std::size_t c = 0; c < 3; ++c) {
    double taken = 0, made = 0;
    for (std::size_t i = 0; i < counted.size(); ++i) {
      if (!counted[i]) continue;
      taken += photo.pixels[3 * i + c];
      made += render.pixels[3 * i + c];
    }
    const double gain = made > 0 ? taken / made : 1.0;
    for (std::size_t i = 0; i < counted.size(); ++i)
      if (counted[i]) sum += std::abs(photo.pixels[3 * i + c] - gain * render.pixels[3 * i + c]);
  }
  return pixels > 0 ? sum / (3 * pixels) : 0;
}

bool overlap(int a, int a_length, int b, int b_length) { return a < b + b_length && b < a + a_length; }

struct MeanError {
  double mean = 0, windows = 0;
  explicit MeanError(const std::vector<evaluate::TileError>& tiles) {
    for (const evaluate::TileError& tile : tiles) {
      mean += tile.sum;
      windows += static_cast<double>(tile.windows);
    }
    if (windows > 0) mean /= windows;
  }
  // How far a tile's sum is from what the mean lets expect, as a share of all windows.
  double residual(const evaluate::TileError& tile) const {
    return (tile.sum - mean * static_cast<double>(tile.windows)) / windows;
  }
};

}  // namespace

std::optional<ErrorDifference> difference(const ShownModel& model, const ShownModel& from) {
  double less = 0, variance = 0, views = 0;
  for (std::size_t v = 0; v < model.tiles.size(); ++v) {
    const MeanError mine(model.tiles[v]), theirs(from.tiles[v]);
    if (mine.windows == 0 || theirs.windows == 0) continue;
    ++views;
    less += theirs.mean - mine.mean;
    // The variance of a ratio of sums over tiles, from each tile's residual (Cochran 1977, 6.3).
    double squares = 0, tiles = 0;
    for (std::size_t t = 0; t < model.tiles[v].size(); ++t) {
      const evaluate::TileError &a = model.tiles[v][t], &b = from.tiles[v][t];
      if (a.windows + b.windows == 0) continue;
      const double residual = theirs.residual(b) - mine.residual(a);
      squares += residual * residual;
      ++tiles;
    }
    if (tiles > 1) variance += squares * tiles / (tiles - 1);
  }
  if (views == 0) return std::nullopt;
  return ErrorDifference{less / views, std::sqrt(variance) / views};
}

ModelViews::ModelViews(const checks::Input& input, io::PhotoSource& photos, ModelViewsOptions options,
                       const Progress& progress)
    : input_(input), photos_(photos), options_(std::move(options)) {
  for (const ViewId id : options_.scored) {
    progress(scored_photos_.size(), options_.scored.size());
    scored_photos_.push_back(evaluate::photo_to_compare(*photos.photo(id), photos.exclusion(id).get(),
                                                        input.scene.views[index(id)], input.mesh));
  }
}

ShownModel ModelViews::show(std::size_t number, const io::TexturedModel& model, const std::vector<Image>& pages,
                            const WorldPoint& offset, const Progress& progress) const {
  std::set<ViewId> all(options_.scored.begin(), options_.scored.end());
  all.insert(options_.cropped.begin(), options_.cropped.end());
  ShownModel shown;
  std::vector<evaluate::RephotographyScore> scores;
  std::size_t done = 0;
  for (const ViewId id : all) {
    progress(done++, all.size());
    const pipeline::RenderResult render = evaluate::render_view(model, pages, input_.scene.views[index(id)], offset);
    if (std::binary_search(options_.cropped.begin(), options_.cropped.end(), id)) {
      shown.renders.push_back(options_.renders / fmt::format("{}_{}.jpg", number, shown.renders.size()));
      io::write_image(shown.renders.back(), render.image, io::ImageFormat::jpg, kRenderQuality);
      shown.thumbnails.push_back(thumbnail(render.image));
    }
    const auto at = std::lower_bound(options_.scored.begin(), options_.scored.end(), id);
    if (at == options_.scored.end() || *at != id) continue;
    evaluate::Rephotography compared = evaluate::compare_with_photo(
        scored_photos_[static_cast<std::size_t>(at - options_.scored.begin())], render, options_.reduction);
    shown.tiles.push_back(std::move(compared.tiles));
    scores.push_back(compared.score);
  }
  shown.score = evaluate::mean_score(scores);
  return shown;
}

std::vector<ModelViews::Window> ModelViews::windows(std::span<const ShownModel> models, std::size_t view) const {
  const Camera& camera = cropped_view(view).camera;
  const int factor = thumbnail_factor(camera.width);
  const Image& small = models.front().thumbnails[view];
  const int width = std::clamp(camera.width / 2, 1, kCropWidth), height = std::clamp(camera.height / 2, 1, kCropHeight);
  const int w = std::max(1, width / factor), h = std::max(1, height / factor);
  const std::vector<double> deviations = disagreement(models, view);
  const std::vector<std::uint8_t> covered = evaluate::covered_pixels(input_.mesh, cropped_view(view));
  std::vector<Window> found;
  for (int y = 0; y + h <= small.height; y += std::max(1, h / 8))
    for (int x = 0; x + w <= small.width; x += std::max(1, w / 8)) {
      double sum = 0, shown = 0;
      for (int v = y; v < y + h; ++v)
        for (int u = x; u < x + w; ++u) {
          sum += deviations[pixel_index(u, v, small.width)];
          shown += covered[pixel_index(u * factor, v * factor, camera.width)] != 0 ? 1 : 0;
        }
      // Not where all models agree, or where the mesh covers less than half.
      if (sum == 0 || shown < 0.5 * w * h) continue;
      found.push_back({view, std::min(x * factor, camera.width - width), std::min(y * factor, camera.height - height),
                       width, height, sum / (w * h)});
    }
  return found;
}

std::vector<Crop> ModelViews::crops(std::span<const ShownModel> models, std::size_t count) const {
  if (models.empty()) return {};
  std::vector<Window> all, chosen;
  for (std::size_t view = 0; view < options_.cropped.size(); ++view) {
    const std::vector<Window> some = windows(models, view);
    all.insert(all.end(), some.begin(), some.end());
  }
  const auto by_disagreement = [](const Window& a, const Window& b) { return a.disagreement > b.disagreement; };
  std::stable_sort(all.begin(), all.end(), by_disagreement);
  for (const std::size_t most : {std::size_t{2}, count})
    for (const Window& window : all) {
      if (chosen.size() == count) break;
      std::size_t of_view = 0;
      bool apart = true;
      for (const Window& other : chosen) {
        if (other.view != window.view) continue;
        ++of_view;
        apart = apart && !(overlap(other.x, other.width, window.x, window.width) &&
                           overlap(other.y, other.height, window.y, window.height));
      }
      if (apart && of_view < most) chosen.push_back(window);
    }
  std::stable_sort(chosen.begin(), chosen.end(), by_disagreement);
  std::vector<Crop> result;
  for (const Window& window : chosen) result.push_back(cut(models, window));
  return result;
}

Crop ModelViews::cut(std::span<const ShownModel> models, const Window& window) const {
  const View& view = cropped_view(window.view);
  Crop crop{view.name, window.x, window.y, window.width, window.height, window.disagreement, {}, {}, {}};
  const ViewId id = options_.cropped[window.view];
  const evaluate::ComparedPhoto compared =
      evaluate::photo_to_compare(*photos_.photo(id), photos_.exclusion(id).get(), view, input_.mesh);
  crop.photo = cut_out(compared.photo, window.x, window.y, window.width, window.height);
  std::vector<bool> counted;  // the photo may show more than the mesh covers
  for (int y = window.y; y < window.y + window.height; ++y)
    for (int x = window.x; x < window.x + window.width; ++x) {
      const std::size_t i = pixel_index(x, y, view.camera.width);
      counted.push_back(compared.inside[i] != 0 && compared.covered[i] != 0);
    }
  for (const ShownModel& model : models) {
    const Image render = io::read_image(model.renders[window.view]);
    crop.renders.push_back(cut_out(render, window.x, window.y, window.width, window.height));
    crop.errors.push_back(mean_difference(crop.photo, crop.renders.back(), counted));
  }
  return crop;
}

}  // namespace gpvc::compare
