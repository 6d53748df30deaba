// The photo mask: one bit a pixel, 32 pixels a texel, each row padded to whole texels. Set when the pixel's centre,
// distorted, lies in the photo on a pixel that is not excluded.
const uint kNoFace = 0xFFFFFFFFu;

layout(binding = 1) uniform usamplerBuffer photo_mask;
uniform int photo_stride;  // texels a row; 0: every pixel is in the photo

#define in_photo(pixel)  \
  (photo_stride == 0 ||  \
   ((texelFetch(photo_mask, (pixel).y * photo_stride + (pixel).x / 32).r >> uint((pixel).x % 32)) & 1u) != 0u)
