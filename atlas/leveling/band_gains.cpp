#include "atlas/leveling/band_gains.h"

#include <algorithm>
#include <memory>

#include "atlas/sampling/layers.h"
#include "io/images.h"

namespace gpvc::atlas {
namespace {

/// Photos as pictures of three of their bands.
class BandPictures final : public io::PhotoSource {
 public:
  BandPictures(io::PhotoSource& photos, const BandSet& bands, std::size_t layer) : photos_(photos), bands_(bands) {
    for (std::size_t c = 0; c < 3; ++c) bands_.composite[c] = std::min(first_band(layer) + c, bands.bands.size() - 1);
  }

  std::shared_ptr<const Image> photo(ViewId view) override {
    return std::make_shared<const Image>(io::picture_of(*photos_.samples(view), bands_));
  }
  std::shared_ptr<const io::PhotoExclusion> exclusion(ViewId view) override { return photos_.exclusion(view); }

 private:
  io::PhotoSource& photos_;
  BandSet bands_;
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
