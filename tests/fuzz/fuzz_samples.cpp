#include <fstream>
#include <iterator>

#include "fuzz.h"
#include "io/bands/band_photo.h"
#include "io/images/codec.h"

namespace gpvc::fuzz {
namespace {

/// TIFFs of each type of sample, with the tags of bands.
std::vector<std::string> tiff_seeds(const std::filesystem::path&) {
  std::vector<std::string> seeds;
  for (const SampleType type : {SampleType::u8, SampleType::u16, SampleType::f32}) {
    Samples samples{20, 12, 4, type, {}};
    for (std::size_t i = 0; i < 20 * 12 * samples.pixel_bytes(); ++i)
      samples.bytes.push_back(static_cast<std::byte>(7 * i % 251));
    BandSet set;
    set.type = type;
    set.bands = {{"Red", 668, ""}, {"NIR", 842, "reflectance"}, {"B3"}, {"LWIR", {}, "K"}};
    io::write_samples(folder() / "seed.tif", samples, set);
    std::ifstream in(folder() / "seed.tif", std::ios::binary);
    seeds.emplace_back(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
  }
  return seeds;
}

}  // namespace

// What libtiff is not asked for is OpenImageIO's.
GPVC_FUZZ_TARGET(samples, tiff_seeds) {
  const std::filesystem::path file = write("photo.tif", view(data, size));
  io::OtherHeader header;
  if (!io::read_tiff_header({file, "", view(data, size)}, header)) return 0;
  return reads_or_refuses([&] { io::read_stored(file); });
}

}  // namespace gpvc::fuzz
