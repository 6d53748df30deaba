// Further photos from the same cameras, baked onto the pages of a model: another date, a band, a picture of classes.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "../../atlas/atlas.h"
#include "../../io/photos.h"
#include "memory.h"
#include "run.h"

namespace gpvc::pipeline {

/// Borrows its photos.
struct LayerPhotos {
  std::string name;    ///< of its folder
  const Scene& scene;  ///< the run's, with other photos of the same sizes
  io::PhotoSource& photos;
  bool leveled = false;  ///< as the run's settings say, with blending; else the values stay those of the photos
};

/// check_band_format() of the run and of its layers.
void check_band_formats(const Run& run, std::span<const LayerPhotos> layers);

/// Throws InputError, which names the layer, where a used view of `layer` is not one of the run's: in its name or its size.
void check_layer(const Input& input, const std::string& name, const Scene& layer);

/// Bakes each layer onto the places of `from` by its labels, one after the other, and writes its pages to layers/NAME/ under the names of
/// the model's pages, with a .tif beside each where its photos have bands. \param from of the model, with its `alignment` or its
/// `layout`. Throws what baking throws. Each takes what baking the model takes.
void bake_layers(const Run& run, std::span<const LayerPhotos> layers, const atlas::AtlasInput& from,
                 OutputFolder& folder);

/// The places of a model that is textured already.
io::UvLayout layout_of(const io::TexturedModel& model, std::span<const std::array<int, 2>> page_sizes);

}  // namespace gpvc::pipeline
