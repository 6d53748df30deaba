// Where the pages of an atlas go.
#pragma once

#include <cstddef>
#include <future>

#include "../../atlas/atlas.h"

namespace gpvc::pipeline {

/// Where the pages of an atlas and its model go. Functions are called in their order.
class PageSink {
 public:
  virtual ~PageSink() = default;
  /// The size of what will come, before any photo is read.
  virtual void begin(const atlas::AtlasEstimate& size) = 0;
  /// Begins work that needs the model but no pages; the model stays where it is until that is done.
  virtual std::future<void> take_model(const io::TexturedModel& /*model*/) { return {}; }
  /// Takes each page as soon as it is finished; called by several threads at a time.
  virtual void take_page(std::size_t number, Image page) = 0;
  /// Likewise the samples of the page, before it, where photos have bands. \param bands as of the photos
  virtual void take_samples(std::size_t number, atlas::PageSamples page, const BandSet& bands) = 0;
};

}  // namespace gpvc::pipeline
