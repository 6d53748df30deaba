// Time of packing, and of the whole atlas stage, by size, on generated scenes that are the same on every run.
#include <benchmark/benchmark.h>

#include <cmath>
#include <random>
#include <string>

#include "atlas/atlas.h"
#include "atlas/packing/packing.h"
#include "tests/support/grid_mesh.h"

namespace {

using namespace gpvc;

/// Sizes from `least` to `most` by factors of 4; wall time, and CPU time of all threads.
void by_size(benchmark::internal::Benchmark* measured, int least, int most) {
  measured->RangeMultiplier(4)->Range(least, most)->Unit(benchmark::kMillisecond);
  measured->MeasureProcessCPUTime()->UseRealTime();
}

/// Discs whose sizes are distributed like those of charts: many small ones, few large ones.
std::vector<atlas::PackShape> disc_shapes(std::size_t count) {
  std::mt19937 random(1);
  std::vector<atlas::PackShape> shapes;
  for (std::size_t i = 0; i < count; ++i) {
    const double share = static_cast<double>(random()) / 0x100000000u;
    const int radius = 1 + static_cast<int>(1.5 / std::sqrt(share + 1.0 / 1600));
    atlas::PackShape shape{2 * radius, 2 * radius, {}};
    for (int row = 0; row < 2 * radius; ++row) {
      const double y = std::abs(row + 0.5 - radius);
      const int half = std::max(1, static_cast<int>(std::sqrt(radius * double(radius) - y * y)));
      shape.runs.push_back({row, radius - half, 2 * half});
    }
    shapes.push_back(std::move(shape));
  }
  return shapes;
}

void packing(benchmark::State& state) {
  const auto shapes = disc_shapes(static_cast<std::size_t>(state.range(0)));
  double cells = 0, page_cells = 0;
  for (const auto& shape : shapes)
    for (const auto& run : shape.runs) cells += run.length;
  for (auto _ : state) {
    const atlas::Packing result = atlas::pack_shapes(shapes, 512);
    page_cells = 0;
    for (const auto& page : result.pages) page_cells += double(page.width) * page.height;
    state.counters["pages"] = static_cast<double>(result.pages.size());
  }
  state.counters["fill"] = cells / page_cells;
  state.SetItemsProcessed(state.iterations() * state.range(0));
}
BENCHMARK(packing)->Apply([](auto* packing) { by_size(packing, 256, 65536); });

/// A square plane under sixteen cameras, with labels in ragged patches and photos in memory.
class Plane {
 public:
  explicit Plane(int faces) {
    const int edge = static_cast<int>(std::sqrt(faces / 2.0));
    const double cell = 24.0 / edge;
    mesh_ = test::grid_mesh(edge, edge, cell);
    for (int y = 0; y < edge; ++y)
      for (int x = 0; x < edge; ++x) labels_.insert(labels_.end(), 2, label(x * cell, y * cell));
    tags_.assign(mesh_.faces.size(), labeling::FaceTag::seen);
    candidates_.first.assign(mesh_.faces.size() + 1, 0);
    graph_ = labeling::face_graph(mesh_);
    std::vector<io::Picture> pictures;
    for (int v = 0; v < 16; ++v) pictures.push_back(add_view(v));
    photos_.emplace(scene_, std::move(pictures));
  }

  atlas::AtlasInput input() { return {mesh_, scene_, *photos_, graph_, labels_, tags_, candidates_, coverage_}; }

 private:
  static ViewId label(double x, double y) {
    const auto quarter = [](double t) { return static_cast<std::uint32_t>(std::clamp(t / 6, 0.0, 3.0)); };
    return ViewId{quarter(x + 0.4 * std::sin(5 * y)) + 4 * quarter(y + 0.4 * std::sin(4 * x))};
  }

  io::Picture add_view(int v) {
    View view;
    view.name = "photo" + std::to_string(v) + ".png";
    view.camera = {1200, 1200, 1100, 1100, 600, 600, {-0.05, 0.01, 0, 0, 0}};
    limit_distortion(view.camera);
    view.pose.rotation = {1, 0, 0, 0, -1, 0, 0, 0, -1};
    view.pose.centre = {3.0 + 6 * (v % 4), 3.0 + 6 * (v / 4), 9};
    scene_.views.push_back(view);
    Image image{1200, 1200, 3, std::vector<std::uint8_t>(3 * 1200 * 1200)};
    for (std::size_t i = 0; i < image.pixels.size(); ++i)
      image.pixels[i] = static_cast<std::uint8_t>(90 + 4 * v + static_cast<int>(i * 2654435761u >> 28));
    return {std::move(image)};
  }

  Mesh mesh_;
  Scene scene_;
  labeling::FaceGraph graph_;
  std::vector<ViewId> labels_;
  std::vector<labeling::FaceTag> tags_;
  labeling::CostTable candidates_;
  visibility::CoverageTable coverage_;
  std::optional<io::PictureSource> photos_;
};

/// The whole stage. Counters hold the time of each part.
void atlas(benchmark::State& state) {
  Plane plane(static_cast<int>(state.range(0)));
  const atlas::AtlasInput input = plane.input();
  double layout = 0, leveling = 0, baking = 0;
  for (auto _ : state) {
    const atlas::TextureAtlas result = atlas::build_atlas(input, atlas::AtlasOptions{}, nullptr);
    layout += result.statistics.layout_s;
    leveling += result.statistics.leveling_s;
    baking += result.statistics.baking_s;
    state.counters["texels"] = static_cast<double>(result.statistics.chart_texels);
    state.counters["charts"] = static_cast<double>(result.statistics.charts);
  }
  const auto mean = benchmark::Counter::kAvgIterations;
  state.counters["layout_s"] = benchmark::Counter(layout, mean);
  state.counters["leveling_s"] = benchmark::Counter(leveling, mean);
  state.counters["baking_s"] = benchmark::Counter(baking, mean);
  state.SetItemsProcessed(state.iterations() * state.range(0));
}
BENCHMARK(atlas)->Apply([](auto* atlas) { by_size(atlas, 8192, 524288); });

}  // namespace

BENCHMARK_MAIN();
