// Which photos show each face of a mesh, for all faces at once.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "app/pipeline/judgement.h"
#include "app/pipeline/run.h"
#include "visibility/device.h"

namespace gpvc::query {

/// In compressed rows: the views that see a face in full or in part are entries first[face] to first[face + 1] - 1, ascending.
struct PhotoIndex {
  std::vector<std::uint64_t> first;   ///< faces + 1
  std::vector<std::uint32_t> views;   ///< numbers of views, as in views.json
  std::vector<std::uint8_t> classes;  ///< 1 partial, 2 full
  std::vector<float> shares;          ///< of the face's samples that see it
  std::vector<float> gsd, angle;      ///< Sharpness at the face's centroid
  std::vector<std::uint8_t>
      fates{};                 ///< labeling::ViewFate; empty without a judgement. kNoFate: the photo shows background
  std::vector<float> costs{};  ///< of candidates, else NaN; empty without a judgement
};
/// The photo was left out, or shows background in the place of the face, so that it has no say.
inline constexpr std::uint8_t kNoFate = 255;

/// Draws view after view. Holds some 20 bytes for each face and view that sees it, twice for a while. Throws GpuError, and what
/// photos and observer throw. O(views x (faces + pixels)).
PhotoIndex index_faces(const pipeline::Run& run, const pipeline::Judgement* judgement,
                       std::optional<visibility::DeviceInfo>* device = nullptr);

/// Writes it as compressed NumPy arrays (.npz): first, views, classes, shares, gsd, angle, with a judgement fates and costs, and
/// names, the bytes of all views' names with line ends between. Throws OutputError.
void write_index(const std::filesystem::path& file, const PhotoIndex& index, const Scene& scene);

}  // namespace gpvc::query
