// Photos from pictures in memory or a callback.
#include <stdexcept>
#include <string>

#include "io/images/kept_photos.h"
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
std::shared_ptr<const Samples> take_samples(const Scene& scene, const View& view, Picture& picture) {
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
    samples_.push_back(take_samples(scene, scene.views[i], pictures[i]));
    images_.push_back(usable_image(scene.views[i], std::move(pictures[i])));
  }
}

std::shared_ptr<const Image> PictureSource::photo(ViewId view) { return images_.at(index(view)); }
std::shared_ptr<const PhotoExclusion> PictureSource::exclusion(ViewId view) { return exclusions_.at(index(view)); }

std::shared_ptr<const Samples> PictureSource::samples(ViewId view) { return samples_.at(index(view)); }

namespace {

struct MadePhoto {
  std::shared_ptr<const Samples> samples;  ///< null for a scene without bands
  Image image;
  std::optional<PhotoExclusion> exclusion{};
  std::size_t bytes() const {
    return image.pixels.size() + (exclusion ? 8 * exclusion->words.size() : 0) + (samples ? samples->bytes.size() : 0);
  }
};

}  // namespace

struct CallbackSource::State {
  State(const Scene& of, Load function) : scene(of), load(std::move(function)), kept(of.views.size(), 0) {}

  const Scene& scene;
  Load load;
  KeptPhotos<MadePhoto> kept;

  std::shared_ptr<const MadePhoto> fetch(ViewId id) {
    return kept.fetch(index(id), [&] {
      const View& view = scene.views.at(index(id));
      Picture picture = load(id);
      check_picture(view, picture.image);
      MadePhoto made{take_samples(scene, view, picture), std::move(picture.image), std::move(picture.exclusion)};
      if (made.exclusion) paint_over(made.image, *made.exclusion);
      return std::make_shared<const MadePhoto>(std::move(made));
    });
  }
};

CallbackSource::CallbackSource(const Scene& scene, Load load)
    : state_(std::make_unique<State>(scene, std::move(load))) {}

CallbackSource::~CallbackSource() = default;

std::shared_ptr<const Image> CallbackSource::photo(ViewId view) {
  const auto made = state_->fetch(view);
  return {made, &made->image};
}

std::shared_ptr<const Samples> CallbackSource::samples(ViewId view) { return state_->fetch(view)->samples; }

std::shared_ptr<const PhotoExclusion> CallbackSource::exclusion(ViewId view) {
  const auto made = state_->fetch(view);
  return made->exclusion ? std::shared_ptr<const PhotoExclusion>(made, &*made->exclusion) : nullptr;
}

void CallbackSource::keep_at_most(std::size_t bytes) { state_->kept.keep_at_most(bytes); }

PhotoDecodes CallbackSource::decodes() const { return state_->kept.decodes(); }

std::vector<std::filesystem::path> files_of(const View& view) {
  std::vector<std::filesystem::path> files;
  if (!view.photo.empty()) files.push_back(view.photo);
  for (const std::filesystem::path& file : view.band_files)
    if (file != view.photo) files.push_back(file);
  if (!view.mask.empty()) files.push_back(view.mask);
  return files;
}

}  // namespace gpvc::io
