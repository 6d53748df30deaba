// Offsets of colour per vertex that close the steps at seams.
#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <span>
#include <vector>

#include "atlas/leveling/finished_texture.h"
#include "atlas/leveling/offset_system.h"
#include "atlas/leveling/seam_leveling.h"
#include "io/grouping.h"
#include "io/vector.h"

namespace gpvc::atlas {

namespace {

/// Weights of the energy's squared differences: 1 between the two sides of a seam, kSmooth between the ends of an edge
/// within a chart, kAnchor for the offset itself. An offset fades over sqrt(kSmooth / kAnchor) = 32 edges from its
/// seam. A few per cent of a constant step remain, and are left to the strips.
constexpr double kSmooth = 1.0, kAnchor = 1e-3;
/// Differences beyond this, in grey levels, come from different content rather than brightness, and get less weight.
constexpr double kOutlyingStep = 40;
/// Sum of sample weights at one end of an edge that gives its difference full weight.
constexpr double kSufficientWeight = 2;
constexpr float kMostOffset = 80;
/// Offsets more edges than this away from any seam are zero.
constexpr int kReachEdges = 48;

/// True for faces whose colours have offsets.
bool has_offsets(const AtlasInput& input, std::size_t face) {
  return has_view(input, face) && !is_finished(input, face);
}

/// Vertices of faces of several views, with these views; the other vertices have at most one.
class VertexViews {
 public:
  explicit VertexViews(const AtlasInput& input) : view_(input.mesh.positions.size(), kNone) {
    const auto for_corners = [&](std::size_t face, const auto& body) {
      if (!has_offsets(input, face)) return;
      for (const std::uint32_t vertex : input.mesh.faces[face])
        body(vertex, static_cast<std::uint32_t>(index(input.labels[face])));
    };
    tbb::parallel_for(std::size_t{0}, input.mesh.faces.size(), [&](std::size_t face) {
      for_corners(face, [&](std::uint32_t vertex, std::uint32_t view) {
        const std::atomic_ref known(view_[vertex]);
        std::uint32_t before = known.load(std::memory_order_relaxed);
        if (before == kNone && known.compare_exchange_strong(before, view, std::memory_order_relaxed)) return;
        if (before != view && before != kSeveral) known.store(kSeveral, std::memory_order_relaxed);
      });
    });
    using Pair = std::array<std::uint32_t, 2>;  // vertex, view
    tbb::enumerable_thread_specific<std::vector<Pair>> found;
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, input.mesh.faces.size()), [&](const auto& range) {
      std::vector<Pair>& mine = found.local();
      for (std::size_t face = range.begin(); face < range.end(); ++face)
        for_corners(face, [&](std::uint32_t vertex, std::uint32_t view) {
          if (view_[vertex] == kSeveral) mine.push_back({vertex, view});
        });
    });
    std::vector<Pair> pairs;
    for (const std::vector<Pair>& part : found) pairs.insert(pairs.end(), part.begin(), part.end());
    tbb::parallel_sort(pairs);
    pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const auto [vertex, view] = pairs[i];
      if (i == 0 || pairs[i - 1][0] != vertex) {
        view_[vertex] = kSeveral + static_cast<std::uint32_t>(first_.size());
        first_.push_back(views_.size());
      }
      views_.push_back(view);
    }
    first_.push_back(views_.size());
  }

  std::size_t count(std::uint32_t vertex) const {
    const std::uint32_t view = view_[vertex];
    return view == kNone ? 0 : view < kSeveral ? 1 : first_[view - kSeveral + 1] - first_[view - kSeveral];
  }
  /// The view's place among those of the vertex, which are in ascending order.
  std::uint32_t rank(std::uint32_t vertex, std::uint32_t view) const {
    if (view_[vertex] < kSeveral) return 0;
    const std::size_t several = view_[vertex] - kSeveral;
    const std::span<const std::uint32_t> views(views_.data() + first_[several], first_[several + 1] - first_[several]);
    return static_cast<std::uint32_t>(std::ranges::lower_bound(views, view) - views.begin());
  }

 private:
  // Views are counted by far fewer than these.
  static constexpr std::uint32_t kNone = 0x7FFFFFFF, kSeveral = 0x80000000;
  std::vector<std::uint32_t> view_;   ///< by vertex: its only view, kNone, or kSeveral + its place in first_
  std::vector<std::size_t> first_;    ///< of a vertex with several views, in views_
  std::vector<std::uint32_t> views_;  ///< of vertices with several views
};

