// The item buffer as it was drawn: the renderer's texture, or square tiles of it where one texture is too small.
layout(binding = 0) uniform usampler2D ivm;
layout(binding = 4) uniform usampler2DArray ivm_tiles;
uniform ivec2 size;      // of the image, pixels
uniform int tile_side;   // 0: all of it is in `ivm`

uint stored_at(ivec2 pixel) {
  if (tile_side == 0) return texelFetch(ivm, pixel, 0).r;
  ivec2 tile = pixel / tile_side;
  int across = (size.x + tile_side - 1) / tile_side;
  return texelFetch(ivm_tiles, ivec3(pixel - tile * tile_side, tile.y * across + tile.x), 0).r;
}
