// Time of packing, and of the whole atlas stage, by size, on generated scenes that are the same on every run.
#include <benchmark/benchmark.h>

#include <unistd.h>
#include <cmath>
#include <filesystem>
#include <random>
#include <string>

#include "atlas/atlas.h"
#include "atlas/packing/packing.h"

namespace {

using namespace gpvc;

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
BENCHMARK(packing)
    ->RangeMultiplier(4)
    ->Range(256, 65536)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();

/// A square plane under sixteen cameras, with labels in ragged patches and photos on disk.
class Plane {
 public:
  explicit Plane(int faces)
      : folder_(std::filesystem::temp_directory_path() / ("gpvc-benchmark-" + std::to_string(getpid()))) {
    std::filesystem::create_directories(folder_);
    const int edge = static_cast<int>(std::sqrt(faces / 2.0));
    const double cell = 24.0 / edge;
    for (int y = 0; y <= edge; ++y)
      for (int x = 0; x <= edge; ++x) mesh_.positions.push_back({x * cell, y * cell, 0});
    const auto at = [&](int x, int y) { return static_cast<std::uint32_t>(y * (edge + 1) + x); };
    for (int y = 0; y < edge; ++y) {
      for (int x = 0; x < edge; ++x) {
        mesh_.faces.push_back({at(x, y), at(x + 1, y), at(x + 1, y + 1)});
        mesh_.faces.push_back({at(x, y), at(x + 1, y + 1), at(x, y + 1)});
        labels_.insert(labels_.end(), 2, label(x * cell, y * cell));
      }
    }
    tags_.assign(mesh_.faces.size(), labeling::FaceTag::seen);
    candidates_.first.assign(mesh_.faces.size() + 1, 0);
    graph_ = labeling::face_graph(mesh_);
    for (int v = 0; v < 16; ++v) add_view(v);
    photos_.emplace(scene_, 1, std::size_t{1} << 30);
    for (std::uint32_t v = 0; v < 16; ++v) photos_->photo(ViewId{v});
  }
  ~Plane() { std::filesystem::remove_all(folder_); }
  Plane(const Plane&) = delete;
  Plane& operator=(const Plane&) = delete;

  atlas::AtlasInput input() { return {mesh_, scene_, *photos_, graph_, labels_, tags_, candidates_, coverage_}; }

 private:
  static ViewId label(double x, double y) {
    const auto quarter = [](double t) { return static_cast<std::uint32_t>(std::clamp(t / 6, 0.0, 3.0)); };
    return ViewId{quarter(x + 0.4 * std::sin(5 * y)) + 4 * quarter(y + 0.4 * std::sin(4 * x))};
  }

  void add_view(int v) {
    View view;
    view.name = "photo" + std::to_string(v) + ".png";
    view.photo = folder_ / view.name;
    view.camera = {1200, 1200, 1100, 1100, 600, 600, {-0.05, 0.01, 0, 0, 0}};
    limit_distortion(view.camera);
    view.pose.rotation = {1, 0, 0, 0, -1, 0, 0, 0, -1};
    view.pose.centre = {3.0 + 6 * (v % 4), 3.0 + 6 * (v / 4), 9};
    Image image{1200, 1200, 3, std::vector<std::uint8_t>(3 * 1200 * 1200)};
    for (std::size_t i = 0; i < image.pixels.size(); ++i)
      image.pixels[i] = static_cast<std::uint8_t>(90 + 4 * v + static_cast<int>(i * 2654435761u >> 28));
    io::write_image(view.photo, image, io::ImageFormat::png, 90);
    scene_.views.push_back(view);
  }

  std::filesystem::path folder_;
  Mesh mesh_;
  Scene scene_;
  labeling::FaceGraph graph_;
  std::vector<ViewId> labels_;
  std::vector<labeling::FaceTag> tags_;
  labeling::CostTable candidates_;
  visibility::CoverageTable coverage_;
  std::optional<io::PhotoCache> photos_;
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
BENCHMARK(atlas)
    ->RangeMultiplier(4)
    ->Range(8192, 524288)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();

}  // namespace

BENCHMARK_MAIN();