/// A node is a vertex in one view. One more, the last, stands for all finished faces: its offset is zero. Fills
/// correction.nodes; returns the number of nodes.
std::size_t make_nodes(const AtlasInput& input, ColorCorrection& correction) {
  const VertexViews views(input);
  std::vector<std::uint32_t> first(input.mesh.positions.size());
  std::size_t count = 0;
  for (std::uint32_t vertex = 0; vertex < first.size(); ++vertex) {
    first[vertex] = static_cast<std::uint32_t>(count);
    count += views.count(vertex);
  }
  correction.nodes.assign(input.mesh.faces.size(), {0, 0, 0});
  tbb::parallel_for(std::size_t{0}, input.mesh.faces.size(), [&](std::size_t face) {
    if (is_finished(input, face)) correction.nodes[face].fill(static_cast<std::uint32_t>(count));
    if (!has_offsets(input, face)) return;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t vertex = input.mesh.faces[face][i];
      correction.nodes[face][i] =
          first[vertex] + views.rank(vertex, static_cast<std::uint32_t>(index(input.labels[face])));
    }
  });
  return count + 1;
}

/// A term of the energy: the squared difference of two nodes' offsets.
struct Link {
  std::uint32_t a, b;
  float weight;
};

/// 0 where two faces lie in a plane, 1 at a right angle, 2 where they lie on each other.
double bend(const Mesh& mesh, const std::array<std::uint32_t, 2>& faces) {
  const auto normal = [&](std::uint32_t face) {
    const Triangle& t = mesh.faces[face];
    return cross(mesh.positions[t[1]] - mesh.positions[t[0]], mesh.positions[t[2]] - mesh.positions[t[0]]);
  };
  const WorldPoint a = normal(faces[0]), b = normal(faces[1]);
  const double lengths = length(a) * length(b);
  return lengths > 0 ? 1 - dot(a, b) / lengths : 0;
}

/// Differences across seams, assigned to the seams' vertices: each sample counts at both ends of its edge, more at the
/// nearer one.
void add_seams(const AtlasInput& input, const SeamSamples& seams, const ColorCorrection& correction,
               std::vector<Link>& links, Offsets& right) {
  const auto node_of = [&](std::uint32_t face, std::uint32_t vertex) {
    return correction.nodes[face][corner_of(input.mesh.faces[face], vertex)];
  };
  for (const SeamEdge& edge : seams.edges) {
    // Where surfaces meet at an angle, a photo shows some of the other beside the edge, all along it: misregistration does not
    // cancel out there as it does within a surface, however many samples there are.
    const double doubt = double{kDoubt} * bend(input.mesh, edge.faces);
    for (std::size_t end = 0; end < 2; ++end) {
      Offset difference = Offset::Zero();
      double weight = 0, whole = 0;
      for (std::uint32_t i = 0; i < edge.samples; ++i) {
        const std::size_t at = edge.first_sample + i;
        const double t = (i + 0.5) / edge.samples, w = double{seams.weight[at]} * (end ? t : 1 - t);
        const Color d = seams.colors[at][0] - seams.colors[at][1];
        difference += static_cast<float>(w) * Offset(d.r, d.g, d.b, 0);
        weight += w;
        whole += end ? t : 1 - t;
      }
      if (!(weight > 0)) continue;
      difference /= static_cast<float>(weight);
      difference *= static_cast<float>(weight / (weight + doubt * whole));
      const double size = std::sqrt(static_cast<double>(difference.square().sum()) / 3) / kOutlyingStep;
      const double w = std::min(1.0, weight / kSufficientWeight) / (1 + size * size);
      const std::uint32_t a = node_of(edge.faces[0], edge.vertices[end]);
      const std::uint32_t b = node_of(edge.faces[1], edge.vertices[end]);
      links.push_back({a, b, static_cast<float>(w)});
      right[a] -= links.back().weight * difference;
      right[b] += links.back().weight * difference;
    }
  }
}

/// The links of all nodes. Those within charts follow from the faces, whose list is a quarter as large.
class NodeLinks {
 public:
  /// Borrows the correction's nodes.
  NodeLinks(const AtlasInput& input, const ColorCorrection& correction, std::size_t nodes, std::span<const Link> across)
      : corners_(correction.nodes),
        across_(group_items<LinkTo>(nodes,
                                    [&](const auto& add) {
                                      for (const Link& link : across) {
                                        add(link.a, LinkTo{link.b, link.weight});
                                        add(link.b, LinkTo{link.a, link.weight});
                                      }
                                    })),
        faces_(group_numbered<std::uint32_t>(nodes, corners_.size(), [&](std::size_t face, const auto& add) {
          if (!has_offsets(input, face)) return;
          const auto& [a, b, c] = corners_[face];
          const auto number = static_cast<std::uint32_t>(face);
          add(a, number);
          if (b != a) add(b, number);
          if (c != a && c != b) add(c, number);
        })) {}

