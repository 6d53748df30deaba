#include "app/evaluate/place.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <limits>
#include <string>
#include <utility>

#include "io/closest_point.h"
#include "io/error.h"
#include "io/mesh.h"
#include "io/npy.h"
#include "io/textured_model.h"
#include "io/vector.h"
#include "labeling/labeling.h"

namespace gpvc::evaluate {
namespace {

namespace fs = std::filesystem;

using Nearest = std::pair<double, std::size_t>;  // distance and face

Nearest nearest_face(const Mesh& mesh, const WorldPoint& p) {
  const Nearest none{std::numeric_limits<double>::infinity(), mesh.faces.size()};
  return tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, mesh.faces.size()), none,
      [&](const auto& range, Nearest best) {
        for (std::size_t f = range.begin(); f < range.end(); ++f) {
          const auto [a, b, c] = mesh.faces[f];
          const WorldPoint at = closest_on_face(p, mesh.positions[a], mesh.positions[b], mesh.positions[c]);
          best = std::min(best, {length(p - at), f});
        }
        return best;
      },
      [](const Nearest& a, const Nearest& b) { return std::min(a, b); });
}

}  // namespace

ShownPlace shown_at(const fs::path& out, const WorldPoint& place) {
  const fs::path model_file = out / "model.obj";
  if (!fs::exists(model_file)) throw InputError(out, "", "holds no textured model (model.obj)");
  const Mesh mesh = io::read_mesh(model_file);
  const auto labels = io::read_npy<std::int32_t>(out / "labels.npy").values;
  const auto tags = io::read_npy<std::uint8_t>(out / "tags.npy").values;
  const std::size_t faces = mesh.faces.size();
  for (const auto& [name, size] : {std::pair{"labels.npy", labels.size()}, {"tags.npy", tags.size()}})
    if (size != faces)
      throw InputError(out / name, "",
                       "has " + std::to_string(size) + " faces, and model.obj " + std::to_string(faces));
  const auto [distance, face] = nearest_face(mesh, place - io::read_offset(model_file));
  ShownPlace shown{face, distance, kNoView, false};
  if (labels[face] < 0) return shown;
  shown.view = ViewId{static_cast<std::uint32_t>(labels[face])};
  shown.whole = tags[face] == static_cast<std::uint8_t>(labeling::FaceTag::seen);
  return shown;
}

}  // namespace gpvc::evaluate
