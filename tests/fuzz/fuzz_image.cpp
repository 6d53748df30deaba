#include "fuzz.h"
#include "io/images/image_file.h"

namespace gpvc::fuzz {

GPVC_FUZZ_TARGET(image) {
  return reads_or_refuses([&] { io::decode_image(folder() / "page", "image 0", view(data, size)); });
}

}  // namespace gpvc::fuzz
