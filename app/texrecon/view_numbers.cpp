#include "app/texrecon/view_numbers.h"

#include <fmt/format.h>

#include <algorithm>

#include "io/file_bytes.h"
#include "io/output_file.h"

namespace gpvc::texrecon {

ViewNumbers::ViewNumbers(const Scene& scene) : views_(all_views(scene)), numbers_(views_.size()) {
  std::ranges::stable_sort(views_, {}, [&](ViewId id) { return scene.views[index(id)].number; });
  for (std::size_t i = 0; i < views_.size(); ++i) numbers_[index(views_[i])] = i + 1;
}

std::vector<ViewId> read_labels(const std::filesystem::path& file, std::size_t faces, const ViewNumbers& numbers) {
  const io::FileBytes bytes(file);
  const std::string_view text = bytes.view();
  if (text.size() != 8 * faces)
    throw InputError(file, "",
                     fmt::format("is {} bytes long: expected 8 for each of the mesh's {} faces", text.size(), faces));
  std::vector<ViewId> labels(faces, kNoView);
  for (std::size_t face = 0; face < faces; ++face) {
    std::uint64_t number = 0;
    for (std::size_t k = 8; k-- > 0;) number = number << 8 | static_cast<std::uint8_t>(text[8 * face + k]);
    if (number > numbers.count())
      throw InputError(file, fmt::format("face {}", face),
                       fmt::format("has view {}, the scene has {}", number, numbers.count()));
    if (number > 0) labels[face] = numbers.view(number);
  }
  return labels;
}

void write_labels(const std::filesystem::path& file, std::span<const ViewId> labels, const ViewNumbers& numbers) {
  std::string bytes;
  bytes.reserve(8 * labels.size());
  for (const ViewId label : labels) {
    std::uint64_t number = numbers.number(label);
    for (int k = 0; k < 8; ++k, number >>= 8) bytes += static_cast<char>(number & 0xFF);
  }
  io::write_file(file, bytes);
}

}  // namespace gpvc::texrecon
