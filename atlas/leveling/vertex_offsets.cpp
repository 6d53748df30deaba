// Offsets of colour per vertex that close the steps at seams.
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>
#include <tbb/parallel_sort.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "atlas/leveling/seam_leveling.h"
#include "io/grouping.h"

namespace gpvc::atlas {

namespace {

using Offset = Eigen::Array3d;
using Offsets = std::vector<Offset>;

/// Weights of the energy's squared differences: 1 between the two sides of a seam, kSmooth between the ends of an edge
/// within a chart, kAnchor for the offset itself. An offset fades over sqrt(kSmooth / kAnchor) = 32 edges from its
/// seam. A few per cent of a constant step remain, and are left to the strips.
constexpr double kSmooth = 1.0, kAnchor = 1e-3;
/// Differences beyond this, in grey levels, come from different content rather than brightness, and get less weight.
constexpr double kOutlyingStep = 40;
/// Sum of sample weights at one end of an edge that gives its difference full weight.
constexpr double kSufficientWeight = 2;
constexpr double kMostOffset = 80;
/// Offsets more edges than this away from any seam are zero.
constexpr int kReachEdges = 48;

/// A node is a vertex in one view. Fills correction.nodes; returns the number of nodes.
std::size_t make_nodes(const AtlasInput& input, ColorCorrection& correction) {
  struct Corner {
    std::uint32_t vertex, view;
    std::uint64_t corner;
    auto operator<=>(const Corner&) const = default;
  };
  std::vector<Corner> corners;
  corners.reserve(3 * input.mesh.faces.size());
  for (std::size_t face = 0; face < input.mesh.faces.size(); ++face) {
    if (!has_view(input, face)) continue;
    for (std::size_t i = 0; i < 3; ++i)
      corners.push_back({input.mesh.faces[face][i], static_cast<std::uint32_t>(input.labels[face]), 3 * face + i});
  }
  tbb::parallel_sort(corners.begin(), corners.end());
  correction.nodes.assign(input.mesh.faces.size(), {0, 0, 0});
  std::size_t count = 0;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    if (k == 0 || corners[k].vertex != corners[k - 1].vertex || corners[k].view != corners[k - 1].view) ++count;
    correction.nodes[corners[k].corner / 3][corners[k].corner % 3] = static_cast<std::uint32_t>(count - 1);
  }
  return count;
}

/// A term of the energy: the squared difference of two nodes' offsets.
struct Link {
  std::uint32_t a, b;
  float weight;
};

/// A link as one of its nodes sees it.
struct LinkTo {
  std::uint32_t node;
  float weight;
};
using Links = Grouped<LinkTo>;

/// Differences across seams, assigned to the seams' vertices: each sample counts at both ends of its edge, more at the
/// nearer one.
void add_seams(const AtlasInput& input, const SeamSamples& seams, const ColorCorrection& correction,
               std::vector<Link>& links, Offsets& right) {
  const auto node_of = [&](std::uint32_t face, std::uint32_t vertex) {
    for (std::size_t i = 0; i < 3; ++i)
      if (input.mesh.faces[face][i] == vertex) return correction.nodes[face][i];
    return correction.nodes[face][0];
  };
  for (const SeamEdge& edge : seams.edges) {
    for (std::size_t end = 0; end < 2; ++end) {
      Offset difference = Offset::Zero();
      double weight = 0;
      for (std::uint32_t i = 0; i < edge.samples; ++i) {
        const std::size_t at = edge.first_sample + i;
        const double t = (i + 0.5) / edge.samples, w = double{seams.weight[at]} * (end ? t : 1 - t);
        const Color d = seams.colors[at][0] - seams.colors[at][1];
        difference += w * Offset(d.r, d.g, d.b);
        weight += w;
      }
      if (!(weight > 0)) continue;
      difference /= weight;
      const double size = std::sqrt(difference.square().mean()) / kOutlyingStep;
      const double w = std::min(1.0, weight / kSufficientWeight) / (1 + size * size);
      const std::uint32_t a = node_of(edge.faces[0], edge.vertices[end]);
      const std::uint32_t b = node_of(edge.faces[1], edge.vertices[end]);
      links.push_back({a, b, static_cast<float>(w)});
      right[a] -= double{links.back().weight} * difference;
      right[b] += double{links.back().weight} * difference;
    }
  }
}

/// Nodes within kReachEdges links of a seam.
std::vector<char> near_seams(const Links& links, std::span<const Link> seams) {
  std::vector<char> near(links.groups(), 0);
  std::vector<std::uint32_t> ring, next;
  const auto reach = [&](std::uint32_t node, std::vector<std::uint32_t>& list) {
    if (near[node]) return;
    near[node] = 1;
    list.push_back(node);
  };
  for (const Link& link : seams) {
    reach(link.a, ring);
    reach(link.b, ring);
  }
  for (int r = 0; r < kReachEdges && !ring.empty(); ++r) {
    next.clear();
    for (const auto node : ring)
      for (const LinkTo& to : links[node]) reach(to.node, next);
    std::swap(ring, next);
  }
  return near;
}

/// The normal equations: the diagonal minus the links, on the active nodes. The other nodes' offsets are zero.
struct System {
  const Links& links;
  std::vector<double> diagonal;
  std::vector<std::uint32_t> active;

