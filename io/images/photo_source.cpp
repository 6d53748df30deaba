// Photos from pictures in memory or a callback.
#include <stdexcept>
#include <string>

#include "io/images/mask_file.h"
#include "io/photos.h"

namespace gpvc::io {

namespace {

void check_picture(const View& view, const Image& image) {
  if (image.width != view.camera.width || image.height != view.camera.height || image.channels != 3)
    throw std::invalid_argument("the picture of view " + view.name + " is " + std::to_string(image.width) + " x " +
                                std::to_string(image.height) + " pixels of " + std::to_string(image.channels) +
                                " channels, expected " + std::to_string(view.camera.width) + " x " +
                                std::to_string(view.camera.height) + " of 3");
}

/// Null for a scene without bands.
std::shared_ptr<const Samples> usable_samples(const Scene& scene, const View& view, Picture&& picture) {
  if (!scene.bands) return nullptr;
  const BandSet& bands = *scene.bands;
  const std::string expected = std::to_string(bands.bands.size()) + " bands of " +
                               std::string(name_of(kSampleTypeNames, bands.type)) + " and of the picture's size";
  if (!picture.samples) throw std::invalid_argument("view " + view.name + " has no samples, expected " + expected);
  Samples& samples = *picture.samples;
  if (samples.width != view.camera.width || samples.height != view.camera.height ||
      samples.bands != bands.bands.size() || samples.type != bands.type ||
      samples.bytes.size() != pixel_index(0, samples.height, samples.width) * samples.pixel_bytes())
    throw std::invalid_argument("view " + view.name + " has other samples than expected: " + expected);
  if (picture.exclusion) paint_over(samples, *picture.exclusion);
  return std::make_shared<const Samples>(std::move(samples));
}

std::shared_ptr<const Image> usable_image(const View& view, Picture&& picture) {
  check_picture(view, picture.image);
  if (picture.exclusion) paint_over(picture.image, *picture.exclusion);
  return std::make_shared<const Image>(std::move(picture.image));
}

}  // namespace

PictureSource::PictureSource(const Scene& scene, std::vector<Picture> pictures) {
  if (pictures.size() != scene.views.size())
    throw std::invalid_argument("a scene of " + std::to_string(scene.views.size()) + " views was given " +
                                std::to_string(pictures.size()) + " pictures");
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    exclusions_.push_back(pictures[i].exclusion ? std::make_shared<const PhotoExclusion>(*pictures[i].exclusion)
                                                : nullptr);
    samples_.push_back(usable_samples(scene, scene.views[i], std::move(pictures[i])));
    images_.push_back(usable_image(scene.views[i], std::move(pictures[i])));
  }
}

std::shared_ptr<const Image> PictureSource::photo(ViewId view) { return images_.at(index(view)); }
std::shared_ptr<const PhotoExclusion> PictureSource::exclusion(ViewId view) { return exclusions_.at(index(view)); }

std::shared_ptr<const Samples> PictureSource::samples(ViewId view) { return samples_.at(index(view)); }

CallbackSource::CallbackSource(const Scene& scene, Load load) : scene_(scene), load_(std::move(load)) {}

std::shared_ptr<const Image> CallbackSource::photo(ViewId view) {
  return usable_image(scene_.views.at(index(view)), load_(view));
}

std::shared_ptr<const Samples> CallbackSource::samples(ViewId view) {
  return usable_samples(scene_, scene_.views.at(index(view)), load_(view));
}

std::shared_ptr<const PhotoExclusion> CallbackSource::exclusion(ViewId view) {
  Picture picture = load_(view);
  check_picture(scene_.views.at(index(view)), picture.image);
  if (!picture.exclusion) return nullptr;
  return std::make_shared<const PhotoExclusion>(std::move(*picture.exclusion));
}

std::vector<std::filesystem::path> files_of(const View& view) {
  std::vector<std::filesystem::path> files;
  if (!view.photo.empty()) files.push_back(view.photo);
  for (const std::filesystem::path& file : view.band_files)
    if (file != view.photo) files.push_back(file);
  if (!view.mask.empty()) files.push_back(view.mask);
  return files;
}

}  // namespace gpvc::io