  std::size_t nodes() const { return faces_.groups(); }
  /// Calls visit(LinkTo): first for those across seams.
  template <typename Visit>
  void each(std::uint32_t node, const Visit& visit) const {
    for (const LinkTo& to : across_[node]) visit(to);
    for (const std::uint32_t face : faces_[node]) {
      const auto& n = corners_[face];
      for (std::size_t i = 0; i < 3; ++i) {
        const std::uint32_t from = n[i], to = n[(i + 1) % 3];
        if (from == to) continue;
        // Both faces of an inner edge add it, each with half its weight.
        if (from == node) visit(LinkTo{to, static_cast<float>(kSmooth / 2)});
        if (to == node) visit(LinkTo{from, static_cast<float>(kSmooth / 2)});
      }
    }
  }

 private:
  const std::vector<std::array<std::uint32_t, 3>>& corners_;
  Grouped<LinkTo> across_;
  Grouped<std::uint32_t> faces_;  ///< by node, each once
};

/// Nodes within kReachEdges links of a seam, without the last one, which stands for finished faces.
std::vector<char> near_seams(const NodeLinks& links, std::span<const Link> seams) {
  std::vector<char> near(links.nodes(), 0);
  near.back() = 1;
  // Which ring a node is in does not depend on the order within the rings before it.
  const auto reach = [&](std::uint32_t node, std::vector<std::uint32_t>& ring) {
    const std::atomic_ref known(near[node]);
    if (!known.load(std::memory_order_relaxed) && !known.exchange(1, std::memory_order_relaxed)) ring.push_back(node);
  };
  std::vector<std::uint32_t> ring;
  for (const Link& link : seams) {
    reach(link.a, ring);
    reach(link.b, ring);
  }
  for (int r = 0; r < kReachEdges && !ring.empty(); ++r) {
    tbb::enumerable_thread_specific<std::vector<std::uint32_t>> next;
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, ring.size(), 512), [&](const auto& range) {
      std::vector<std::uint32_t>& found = next.local();
      for (std::size_t i = range.begin(); i < range.end(); ++i)
        links.each(ring[i], [&](const LinkTo& to) { reach(to.node, found); });
    });
    ring.clear();
    for (const std::vector<std::uint32_t>& found : next) ring.insert(ring.end(), found.begin(), found.end());
  }
  near.back() = 0;
  return near;
}

/// The normal equations of the nodes near seams, which are renumbered. The other nodes' offsets are zero.
struct NearSystem {
  std::vector<std::uint32_t> node;  ///< per unknown
  OffsetSystem equations;
};

/// Each inner edge of a chart is two links of its nodes; the system has one.
NearSystem make_system(const NodeLinks& links, const std::vector<char>& near) {
  constexpr std::uint32_t kFar = 0xFFFFFFFFu;
  NearSystem system;
  std::vector<std::uint32_t> unknown(links.nodes(), kFar);
  for (std::uint32_t i = 0; i < near.size(); ++i)
    if (near[i]) {
      unknown[i] = static_cast<std::uint32_t>(system.node.size());
      system.node.push_back(i);
    }
  system.equations = make_rows(system.node.size(), [&](std::size_t i, LinkSums& sums) {
    float diagonal = static_cast<float>(kAnchor);
    links.each(system.node[i], [&](const LinkTo& to) {
      diagonal += to.weight;
      if (unknown[to.node] != kFar) sums.add(unknown[to.node], to.weight);
    });
    return diagonal;
  });
  return system;
}

}  // namespace

void fit_offsets(const AtlasInput& input, const SeamSamples& seams, ColorCorrection& correction) {
  const std::size_t nodes = make_nodes(input, correction);
  std::vector<Link> across;
  Offsets right(nodes, Offset::Zero());
  add_seams(input, seams, correction, across, right);
  const NodeLinks links(input, correction, nodes, across);
  const std::vector<char> near = near_seams(links, across);
  const NearSystem system = make_system(links, near);
  Offsets near_right;
  near_right.reserve(system.node.size());
  for (const std::uint32_t i : system.node) near_right.push_back(right[i]);
  const Offsets x = solve(system.equations, std::move(near_right));
  correction.offsets.assign(nodes, Color{});
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Offset limited = x[i].max(-kMostOffset).min(kMostOffset);
    correction.offsets[system.node[i]] = {limited[0], limited[1], limited[2]};
  }
}

}  // namespace gpvc::atlas