  template <typename Body>
  void for_active(const Body& body) const {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, active.size(), 2048), [&](const auto& range) {
      for (std::size_t k = range.begin(); k < range.end(); ++k) body(active[k]);
    });
  }
  Offset times(const Offsets& x, std::uint32_t i) const {
    Offset sum = diagonal[i] * x[i];
    for (const LinkTo& to : links[i]) sum -= double{to.weight} * x[to.node];
    return sum;
  }
  /// Sums in an order that does not depend on the number of threads.
  template <typename Term>
  Offset sum(const Term& term) const {
    return tbb::parallel_deterministic_reduce(
        tbb::blocked_range<std::size_t>(0, active.size(), 4096), Offset(Offset::Zero()),
        [&](const auto& range, Offset partial) {
          for (std::size_t k = range.begin(); k < range.end(); ++k) partial += term(active[k]);
          return partial;
        },
        [](const Offset& a, const Offset& b) { return Offset(a + b); });
  }
};

/// Conjugate gradients with the diagonal as preconditioner, for the three channels at once.
Offsets solve(const System& system, const Offsets& right) {
  // A relative residual of 1e-3 leaves errors of a few hundredths of a grey level near seams.
  constexpr double kTolerance = 1e-3;
  constexpr int kMostIterations = 300;
  const std::size_t n = right.size();
  Offsets x(n, Offset::Zero()), r(n, Offset::Zero()), p(n, Offset::Zero()), q(n, Offset::Zero());
  system.for_active([&](std::uint32_t i) {
    r[i] = right[i];
    p[i] = r[i] / system.diagonal[i];
  });
  Offset rho = system.sum([&](std::uint32_t i) { return Offset(r[i] * p[i]); });
  const Offset target = kTolerance * kTolerance * rho;
  for (int k = 0; k < kMostIterations && (rho > target).any(); ++k) {
    system.for_active([&](std::uint32_t i) { q[i] = system.times(p, i); });
    const Offset pq = system.sum([&](std::uint32_t i) { return Offset(p[i] * q[i]); });
    const Offset alpha = (pq > 0).select(rho / pq, Offset::Zero());
    system.for_active([&](std::uint32_t i) {
      x[i] += alpha * p[i];
      r[i] -= alpha * q[i];
    });
    const Offset next = system.sum([&](std::uint32_t i) { return Offset(r[i] * r[i] / system.diagonal[i]); });
    const Offset beta = (rho > 0).select(next / rho, Offset::Zero());
    system.for_active([&](std::uint32_t i) { p[i] = r[i] / system.diagonal[i] + beta * p[i]; });
    rho = next;
  }
  return x;
}

}  // namespace

void fit_offsets(const AtlasInput& input, const SeamSamples& seams, ColorCorrection& correction) {
  const std::size_t nodes = make_nodes(input, correction);
  std::vector<Link> list;
  Offsets right(nodes, Offset::Zero());
  add_seams(input, seams, correction, list, right);
  const std::size_t across = list.size();
  list.reserve(list.size() + 3 * input.mesh.faces.size());
  for (std::size_t face = 0; face < input.mesh.faces.size(); ++face) {
    if (!has_view(input, face)) continue;
    const auto& n = correction.nodes[face];
    // Both faces of an inner edge add it, each with half its weight.
    for (std::size_t i = 0; i < 3; ++i)
      if (n[i] != n[(i + 1) % 3]) list.push_back({n[i], n[(i + 1) % 3], static_cast<float>(kSmooth / 2)});
  }
  const Links links = group_items<LinkTo>(nodes, [&](const auto& emit) {
    for (const Link& link : list) {
      emit(link.a, LinkTo{link.b, link.weight});
      emit(link.b, LinkTo{link.a, link.weight});
    }
  });
  const std::vector<char> near = near_seams(links, std::span(list).first(across));
  System system{links, std::vector<double>(nodes, kAnchor), {}};
  for (std::uint32_t i = 0; i < nodes; ++i) {
    for (const LinkTo& to : links[i]) system.diagonal[i] += double{to.weight};
    if (near[i]) system.active.push_back(i);
  }
  const Offsets x = solve(system, right);
  correction.offsets.resize(nodes);
  for (std::size_t i = 0; i < nodes; ++i) {
    const Eigen::Array3f limited = x[i].max(-kMostOffset).min(kMostOffset).cast<float>();
    correction.offsets[i] = {limited[0], limited[1], limited[2]};
  }
}

}  // namespace gpvc::atlas
