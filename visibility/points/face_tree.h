// The faces of a mesh in a balanced tree of bounding boxes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "io/box.h"

namespace gpvc::visibility {

class FaceTree {
 public:
  /// Borrows the mesh. O(faces log faces), TBB.
  explicit FaceTree(const Mesh& mesh);

  /// Calls visit(FaceId) for the faces of all leaves whose boxes, and those around them, `rejects(box)` does not reject.
  template <class Rejects, class Visit>
  void visit(const Rejects& rejects, const Visit& visit) const {
    if (!order_.empty()) descend({0, 0}, rejects, visit);
  }

  struct Nearest {
    FaceId face{};
    WorldPoint at;
    double squared = 0;  ///< distance
  };
  /// Of several at the same distance the face of the lowest index. nullopt: there is no face.
  std::optional<Nearest> nearest(const WorldPoint& place) const;

 private:
  // The node `number` of a level holds the faces from count * number / 2^level on, in the tree's order.
  struct Node {
    unsigned level;
    std::size_t number;
    Node child(std::size_t which) const { return {level + 1, 2 * number + which}; }
  };
  std::size_t first_of(const Node& node) const { return order_.size() * node.number >> node.level; }
  std::size_t end_of(const Node& node) const { return first_of({node.level, node.number + 1}); }
  const Box& box_of(const Node& node) const { return boxes_[(std::size_t{1} << node.level) - 1 + node.number]; }

  void build(const Node& node, const std::vector<WorldPoint>& middles);
  void search(const Node& node, const WorldPoint& place, std::optional<Nearest>& best) const;

  template <class Rejects, class Visit>
  void descend(const Node& node, const Rejects& rejects, const Visit& visit) const {
    if (rejects(box_of(node))) return;
    if (node.level == depth_) {
      for (std::size_t i = first_of(node); i < end_of(node); ++i) visit(FaceId{order_[i]});
      return;
    }
    descend(node.child(0), rejects, visit);
    descend(node.child(1), rejects, visit);
  }

  const Mesh& mesh_;
  unsigned depth_ = 0;
  std::vector<std::uint32_t> order_;
  std::vector<Box> boxes_;
};

}  // namespace gpvc::visibility
