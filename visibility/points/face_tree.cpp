#include "visibility/points/face_tree.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

#include "io/closest_point.h"

namespace gpvc::visibility {
namespace {

constexpr std::size_t kLeafFaces = 8;
constexpr std::size_t kFacesOfTask = 16384;

double squared_distance(const Box& box, const WorldPoint& p) {
  const auto beyond = [](double low, double high, double at) { return std::max({low - at, at - high, 0.0}); };
  const WorldPoint off{beyond(box.low.x, box.high.x, p.x), beyond(box.low.y, box.high.y, p.y),
                       beyond(box.low.z, box.high.z, p.z)};
  return dot(off, off);
}

double WorldPoint::*longest_axis(const Box& box) {
  const WorldPoint size = box.high - box.low;
  if (size.x >= size.y && size.x >= size.z) return &WorldPoint::x;
  return size.y >= size.z ? &WorldPoint::y : &WorldPoint::z;
}

}  // namespace

FaceTree::FaceTree(const Mesh& mesh) : mesh_(mesh), order_(mesh.faces.size()) {
  while (order_.size() >> depth_ > kLeafFaces) ++depth_;
  boxes_.resize((std::size_t{2} << depth_) - 1);
  std::iota(order_.begin(), order_.end(), 0U);
  std::vector<WorldPoint> middles(order_.size());
  tbb::parallel_for(std::size_t{0}, middles.size(), [&](std::size_t f) {
    const auto [a, b, c] = mesh.faces[f];
    middles[f] = (mesh.positions[a] + mesh.positions[b] + mesh.positions[c]) * (1.0 / 3);
  });
  if (!order_.empty()) build({0, 0}, middles);
}

void FaceTree::build(const Node& node, const std::vector<WorldPoint>& middles) {
  Box& box = boxes_[(std::size_t{1} << node.level) - 1 + node.number];
  const auto first = order_.begin() + static_cast<std::ptrdiff_t>(first_of(node)),
             end = order_.begin() + static_cast<std::ptrdiff_t>(end_of(node));
  if (node.level == depth_) {
    for (auto face = first; face != end; ++face)
      for (const std::uint32_t v : mesh_.faces[*face]) box.add(mesh_.positions[v]);
    return;
  }
  Box around;
  for (auto face = first; face != end; ++face) around.add(middles[*face]);
  const auto axis = longest_axis(around);
  const auto middle = order_.begin() + static_cast<std::ptrdiff_t>(first_of(node.child(1)));
  std::nth_element(first, middle, end, [&](std::uint32_t a, std::uint32_t b) {
    return std::pair(middles[a].*axis, a) < std::pair(middles[b].*axis, b);
  });
  const auto left = [&] { build(node.child(0), middles); };
  const auto right = [&] { build(node.child(1), middles); };
  if (static_cast<std::size_t>(end - first) > kFacesOfTask) {
    tbb::parallel_invoke(left, right);
  } else {
    left();
    right();
  }
  for (std::size_t which = 0; which < 2; ++which) {
    const Box& child = box_of(node.child(which));
    box.add(child.low);
    box.add(child.high);
  }
}

std::optional<FaceTree::Nearest> FaceTree::nearest(const WorldPoint& place) const {
  std::optional<Nearest> best;
  if (!order_.empty()) search({0, 0}, place, best);
  return best;
}

void FaceTree::search(const Node& node, const WorldPoint& place, std::optional<Nearest>& best) const {
  if (best && squared_distance(box_of(node), place) > best->squared) return;
  if (node.level == depth_) {
    for (std::size_t i = first_of(node); i < end_of(node); ++i) {
      const FaceId face{order_[i]};
      const auto [a, b, c] = mesh_.faces[order_[i]];
      const WorldPoint at = closest_on_face(place, mesh_.positions[a], mesh_.positions[b], mesh_.positions[c]);
      const double squared = dot(at - place, at - place);
      if (!best || std::pair(squared, face) < std::pair(best->squared, best->face)) best = Nearest{face, at, squared};
    }
    return;
  }
  const std::array<Node, 2> children{node.child(0), node.child(1)};
  const bool second_first = squared_distance(box_of(children[1]), place) < squared_distance(box_of(children[0]), place);
  search(children[second_first ? 1 : 0], place, best);
  search(children[second_first ? 0 : 1], place, best);
}

}  // namespace gpvc::visibility
