// Measures view selection. `labeling COSTS MESH` solves a stored instance, fast and thoroughly: energy, differing pairs,
// patches and time, and a lower bound on the energy. `labeling --sizes` makes instances with 12 candidates per face out of
// 200 views, and prints time and memory against size.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <random>
#include <string>

#include "benchmarks/command.h"
#include "benchmarks/potts_lower_bound.h"
#include "io/clock.h"
#include "io/mesh.h"
#include "labeling/labeling.h"

namespace gpvc {
namespace {

void solve_stored(const std::string& costs, const std::string& mesh_file) {
  const labeling::CostTable table = labeling::read_costs(costs);
  const Mesh mesh = io::read_mesh(mesh_file);
  auto start = Clock::now();
  const labeling::FaceGraph graph = labeling::face_graph(mesh);
  std::printf("%zu faces, %zu adjacent pairs (%.3f s), %zu candidates\n", table.faces(), graph.edges.size(),
              seconds_since(start), table.views.size());
  std::printf(
      "| search | sweeps | energy | differing pairs | patches | wall s | CPU s |\n|---|---|---|---|---|---|---|\n");
  double energy = 0;
  for (const bool thorough : {false, true}) {
    labeling::SolverOptions options;
    options.thorough = thorough;
    start = Clock::now();
    const double cpu = cpu_seconds();
    const labeling::Selection selection = labeling::select_views(table, graph, options, {});
    energy = selection.energy;
    std::printf("| %s | %d | %.2f | %zu | %zu | %.2f | %.2f |\n", thorough ? "thorough" : "fast",
                selection.sweeps.back().sweep, energy, selection.differing_pairs, selection.patches,
                seconds_since(start), cpu_seconds() - cpu);
    std::fflush(stdout);
  }
  for (const int rounds : {0, 10, 100}) {
    start = Clock::now();
    const double bound = potts_lower_bound(table, graph, labeling::SolverOptions{}.smoothness, rounds);
    std::printf("lower bound after %d rounds: %.2f (energy is %.3f %% above; %.1f s)\n", rounds, bound,
                100 * (energy / bound - 1), seconds_since(start));
  }
}

/// A square grid of triangle pairs seen by 200 views in 20 x 10 overlapping discs: each face takes its 12 nearest.
void make_instance(std::size_t faces, labeling::CostTable& table, labeling::FaceGraph& graph) {
  constexpr int kViews = 200, kColumns = 20, kCandidates = 12;
  const auto side = static_cast<std::size_t>(std::sqrt(static_cast<double>(faces) / 2));
  Mesh mesh;
  mesh.positions.resize((side + 1) * (side + 1));
  for (std::uint32_t y = 0; y < side; ++y)
    for (std::uint32_t x = 0; x < side; ++x) {
      const auto a = static_cast<std::uint32_t>(y * (side + 1) + x), c = static_cast<std::uint32_t>(a + side + 1);
      mesh.faces.push_back({a, c, a + 1});
      mesh.faces.push_back({a + 1, c, c + 1});
    }
  graph = labeling::face_graph(mesh);
  std::mt19937 random(1);
  std::uniform_real_distribution<float> noise(0, 0.3f);
  table.first.assign(1, 0);
  std::array<std::pair<float, std::uint32_t>, kViews> by_distance;
  std::array<std::uint32_t, kCandidates> views;
  for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
    const float x = static_cast<float>(face / 2 % side) / static_cast<float>(side) * kColumns;
    const float y = static_cast<float>(face / 2 / side) / static_cast<float>(side) * kViews / kColumns;
    for (std::uint32_t view = 0; view < kViews; ++view) {
      const float dx = x - 0.5f - static_cast<float>(view % kColumns),
                  dy = y - 0.5f - static_cast<float>(view / kColumns);
      by_distance[view] = {dx * dx + dy * dy, view};
    }
    std::nth_element(by_distance.begin(), by_distance.begin() + kCandidates, by_distance.end());
    for (std::size_t i = 0; i < kCandidates; ++i) views[i] = by_distance[i].second;
    std::sort(views.begin(), views.end());
    for (const std::uint32_t view : views) {
      const float dx = x - 0.5f - static_cast<float>(view % kColumns),
                  dy = y - 0.5f - static_cast<float>(view / kColumns);
      table.views.push_back(view);
      table.costs.push_back(std::min(1.0f, 0.1f * std::sqrt(dx * dx + dy * dy) + 0.3f + noise(random)));
    }
    table.first.push_back(table.views.size());
  }
}

void size_table(std::size_t max_faces) {
  std::printf("| faces | candidates | wall s | CPU s | us a face | peak MB of the process | energy | patches |\n");
  std::printf("|---|---|---|---|---|---|---|---|\n");
  for (const std::size_t faces : {10'000u, 30'000u, 100'000u, 300'000u, 1'000'000u, 3'000'000u}) {
    if (faces > max_faces) break;
    labeling::CostTable table;
    labeling::FaceGraph graph;
    make_instance(faces, table, graph);
    const auto start = Clock::now();
    const double cpu = cpu_seconds();
    const labeling::Selection selection = labeling::select_views(table, graph, {}, {});
    const double wall = seconds_since(start);
    std::printf("| %zu | %zu | %.2f | %.2f | %.1f | %.0f | %.1f | %zu |\n", table.faces(), table.views.size(), wall,
                cpu_seconds() - cpu, 1e6 * wall / static_cast<double>(table.faces()),
                static_cast<double>(peak_resident_bytes()) / (1 << 20), selection.energy, selection.patches);
    std::fflush(stdout);
  }
}

}  // namespace
}  // namespace gpvc

int main(int argc, char** argv) {
  CLI::App app("Measures view selection");
  std::string costs, mesh;
  bool sizes = false;
  std::size_t max_faces = 3'000'000;
  app.add_option("COSTS", costs, "Costs, as `gpvc label` reads them");
  app.add_option("MESH", mesh, "Mesh of as many faces");
  app.add_flag("--sizes", sizes, "Measure generated instances by size instead");
  app.add_option("--max-faces", max_faces, "Largest generated instance");
  return gpvc::run_benchmark(app, argc, argv, [&] {
    if (sizes == !mesh.empty()) throw std::invalid_argument("expected either COSTS and MESH or --sizes");
    if (sizes)
      gpvc::size_table(max_faces);
    else
      gpvc::solve_stored(costs, mesh);
    return 0;
  });
}
