// Runs the whole program on generated scenes of growing size: growing numbers of photos, then of faces. Prints time by
// stage, peak memory, and the ratio to the floor, which is measured in the same run: every photo decoded once, every
// texel encoded once, by all threads.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

#include "benchmarks/child.h"
#include "benchmarks/command.h"
#include "benchmarks/pipeline.h"
#include "benchmarks/table.h"

namespace gpvc::scaling {
namespace {

struct Arguments {
  std::filesystem::path folder;
  std::vector<int> photos{10, 25, 50, 100, 200, 400};
  std::size_t at_faces = 2'000'000;
  std::vector<std::size_t> faces{100'000, 1'000'000, 10'000'000};
  int at_photos = 20;
  std::string photo_size = "4000x3000";
  bool nadir = false, quick = false, scenes_only = false;
  RunOptions run;
};

void make_quick(Arguments& arguments) {
  arguments.photos = {5, 10};
  arguments.at_faces = 20'000;
  arguments.faces = {5'000, 20'000};
  arguments.at_photos = 5;
  arguments.photo_size = "600x450";
}

SceneSize photo_size(const std::string& text) {
  SceneSize size;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%dx%d%c", &size.width, &size.height, &rest) != 2 ||
      std::min(size.width, size.height) < 16 || std::max(size.width, size.height) > 20000)
    throw std::invalid_argument(fmt::format("--photo-size: '{}' is not WIDTHxHEIGHT with edges of 16 to 20000", text));
  return size;
}

Table table_of(const Series& series) {
  Table table({"series", "photos", "megapixels", "faces", "megatexels", "wall s", "CPU s", "see s", "choose s",
               "bake s", "write s", "other s", "peak GB", "decode s", "encode s", "floor s", "wall / floor"});
  const auto add = [&](const char* name, const Measured& m) {
    const StageSeconds& s = m.stages;
    std::vector<std::string> cells{name, std::to_string(m.size.photos), fmt::format("{:.4g}", m.megapixels()),
                                   std::to_string(m.faces), fmt::format("{:.3g}", m.floor.megatexels)};
    for (const double v : {m.wall_s, m.cpu_s, s.see, s.choose, s.bake, s.write, s.other, m.peak_gb, m.floor.decode_s,
                           m.floor.encode_s, m.floor.seconds(), m.ratio()})
      cells.push_back(fmt::format("{:.2f}", v));
    table.add(cells);
  };
  for (const Measured& m : series.by_photos) add("photos", m);
  for (const Measured& m : series.by_faces) add("faces", m);
  return table;
}

void write_results(const Series& series, const std::filesystem::path& folder) {
  const Table table = table_of(series);
  write_text(folder / "pipeline.md", table.markdown());
  table.write_csv(folder / "pipeline.csv");
  in_own_process([&] {
    write_plot(series, folder / "pipeline.png");
    return std::string();
  });
}

int run(Arguments arguments) {
  if (arguments.quick) make_quick(arguments);
  SceneSize size = photo_size(arguments.photo_size);
  size.nadir = arguments.nadir;
  if (!arguments.scenes_only && !std::filesystem::is_regular_file(arguments.run.gpvc))
    throw std::invalid_argument(arguments.run.gpvc.string() + ": no such program; --gpvc names it");
  Series series;
  const auto add = [&](std::vector<Measured>& rows, int photos, std::size_t faces) {
    if (photos == 0 || faces == 0) return;
    size.photos = photos;
    size.faces = faces;
    const SceneFiles scene = make_scene(size, arguments.folder / "scenes");
    if (arguments.scenes_only) return;
    rows.push_back(measure(size, scene, arguments.run, arguments.folder / "models"));
    const Measured& m = rows.back();
    fmt::print(stderr, "{}: {:.2f} s, {:.1f} times its floor, {:.2f} GB\n", name_of(size), m.wall_s, m.ratio(),
               m.peak_gb);
    write_results(series, arguments.folder);
  };
  for (const int photos : arguments.photos) add(series.by_photos, photos, arguments.at_faces);
  for (const std::size_t faces : arguments.faces) add(series.by_faces, arguments.at_photos, faces);
  if (!arguments.scenes_only) fmt::print("{}", table_of(series).markdown());
  return 0;
}

}  // namespace
}  // namespace gpvc::scaling

int main(int argc, char** argv) {
  CLI::App app(
      "The whole program on generated scenes of growing size, beside the floor of its files\n"
      "A photo of 12 megapixels takes 4 MB of disk: 400 take 2 GB, all scenes of the defaults 4 GB.\n"
      "To make 50 photos takes about a minute on two cores.");
  gpvc::scaling::Arguments arguments;
  std::error_code none;
  arguments.run.gpvc = std::filesystem::canonical("/proc/self/exe", none).parent_path().parent_path() / "app" / "gpvc";
  app.add_option("-o", arguments.folder,
                 "Folder for pipeline.md, pipeline.csv and pipeline.png; its scenes/ are used again")
      ->required();
  const auto list = [](CLI::Option* option) {
    option->delimiter(',')->allow_extra_args(false)->check(CLI::NonNegativeNumber)->capture_default_str();
  };
  list(app.add_option("--photos", arguments.photos, "Photos of the scenes of the first series; 0: leave it out"));
  app.add_option("--at-faces", arguments.at_faces, "Their faces, about")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  list(app.add_option("--faces", arguments.faces, "Faces of the scenes of the second series, about; 0: leave it out"));
  app.add_option("--at-photos", arguments.at_photos, "Their photos")->check(CLI::PositiveNumber)->capture_default_str();
  app.add_option("--photo-size", arguments.photo_size, "WIDTHxHEIGHT of the photos")->capture_default_str();
  app.add_flag("--nadir", arguments.nadir, "All photos look straight down and overlap by 80 %");
  app.add_option("--memory", arguments.run.memory, "Given to gpvc texture as its --memory");
  app.add_option("--runs", arguments.run.runs, "Runs of each scene, of which the median counts")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--gpvc", arguments.run.gpvc, "The program to measure")->capture_default_str();
  app.add_flag("--keep", arguments.run.keep, "Keep the textured models in models/");
  app.add_flag("--scenes-only", arguments.scenes_only, "Make the scenes and measure nothing");
  app.add_flag("--quick", arguments.quick, "Tiny scenes, in seconds");
  return gpvc::run_benchmark(app, argc, argv, [&] { return gpvc::scaling::run(arguments); });
}
