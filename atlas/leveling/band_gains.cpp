#include "atlas/leveling/band_gains.h"

#include <memory>
#include <utility>

#include "atlas/baking/layers.h"

namespace gpvc::atlas {
namespace {

/// Photos as pictures of three of their bands.
class BandPictures final : public io::PhotoSource {
 public:
  BandPictures(io::PhotoSource& photos, const BandSet& bands, std::size_t layer)
      : photos_(photos), bands_(bands), layer_(layer) {}

  std::shared_ptr<const Image> photo(ViewId view) override {
    const std::shared_ptr<const Samples> samples = photos_.samples(view);
    const Layer layer = layer_of({}, samples.get(), layer_);
    Image picture{layer.width, layer.height, 3, {}};
    picture.pixels.resize(3 * pixel_index(0, layer.height, layer.width));
    const auto black = static_cast<float>(bands_.black), level = static_cast<float>(1 / bands_.units_per_level());
    for (std::size_t i = 0; 3 * i < picture.pixels.size(); ++i)
      store(&picture.pixels[3 * i], level * (layer.at(i) - Color{black, black, black}));
    return std::make_shared<const Image>(std::move(picture));
  }
  std::shared_ptr<const io::PhotoExclusion> exclusion(ViewId view) override { return photos_.exclusion(view); }

 private:
  io::PhotoSource& photos_;
  const BandSet& bands_;
  std::size_t layer_;
};

}  // namespace

std::vector<std::vector<ViewExposure>> fit_band_gains(const AtlasInput& input) {
  // Exposures that EXIF data tell are those of colours.
  Scene scene = input.scene;
  for (View& view : scene.views) view.exposure_value.reset();
  std::vector<std::vector<ViewExposure>> gains;
  for (std::size_t layer = 1; layer < layers_of(&*input.scene.bands); ++layer) {
    BandPictures pictures(input.photos, *input.scene.bands, layer);
    gains.push_back(fit_exposure(AtlasInput{input.mesh, scene, pictures, input.graph, input.labels, input.tags,
                                            input.candidates, input.coverage, input.border}));
  }
  return gains;
}

}  // namespace gpvc::atlas
