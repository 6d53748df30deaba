// Texture pages in a file that is mapped into memory, so that their number is no limit.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "app/pipeline/page_sink.h"
#include "io/bilinear.h"
#include "io/scratch_file.h"

namespace gpvc::ortho {

struct StoredPage {
  int width = 0, height = 0;
  const std::uint8_t* rgb = nullptr;
  const std::byte* samples = nullptr;  ///< null: none

  /// The colour at a position in texels, whose centres are at halves.
  std::array<float, 3> at(double x, double y) const {
    return bilinear_of<float>(width, height, x, y,
                              [&](int column, int row) { return rgb + 3 * pixel_index(column, row, width); });
  }
};

/// All pages are taken before any is looked at. They lie as they are in a file without a name: 3 bytes a texel, and those of its
/// samples. Functions throw OutputError.
class PageStore final : public pipeline::PageSink {
 public:
  explicit PageStore(const std::filesystem::path& folder) : file_(folder) {}
  void begin(const atlas::AtlasEstimate&) override {}
  void take_page(std::size_t number, Image page) override;
  void take_samples(std::size_t number, atlas::PageSamples page, const BandSet& bands) override;
  /// To be called once all are taken.
  void complete();
  std::size_t size() const { return pages_.size(); }
  /// Of the samples that all pages have; nullopt: they have none.
  const std::optional<BandSet>& bands() const { return bands_; }
  /// Adds to `sums`, one for each band, what a page holds at a position in texels, whose centres are at halves, interpolated
  /// linearly. \pre bands()
  void add_samples(const StoredPage& page, double x, double y, std::span<float> sums) const;
  /// rgb is null before complete().
  const StoredPage& operator[](std::size_t number) const { return pages_[number]; }

 private:
  io::ScratchFile file_;
  std::mutex mutex_;
  struct Place {
    static constexpr std::size_t kNone = static_cast<std::size_t>(-1);
    std::size_t rgb = kNone, samples = kNone;  ///< in the file
  };
  /// Room in the file for a part of a page.
  std::size_t take_room(std::size_t number, int width, int height, std::size_t Place::*part, std::size_t bytes);

  std::vector<StoredPage> pages_;
  std::vector<Place> place_;  ///< per page
  std::optional<BandSet> bands_;
  std::size_t end_ = 0;
};

}  // namespace gpvc::ortho
