#include "visibility/raster/tile_lists.h"

#include <tbb/parallel_for.h>

namespace gpvc::visibility {

void TileLists::start(std::size_t parts, std::size_t tiles) {
  parts_.resize(parts);
  tbb::parallel_for(std::size_t{0}, parts, [&](std::size_t number) {
    parts_[number].found_.clear();
    parts_[number].count_.assign(tiles, 0);
  });
  first_.assign(tiles + 1, 0);
}

void TileLists::sort() {
  // Counts become offsets: where a part's entries of a tile begin, relative to the tile's first.
  std::size_t begin = 0;
  for (std::size_t tile = 0; tile + 1 < first_.size(); ++tile) {
    first_[tile] = begin;
    std::uint32_t within = 0;
    for (Part& part : parts_) {
      const std::uint32_t count = part.count_[tile];
      part.count_[tile] = within;
      within += count;
    }
    begin += within;
  }
  first_.back() = begin;
  faces_.resize(begin);
  tbb::parallel_for(std::size_t{0}, parts_.size(), [&](std::size_t number) {
    Part& part = parts_[number];
    for (const Part::Entry& entry : part.found_) faces_[first_[entry.tile] + part.count_[entry.tile]++] = entry.face;
  });
}

}  // namespace gpvc::visibility
