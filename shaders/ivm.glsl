// The item buffer as drawn: the renderer's texture, or tiles of it when the image exceeds the largest texture.
layout(binding = 0) uniform usampler2D ivm;
layout(binding = 4) uniform usampler2DArray ivm_tiles;  // row by row
uniform ivec2 size;       // of the image, pixels
uniform ivec2 tile_size;  // 0: `ivm` holds the whole image

uint stored_at(ivec2 pixel) {
  if (tile_size.x == 0) return texelFetch(ivm, pixel, 0).r;
  ivec2 tile = pixel / tile_size;
  int across = (size.x + tile_size.x - 1) / tile_size.x;
  return texelFetch(ivm_tiles, ivec3(pixel - tile * tile_size, tile.y * across + tile.x), 0).r;
}
