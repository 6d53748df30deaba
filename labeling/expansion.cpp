// Alpha expansion: view after view, every face may switch to that view or keep its own; the best such move is
// a minimum cut.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>
#include <utility>

#include "labeling/graph_cut.h"
#include "labeling/labeling.h"

namespace gpvc {
namespace {

constexpr std::uint32_t kNone = 0xFFFFFFFFu;

/// Connected components of equal label, faces without one left out.
std::size_t count_patches(const FaceGraph& graph, std::span<const ViewId> labels) {
  std::vector<std::uint32_t> parent(labels.size());
  std::iota(parent.begin(), parent.end(), 0u);
  const auto root = [&](std::uint32_t face) {
    while (parent[face] != face) face = parent[face] = parent[parent[face]];
    return face;
  };
  std::size_t patches = 0;
  for (const ViewId label : labels) patches += label != kNoView;
  for (const auto& [a, b] : graph.edges)
    if (labels[a] != kNoView && labels[a] == labels[b])
      if (const std::uint32_t x = root(a), y = root(b); x != y) {
        parent[x] = y;
        --patches;
      }
  return patches;
}

std::size_t count_differing_pairs(const FaceGraph& graph, std::span<const ViewId> labels) {
  std::size_t differing = 0;
  for (const auto& [a, b] : graph.edges)
    differing += labels[a] != kNoView && labels[b] != kNoView && labels[a] != labels[b];
  return differing;
}

}  // namespace

double labeling_energy(const CostTable& table, const FaceGraph& graph, std::span<const ViewId> labels,
                       double smoothness) {
  double energy = 0;
  for (std::size_t face = 0; face < table.faces(); ++face)
    for (std::size_t i = table.first[face]; i < table.first[face + 1]; ++i)
      if (table.views[i] == static_cast<std::uint32_t>(labels[face]))
        energy += static_cast<double>(table.costs[i]);
  return energy + smoothness * static_cast<double>(count_differing_pairs(graph, labels));
}

Selection select_views(const CostTable& table, const FaceGraph& graph, const SolverOptions& options,
                       const Progress& progress) {
  const auto start = std::chrono::steady_clock::now();
  const std::size_t faces = table.faces();
  const double scale = std::ldexp(1.0, 32);
  const auto fixed = [&](float cost) {
    return static_cast<Capacity>(std::llround(static_cast<double>(cost) * scale));
  };
  const Capacity w = 2 * static_cast<Capacity>(std::llround(options.smoothness * scale / 2));
  const std::uint32_t views =
      table.views.empty() ? 0 : 1 + *std::max_element(table.views.begin(), table.views.end());

  // by view
  std::vector<std::size_t> first(views + 1, 0);
  for (std::uint32_t v : table.views) ++first[v + 1];
  std::partial_sum(first.begin(), first.end(), first.begin());
  std::vector<std::uint32_t> vf(table.views.size());
  std::vector<Capacity> vc(table.views.size());
  {
    auto next = first;
    for (std::uint32_t f = 0; f < faces; ++f)
      for (std::size_t i = table.first[f]; i < table.first[f + 1]; ++i) {
        const std::size_t at = next[table.views[i]]++;
        vf[at] = f;
        vc[at] = fixed(table.costs[i]);
      }
  }
  std::vector<std::uint32_t> label(faces, kNone);
  std::vector<Capacity> cost(faces, 0);
  for (std::size_t f = 0; f < faces; ++f)
    for (std::size_t i = table.first[f]; i < table.first[f + 1]; ++i)
      if (label[f] == kNone || fixed(table.costs[i]) < cost[f]) {
        label[f] = table.views[i];
        cost[f] = fixed(table.costs[i]);
      }
  std::vector<std::uint32_t> nfirst(faces + 1, 0), nbr;
  for (const auto& [a, b] : graph.edges)
    if (label[a] != kNone && label[b] != kNone) ++nfirst[a], ++nfirst[b];
  std::uint32_t sum = 0;
  for (auto& x : nfirst) sum += std::exchange(x, sum);
  nbr.resize(sum);
  {
    auto next = nfirst;
    for (const auto& [a, b] : graph.edges)
      if (label[a] != kNone && label[b] != kNone) {
        nbr[next[a]++] = b;
        nbr[next[b]++] = a;
      }
  }
  Selection result;
  std::vector<std::uint32_t> local(faces, kNone), nodes;
  CutGraph cut;
  for (int sweep = 1; sweep <= options.max_sweeps; ++sweep) {
    std::size_t changed = 0;
    for (std::uint32_t alpha = 0; alpha < views; ++alpha) {
      auto& t = cut.topology;
      t.clear();
      nodes.clear();
      std::vector<Capacity> acost;
      for (std::size_t i = first[alpha]; i < first[alpha + 1]; ++i)
        if (label[vf[i]] != alpha) {
          local[vf[i]] = static_cast<std::uint32_t>(nodes.size());
          nodes.push_back(vf[i]);
          acost.push_back(vc[i]);
        }
      for (std::uint32_t node = 0; node < nodes.size(); ++node) {
        const std::uint32_t f = nodes[node];
        Capacity gain = cost[f] - acost[node];
        for (std::uint32_t a = nfirst[f]; a < nfirst[f + 1]; ++a) {
          const std::uint32_t g = nbr[a];
          if (local[g] != kNone) {
            t.target.push_back(local[g]);
            if (label[g] == label[f])
              t.capacity.push_back(w);
            else
              t.capacity.push_back(w / 2), gain += w / 2;
          } else if (label[g] == alpha)
            gain += w;
          else if (label[g] == label[f])
            gain -= w;
        }
        t.first.push_back(static_cast<std::uint32_t>(t.target.size()));
        t.terminal.push_back(gain);
      }
      t.reverse.resize(t.target.size());
      for (std::uint32_t node = 0; node < nodes.size(); ++node)
        for (std::uint32_t a = t.first[node]; a < t.first[node + 1]; ++a) {
          const std::uint32_t other = t.target[a];
          for (std::uint32_t b = t.first[other]; b < t.first[other + 1]; ++b)
            if (t.target[b] == node) t.reverse[a] = b;
        }
      const auto& takes = cut.solve();
      for (std::uint32_t node = 0; node < nodes.size(); ++node) {
        if (takes[node]) {
          label[nodes[node]] = alpha;
          cost[nodes[node]] = acost[node];
          ++changed;
        }
        local[nodes[node]] = kNone;
      }
    }
    if (progress) progress(static_cast<std::size_t>(sweep), static_cast<std::size_t>(options.max_sweeps));
    result.labels.resize(faces);
    for (std::size_t f = 0; f < faces; ++f) result.labels[f] = ViewId{label[f]};
    result.sweeps.push_back(
        {sweep, labeling_energy(table, graph, result.labels, options.smoothness),
         std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count()});
    if (changed == 0) break;
  }
  result.energy = labeling_energy(table, graph, result.labels, options.smoothness);
  result.differing_pairs = count_differing_pairs(graph, result.labels);
  result.patches = count_patches(graph, result.labels);
  return result;
}

}  // namespace gpvc
