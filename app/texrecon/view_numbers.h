// The numbers of views in texrecon's files, from 1: those of the cameras of an NVM file, of .cam files in the order of their names,
// of the views of an MVE scene by their identifiers. 0 is no view.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "io/scene.h"

namespace gpvc::texrecon {

class ViewNumbers {
 public:
  explicit ViewNumbers(const Scene& scene);
  std::size_t count() const { return views_.size(); }
  /// \pre 1 <= number <= count()
  ViewId view(std::size_t number) const { return views_[number - 1]; }
  /// 0 for kNoView.
  std::uint64_t number(ViewId view) const { return view == kNoView ? 0 : numbers_[index(view)]; }

 private:
  std::vector<ViewId> views_;
  std::vector<std::uint64_t> numbers_;
};

/// A labelling file: for each face the number of its view as 64 bits, lowest byte first. Throws InputError where there are not as
/// many, or one is no number of a view.
std::vector<ViewId> read_labels(const std::filesystem::path& file, std::size_t faces, const ViewNumbers& numbers);
/// Throws OutputError.
void write_labels(const std::filesystem::path& file, std::span<const ViewId> labels, const ViewNumbers& numbers);

}  // namespace gpvc::texrecon
