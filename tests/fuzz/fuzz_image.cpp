#include <fstream>
#include <iterator>

#include "fuzz.h"
#include "io/images/image_file.h"

namespace gpvc::fuzz {
namespace {

std::vector<std::string> webp_seeds(const std::filesystem::path&) {
  Image image{20, 12, 3, {}};
  for (int i = 0; i < 3 * 20 * 12; ++i) image.pixels.push_back(static_cast<std::uint8_t>(7 * i));
  io::write_image(folder() / "seed.webp", image, io::ImageFormat::webp, 50);
  std::ifstream in(folder() / "seed.webp", std::ios::binary);
  return {std::string(std::istreambuf_iterator<char>(in), {})};
}

}  // namespace

GPVC_FUZZ_TARGET(image, webp_seeds) {
  return reads_or_refuses([&] { io::decode_image(folder() / "page", "image 0", view(data, size)); });
}

}  // namespace gpvc::fuzz
