// One bit a pixel, 32 pixels a texel: the pixel's centre, distorted, lies in the photo.
const uint kNoFace = 0xFFFFFFFFu;

uniform bool photo_is_whole;

#define in_photo(pixel) \
  (photo_is_whole ||    \
   ((texelFetch(photo_mask, ivec2((pixel).x / 32, (pixel).y), 0).r >> uint((pixel).x % 32)) & 1u) != 0u)
