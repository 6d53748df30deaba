// Panoramas continued beyond their sides, as their views take them.
#include <algorithm>
#include <cmath>

#include "io/images.h"
#include "io/images/image_file.h"
#include "io/images/mask_file.h"
#include "io/lens/spherical.h"
#include "io/photo_pixel.h"

namespace gpvc::io {

Image continue_around(const Image& panorama) { return continue_around(panorama, new_room); }

Image continue_around(const Image& panorama, const PixelRoom& room) {
  const int before = columns_before(panorama.width), behind = columns_behind(panorama.width);
  Image out = image_in(room, before + panorama.width + behind, panorama.height, panorama.channels);
  std::uint8_t* to = out.pixels.data();
  for (int y = 0; y < panorama.height; ++y)
    for (const auto& [first, count] :
         {std::pair(panorama.width - before, before), std::pair(0, panorama.width), std::pair(0, behind)}) {
      const std::uint8_t* from = panorama.at(0, y) + std::ptrdiff_t{first} * panorama.channels;
      to = std::copy_n(from, std::ptrdiff_t{count} * panorama.channels, to);
    }
  return out;
}

PhotoExclusion continue_around(const PhotoExclusion& panorama) {
  const int width = panorama.width, before = columns_before(width);
  PhotoExclusion out = empty_exclusion(before + width + columns_behind(width), panorama.height);
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x)
      if (panorama.excludes((x - before + width) % width, y))
        exclude(out, static_cast<std::size_t>(x), static_cast<std::size_t>(y));
  return out;
}

PhotoPoint taken_pixel(const View& view, const PhotoPoint& p) {
  double x = p.x;
  if (is_spherical(view.camera.distortion.model)) {
    const int width = file_width(view.camera);
    x = std::fmod(p.x - columns_before(width) + width, width);
  }
  return {x * view.reduction, p.y * view.reduction};
}

}  // namespace gpvc::io
