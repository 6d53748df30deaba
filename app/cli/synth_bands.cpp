#include "app/cli/synth_bands.h"

#include <nlohmann/json.hpp>

#include "io/images.h"

namespace gpvc::cli {

using evaluate::Json;

namespace {

// A band of all.
Samples one_band(const Samples& all, std::size_t band) {
  Samples one{all.width, all.height, 1, all.type, {}};
  const std::size_t size = bytes_of(all.type);
  for (std::size_t at = band * size; at < all.bytes.size(); at += all.pixel_bytes())
    one.bytes.insert(one.bytes.end(), all.bytes.data() + at, all.bytes.data() + at + size);
  return one;
}

std::string band_file_name(const std::string& view, std::size_t band) {
  return view.substr(0, view.rfind('_')) + "_" + std::to_string(band + 1) + ".tif";
}

}  // namespace

void name_band_photos(std::vector<View>& views, const synth::BandOptions& bands) {
  for (View& view : views) {
    const std::size_t dot = view.name.rfind('.'), bar = view.name.rfind('_');
    const std::string number = view.name.substr(bar + 1, dot - bar - 1);
    view.name =
        bands.apart ? view.name.substr(0, bar + 1) + "0" + number + "_1.tif" : view.name.substr(0, dot) + ".tif";
  }
}

void write_bands(const Samples& samples, const std::string& subfolder, const std::string& view,
                 const synth::BandOptions& options, results::OutputFolder& folder) {
  const BandSet set = synth::bands_of(options);
  if (!options.apart) return io::write_samples(folder.file(subfolder + view), samples, set);
  for (std::size_t band = 0; band < set.bands.size(); ++band) {
    BandSet alone = set;
    alone.bands = {set.bands[band]};
    alone.composite = {};
    io::write_samples(folder.file(subfolder + band_file_name(view, band)), one_band(samples, band), alone);
  }
}

Json synth_bands_json(const synth::BandOptions& options) {
  Json bands = Json::array();
  if (!options.any()) return bands;
  const BandSet set = synth::bands_of(options);
  for (std::size_t band = 0; band < set.bands.size(); ++band) {
    const synth::BandShift shift = synth::shift_of(options, band);
    bands.push_back(
        {{"name", set.bands[band].name},
         {"wavelength_nm", set.bands[band].wavelength_nm ? Json(*set.bands[band].wavelength_nm) : Json(nullptr)},
         {"white", synth::sample_of_white(options)},
         {"right_px", shift.right},
         {"down_px", shift.down}});
  }
  return bands;
}

}  // namespace gpvc::cli
