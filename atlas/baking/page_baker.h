// Bakes all pages within a memory limit.
#pragma once

#include <cstddef>

#include "atlas/baking/baking.h"

namespace gpvc::atlas {

struct BakedPages {
  std::vector<Image> pages;          ///< empty where options.take_page took them
  std::vector<PageSamples> samples;  ///< likewise
  std::size_t page_texels = 0, chart_texels = 0, padded_texels = 0, kept_pages = 0;  ///< as in AtlasStatistics
  InventedColor invented_color;                                                      ///< likewise
};

/// Opens, bakes and finishes the build's pages in groups that fit options.page_bytes; photos are fetched once for each
/// group, or more often where partial charts are baked in batches. Pages that options.kept has need none. While their
/// charts wait for colours from pages that are baked later, pages are in options.kept, or in a file of
/// options.scratch_folder. Throws what the photo source throws, and OutputError. Progress as for bake_atlas().
BakedPages bake_pages(AtlasBuild& build, const BakeOptions& options, const Progress& progress);

}  // namespace gpvc::atlas
