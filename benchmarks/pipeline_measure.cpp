// Runs the program on a scene, and the floor beneath it: what its files alone cost.
#include <fmt/format.h>
#include <sys/resource.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string_view>

#include "benchmarks/child.h"
#include "benchmarks/pipeline.h"
#include "io/clock.h"
#include "io/file_bytes.h"
#include "io/images.h"

namespace gpvc::scaling {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

double seconds_of(const timeval& t) { return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec); }

// --- the program

Json read_run(const fs::path& model) {
  const fs::path file = model / "run.json";
  std::ifstream in(file);
  const Json run = Json::parse(in, nullptr, false);
  if (!run.is_object() || !run.contains("stages")) throw std::runtime_error(file.string() + ": is no record of a run");
  return run;
}

StageSeconds stages_of(const Json& run, double wall_s) {
  StageSeconds s;
  for (const Json& stage : run["stages"]) {
    const auto name = stage["name"].get<std::string>();
    const auto seconds = stage["wall_s"].get<double>();
    if (name == "see") s.see += seconds;
    if (name == "choose") s.choose += seconds;
    if (name == "bake") s.bake += seconds;
    if (name == "write") s.write += seconds;
  }
  s.other = wall_s - s.see - s.choose - s.bake - s.write;
  return s;
}

Measured run_once(const SceneSize& size, const SceneFiles& scene, const RunOptions& options, const fs::path& model) {
  std::vector<std::string> words{options.gpvc.string(), "texture", scene.folder.string(), scene.mesh.string(), "-o",
                                 model.string(),        "--force"};
  if (!options.memory.empty()) words.insert(words.end(), {"--memory", options.memory});
  const Clock::time_point start = Clock::now();
  const fs::path log = model.string() + ".log";
  const Ended ended = run_program(words, log);
  if (ended.status != 0)
    throw std::runtime_error(
        fmt::format("{} ended with {}; its output is in {}", words[0], how_ended(ended.status), log.string()));
  const rusage& usage = ended.usage;
  Measured m{size, scene.faces, seconds_since(start), 0, 0, {}, {}};
  m.cpu_s = seconds_of(usage.ru_utime) + seconds_of(usage.ru_stime);
  m.peak_gb = static_cast<double>(usage.ru_maxrss) * 1024e-9;  // Linux counts in KiB
  m.stages = stages_of(read_run(model), m.wall_s);
  return m;
}

// --- the floor

std::vector<fs::path> files_in(const fs::path& folder, std::string_view prefix) {
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder))
    if (io::has_image_extension(entry.path()) && entry.path().filename().string().starts_with(prefix))
      files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

double decode_seconds(const std::vector<fs::path>& photos) {
  const Clock::time_point start = Clock::now();
  tbb::parallel_for(
      std::size_t{0}, photos.size(), [&](std::size_t n) { io::read_image(photos[n]); }, tbb::simple_partitioner());
  return seconds_since(start);
}

/// The page cut into strips of whole rows, several for each thread: so one page alone keeps all of them busy.
std::vector<Image> strips_of(const Image& page) {
  const int rows = std::max(16, page.height / (4 * tbb::info::default_concurrency()));
  std::vector<Image> strips;
  for (int y = 0; y < page.height; y += rows) {
    Image strip{page.width, std::min(rows, page.height - y), page.channels, {}};
    strip.pixels.assign(page.at(0, y), page.at(0, y) + page.pixels.size() / static_cast<std::size_t>(page.height) *
                                                           static_cast<std::size_t>(strip.height));
    strips.push_back(std::move(strip));
  }
  return strips;
}

double encode_seconds(const std::vector<Image>& strips, int quality, const fs::path& scratch) {
  const Clock::time_point start = Clock::now();
  tbb::parallel_for(
      std::size_t{0}, strips.size(),
      [&](std::size_t n) {
        io::write_image(scratch / fmt::format("{}.jpg", n), strips[n], io::ImageFormat::jpg, quality);
      },
      tbb::simple_partitioner());
  return seconds_since(start);
}

Floor measure_floor(const SceneFiles& scene, const fs::path& model, const fs::path& scratch) {
  const int quality = read_run(model)["options"]["quality"].get<int>();
  fs::create_directories(scratch);
  Floor floor;
  floor.decode_s = decode_seconds(files_in(scene.folder / "images", ""));
  for (const fs::path& file : files_in(model, "model_")) {
    const Image page = io::read_image(file);
    floor.megatexels += 1e-6 * page.width * page.height;
    floor.encode_s += encode_seconds(strips_of(page), quality, scratch);
  }
  fs::remove_all(scratch);
  return floor;
}

/// Reads the scene's files once: the program finds them in the system's cache, as the floor does.
void warm_up(const SceneFiles& scene) {
  std::vector<fs::path> files = files_in(scene.folder / "images", "");
  files.push_back(scene.mesh);
  for (const fs::path& file : files) io::read_pieces(file, [](std::string_view) {});
}

}  // namespace

Measured measure(const SceneSize& size, const SceneFiles& scene, const RunOptions& options, const fs::path& results) {
  fs::create_directories(results);
  const fs::path model = results / name_of(size);
  std::vector<Measured> runs;
  warm_up(scene);
  for (int n = 0; n < options.runs; ++n) runs.push_back(run_once(size, scene, options, model));
  std::sort(runs.begin(), runs.end(), [](const Measured& a, const Measured& b) { return a.wall_s < b.wall_s; });
  Measured median = runs[runs.size() / 2];
  const Json floor = Json::parse(in_own_process([&] {
    const Floor f = measure_floor(scene, model, model.string() + ".scratch");
    return Json{f.decode_s, f.encode_s, f.megatexels}.dump();
  }));
  median.floor = {floor[0], floor[1], floor[2]};
  if (!options.keep) fs::remove_all(model);
  return median;
}

}  // namespace gpvc::scaling
