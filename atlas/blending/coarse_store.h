// Coarse photos on disk.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <vector>

#include "atlas/blending/coarse_photo.h"
#include "io/scratch_file.h"

namespace gpvc::atlas {

/// For later passes over the photos that need no more than this of some: to read it takes a tenth of the time that decoding
/// takes. keep() by one thread at a time, while others may read other views.
class CoarseStore {
 public:
  /// \param views of the scene
  /// \param folder where a file without a name may grow to `most` bytes
  CoarseStore(std::size_t views, const std::filesystem::path& folder, std::size_t most);
  bool has(ViewId view) const { return places_[index(view)].width > 0; }
  /// \pre has(view). Throws OutputError.
  CoarsePhoto read(ViewId view) const;
  /// Does nothing where the view is kept already, or where there is no room.
  void keep(ViewId view, const CoarsePhoto& coarse);

 private:
  /// Where the pixels are in the file, and how many; none of views that are not kept.
  struct Place {
    std::size_t begin = 0;
    int width = 0, height = 0;
  };

  std::size_t most_, end_ = 0;
  std::vector<Place> places_;  ///< per view
  std::optional<io::ScratchFile> file_;
};

}  // namespace gpvc::atlas
