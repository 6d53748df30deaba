#include "app/compare/compare_views.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "app/evaluate/evaluate.h"
#include "app/pipeline/render_model.h"
#include "io/vector.h"

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

// Per pixel the mean deviation of the models from their mean.
std::vector<double> disagreement(const std::vector<std::vector<Image>>& thumbnails, std::size_t view) {
  const Image& first = thumbnails.front()[view];
  const auto models = static_cast<double>(thumbnails.size());
  std::vector<double> result(first.pixels.size());
  for (std::size_t i = 0; i < result.size(); ++i) {
    double mean = 0, deviation = 0;
    for (const auto& model : thumbnails) mean += model[view].pixels[i] / models;
    for (const auto& model : thumbnails) deviation += std::abs(model[view].pixels[i] - mean) / models;
    result[i] = deviation;
  }
  return result;
}

// Means over rectangles of a picture, each in O(1).
class RectangleSums {
 public:
  template <typename Value>
  RectangleSums(int width, int height, const Value& value)
      : columns_(static_cast<std::size_t>(width) + 1), sums_(columns_ * (static_cast<std::size_t>(height) + 1), 0.0) {
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        sums_[place(x + 1, y + 1)] = value(x, y) + sums_[place(x, y + 1)] + sums_[place(x + 1, y)] - sums_[place(x, y)];
  }

  double mean(int x, int y, int width, int height) const {
    return (sums_[place(x + width, y + height)] - sums_[place(x, y + height)] - sums_[place(x + width, y)] +
            sums_[place(x, y)]) /
           (width * height);
  }

 private:
  std::size_t place(int x, int y) const { return static_cast<std::size_t>(y) * columns_ + static_cast<std::size_t>(x); }

  std::size_t columns_;
  std::vector<double> sums_;  // over the rectangle from the corner
};

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

}  // namespace

ModelViews::ModelViews(const Mesh& mesh, const Scene& scene, io::PhotoSource& photos, ModelViewsOptions options,
                       const Progress& progress)
    : scene_(scene), photos_(photos), options_(std::move(options)) {
  for (const ViewId id : options_.scored) {
    progress(frames_.size(), options_.scored.size());
    const View& view = scene.views[index(id)];
    Frame frame;
    frame.photo = evaluate::photo_to_compare(*photos.photo(id), view, frame.inside);
    frame.covered = evaluate::covered_pixels(mesh, view.camera, view.pose);
    frames_.push_back(std::move(frame));
  }
  for (const ViewId id : options_.cropped) {
    const View& view = scene.views[index(id)];
    covered_.push_back(evaluate::covered_pixels(mesh, view.camera, view.pose));
  }
}

std::filesystem::path ModelViews::render_file(std::size_t model, std::size_t view) const {
  return options_.renders / fmt::format("{}_{}.jpg", model, view);
}

evaluate::RephotographyScore ModelViews::show(const io::TexturedModel& model, const std::vector<Image>& pages,
                                              const WorldPoint& offset, const Progress& progress) {
  std::set<ViewId> all(options_.scored.begin(), options_.scored.end());
  all.insert(options_.cropped.begin(), options_.cropped.end());
  std::vector<Image> small;
  std::vector<std::vector<evaluate::TileError>> tiles;
  std::vector<evaluate::RephotographyScore> scores;
  std::size_t done = 0;
  for (const ViewId id : all) {
    progress(done++, all.size());
    const View& view = scene_.views[index(id)];
    Pose pose = view.pose;
    pose.centre = pose.centre - offset;
    const pipeline::RenderResult render = pipeline::render_model(model, pages, view.camera, pose);
    if (std::binary_search(options_.cropped.begin(), options_.cropped.end(), id)) {
      io::write_image(render_file(thumbnails_.size(), small.size()), render.image, io::ImageFormat::jpg,
                      kRenderQuality);
      small.push_back(thumbnail(render.image));
    }
    const auto at = std::lower_bound(options_.scored.begin(), options_.scored.end(), id);
    if (at == options_.scored.end() || *at != id) continue;
    const Frame& frame = frames_[static_cast<std::size_t>(at - options_.scored.begin())];
    evaluate::Rephotography compared = evaluate::compare_with_photo(frame.photo, frame.inside, render.image,
                                                                    render.textured, frame.covered, options_.reduction);
    tiles.push_back(std::move(compared.tiles));
    scores.push_back(compared.score);
  }
  thumbnails_.push_back(std::move(small));
  tiles_.push_back(std::move(tiles));
  return evaluate::mean_score(scores);
}

