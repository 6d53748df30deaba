// Bakes an atlas within a run's memory and hands its pages on: what textured models, changed ones, tilesets and jobs share.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "app/pipeline/memory.h"
#include "app/pipeline/page_sink.h"
#include "app/pipeline/run.h"
#include "atlas/atlas.h"

namespace gpvc::pipeline {

/// What baking may use beside the memory.
struct PaintSpace {
  std::string stage = "bake";  ///< as the observer sees it
  std::filesystem::path scratch_folder = {};
  std::size_t coarse_bytes = 0;  ///< see atlas::BakeOptions
  atlas::KeptPages kept = {};
};

/// One stage. Without a sink the atlas holds its pages.
atlas::TextureAtlas paint(const Run& run, const atlas::AtlasInput& from, const MemoryPlan& memory,
                          const PaintSpace& space, PageSink* sink);

}  // namespace gpvc::pipeline
