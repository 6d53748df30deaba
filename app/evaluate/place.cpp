#include "app/evaluate/place.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "io/error.h"
#include "io/mesh.h"
#include "io/npy.h"
#include "io/textured_model.h"
#include "io/vector.h"
#include "labeling/labeling.h"

namespace gpvc::evaluate {
namespace {

namespace fs = std::filesystem;

double distance_from_segment(const WorldPoint& p, const WorldPoint& a, const WorldPoint& b) {
  const WorldPoint along = b - a;
  const double squared = dot(along, along);
  const double t = squared > 0 ? std::clamp(dot(p - a, along) / squared, 0.0, 1.0) : 0;
  return length(p - (a + t * along));
}

double distance_from_face(const WorldPoint& p, const WorldPoint& a, const WorldPoint& b, const WorldPoint& c) {
  const WorldPoint normal = cross(b - a, c - a);
  const auto is_left_of = [&](const WorldPoint& from, const WorldPoint& to) {
    return dot(cross(to - from, p - from), normal) >= 0;
  };
  if (dot(normal, normal) > 0 && is_left_of(a, b) && is_left_of(b, c) && is_left_of(c, a))
    return std::abs(dot(p - a, normal)) / length(normal);
  return std::min({distance_from_segment(p, a, b), distance_from_segment(p, b, c), distance_from_segment(p, c, a)});
}

using Nearest = std::pair<double, std::size_t>;  // distance and face

Nearest nearest_face(const Mesh& mesh, const WorldPoint& p) {
  const Nearest none{std::numeric_limits<double>::infinity(), mesh.faces.size()};
  return tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, mesh.faces.size()), none,
      [&](const auto& range, Nearest best) {
        for (std::size_t f = range.begin(); f < range.end(); ++f) {
          const auto [a, b, c] = mesh.faces[f];
          best = std::min(best, {distance_from_face(p, mesh.positions[a], mesh.positions[b], mesh.positions[c]), f});
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