ErrorDifference ModelViews::difference(std::size_t model, std::size_t from) const {
  ErrorDifference result;
  double variance = 0, views = 0;
  for (std::size_t v = 0; v < tiles_[model].size(); ++v) {
    const std::vector<evaluate::TileError>&mine = tiles_[model][v], &theirs = tiles_[from][v];
    const auto mean = [](const std::vector<evaluate::TileError>& tiles, double& windows) {
      double sum = 0;
      windows = 0;
      for (const evaluate::TileError& tile : tiles) {
        sum += tile.sum;
        windows += static_cast<double>(tile.windows);
      }
      return windows > 0 ? sum / windows : 0.0;
    };
    double my_windows = 0, their_windows = 0;
    const double my_mean = mean(mine, my_windows), their_mean = mean(theirs, their_windows);
    if (my_windows == 0 || their_windows == 0) continue;
    ++views;
    result.less += their_mean - my_mean;
    // The variance of a ratio of sums over tiles, from each tile's residual (Cochran 1977, 6.3).
    double squares = 0, tiles = 0;
    for (std::size_t t = 0; t < mine.size(); ++t) {
      const auto of = [](const evaluate::TileError& tile, double m, double windows) {
        return (tile.sum - m * static_cast<double>(tile.windows)) / windows;
      };
      if (mine[t].windows + theirs[t].windows == 0) continue;
      const double residual = of(theirs[t], their_mean, their_windows) - of(mine[t], my_mean, my_windows);
      squares += residual * residual;
      ++tiles;
    }
    if (tiles > 1) variance += squares * tiles / (tiles - 1);
  }
  if (views == 0) return result;
  result.less /= views;
  result.noise = std::sqrt(variance) / views;
  result.known = true;
  return result;
}

std::vector<ModelViews::Window> ModelViews::windows(std::size_t view) const {
  const Camera& camera = scene_.views[index(options_.cropped[view])].camera;
  const int factor = thumbnail_factor(camera.width);
  const Image& small = thumbnails_.front()[view];
  const int width = std::min(kCropWidth, camera.width / 2), height = std::min(kCropHeight, camera.height / 2);
  const int w = std::max(1, width / factor), h = std::max(1, height / factor);
  const std::vector<double> values = disagreement(thumbnails_, view);
  const std::vector<std::uint8_t>& covered = covered_[view];
  const RectangleSums disagreeing(small.width, small.height, [&](int x, int y) {
    return values[static_cast<std::size_t>(y) * static_cast<std::size_t>(small.width) + static_cast<std::size_t>(x)];
  });
  const RectangleSums differing(small.width, small.height, [&](int x, int y) {
    return values[static_cast<std::size_t>(y) * static_cast<std::size_t>(small.width) + static_cast<std::size_t>(x)] >
           0;
  });
  const RectangleSums shown(small.width, small.height, [&](int x, int y) {
    return covered[static_cast<std::size_t>(y * factor) * static_cast<std::size_t>(camera.width) +
                   static_cast<std::size_t>(x * factor)];
  });
  std::vector<Window> found;
  for (int y = 0; y + h <= small.height; y += std::max(1, h / 8))
    for (int x = 0; x + w <= small.width; x += std::max(1, w / 8)) {
      // Not where all models agree, or where the mesh leaves most of the window empty.
      if (differing.mean(x, y, w, h) == 0 || shown.mean(x, y, w, h) < 0.5) continue;
      found.push_back({view, std::min(x * factor, camera.width - width), std::min(y * factor, camera.height - height),
                       width, height, disagreeing.mean(x, y, w, h)});
    }
  return found;
}

std::vector<Crop> ModelViews::crops(std::size_t count) const {
  if (thumbnails_.empty()) return {};
  std::vector<Window> all, chosen;
  for (std::size_t view = 0; view < options_.cropped.size(); ++view) {
    const std::vector<Window> some = windows(view);
    all.insert(all.end(), some.begin(), some.end());
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const Window& a, const Window& b) { return a.disagreement > b.disagreement; });
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
  std::stable_sort(chosen.begin(), chosen.end(),
                   [](const Window& a, const Window& b) { return a.disagreement > b.disagreement; });
  std::vector<Crop> result;
  for (const Window& window : chosen) result.push_back(cut(window));
  return result;
}

Crop ModelViews::cut(const Window& window) const {
  const ViewId id = options_.cropped[window.view];
  const View& view = scene_.views[index(id)];
  Crop crop{view.name, window.x, window.y, window.width, window.height, window.disagreement, {}, {}, {}};
  std::vector<std::uint8_t> inside;
  const Image photo = evaluate::photo_to_compare(*photos_.photo(id), view, inside);
  crop.photo = cut_out(photo, window.x, window.y, window.width, window.height);
  std::vector<bool> counted;  // the photo may show more than the mesh covers
  for (int y = window.y; y < window.y + window.height; ++y)
    for (int x = window.x; x < window.x + window.width; ++x) {
      const std::size_t i =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(view.camera.width) + static_cast<std::size_t>(x);
      counted.push_back(inside[i] != 0 && covered_[window.view][i] != 0);
    }
  for (std::size_t model = 0; model < thumbnails_.size(); ++model) {
    const Image render = io::read_image(render_file(model, window.view));
    crop.renders.push_back(cut_out(render, window.x, window.y, window.width, window.height));
    crop.errors.push_back(mean_difference(crop.photo, crop.renders.back(), counted));
  }
  return crop;
}

}  // namespace gpvc::compare
