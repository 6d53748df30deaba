// Tables 7 to 9 of the paper: the time of GPVC, shadow maps and rays on the same views. `efficiency` makes a mesh of
// 611,618 faces and 43 views of 12 megapixels; `efficiency SCENE MESH` takes a real one. Exit status 1 if HIVERS and
// dense sampling disagree on any face.
#include "benchmarks/efficiency.h"

#include <fmt/format.h>
#include <tbb/info.h>

#include "benchmarks/command.h"
#include "io/mesh.h"
#include "io/scene_files.h"

#include "visibility/device.h"

namespace gpvc::efficiency {
namespace {

struct Arguments {
  std::string scene, mesh;
  std::filesystem::path images, folder;
  std::size_t views = 0;
  int device = -1;
  std::vector<std::string> modes;
};

/// Biases suit a scene some hundred metres away. On a software renderer the rows with shaders are left out: they run on
/// the same processor as the CPU classifier, only slower.
std::vector<std::string> default_modes(bool software) {
  std::vector<std::string> modes{"gpvc",
                                 software ? "gpvc/opengl" : "gpvc/native",
                                 "gpvc:ves",
                                 "gpvc:dense",
                                 "gpvc/paper/cpu",
                                 "gpvc:ves/paper/cpu",
                                 "gpvc:dense/paper/cpu"};
  if (!software)
    for (const char* mode :
         {"gpvc/exact/gpu", "gpvc/exact/cpu", "gpvc/paper/gpu", "gpvc:ves/paper/gpu", "gpvc:dense/paper/gpu"})
      modes.emplace_back(mode);
  for (const char* mode : {"shadow-map:spc:0.001", "shadow-map:apc:1e-12", "ray:sparse:0.01", "ray:dense:0.01"})
    modes.emplace_back(mode);
  return modes;
}

BenchScene scene_of(const Arguments& arguments) {
  if (arguments.mesh.empty()) return generated_scene();
  io::SceneOptions options;
  if (!arguments.images.empty()) options.images_dir = arguments.images;
  return {arguments.scene, io::read_mesh(arguments.mesh), io::read_scene(arguments.scene, options).views};
}

/// Keeps `wanted` views, spread over all; 0 keeps all.
void thin_out(std::vector<View>& views, std::size_t wanted) {
  if (wanted == 0 || wanted >= views.size()) return;
  std::vector<View> kept;
  for (std::size_t i = 0; i < wanted; ++i) kept.push_back(views[i * views.size() / wanted]);
  views = kept;
}

int run(const Arguments& arguments) {
  visibility::GraphicsDevice device(arguments.device);
  BenchScene scene = scene_of(arguments);
  thin_out(scene.views, arguments.views);
  if (!arguments.folder.empty()) std::filesystem::create_directories(arguments.folder);
  double megapixels = 0;
  for (const View& view : scene.views) megapixels += 1e-6 * view.camera.width * view.camera.height;
  fmt::print("{}: {} faces, {} views of {:.1f} megapixels on average\n{} ({}), {} threads\n", scene.name,
             scene.mesh.faces.size(), scene.views.size(), megapixels / static_cast<double>(scene.views.size()),
             device.info().renderer, device.info().driver, tbb::info::default_concurrency());
  std::size_t differing = 0;
  std::vector<Row> rows;
  for (const std::string& mode : arguments.modes.empty() ? default_modes(device.info().software) : arguments.modes)
    rows.push_back(parse_row(mode));
  const std::vector<Measured> measured = measure(device, scene, rows, differing);
  print_tables(scene, measured, arguments.folder);
  fmt::print(
      "\nTime consumption: wall time of everything, with the start (compiling shaders, making buffers). Shaders and\n"
      "claims are parts of classification: compute shaders, and deciding on the CPU what they leave open (exact). CPU\n"
      "time: of all threads, with the software renderer's. Sampling count: look-ups until a face is known to be fully\n"
      "visible or not. Rows other than GPVC do without the IVM, which texturing would need from them, too.\n"
      "Faces whose class under HIVERS differs from dense sampling's: {}\n",
      differing);
  return differing == 0 ? 0 : 1;
}

}  // namespace
}  // namespace gpvc::efficiency

int main(int argc, char** argv) {
  CLI::App app("Efficiency of visibility: tables 7 to 9 of the paper");
  gpvc::efficiency::Arguments arguments;
  CLI::Option* scene = app.add_option("SCENE", arguments.scene, "A calibrated scene; without it, one is generated");
  CLI::Option* mesh = app.add_option("MESH", arguments.mesh, "Its mesh");
  scene->needs(mesh);
  app.add_option("--images", arguments.images, "Folder of the photos");
  app.add_option("-o", arguments.folder, "Folder for table7.csv, table8.csv and table9.csv");
  app.add_option("--views", arguments.views, "So many views, spread over all");
  app.add_option("--device", arguments.device, "EGL device, as `gpvc --device list` numbers them");
  app.add_option("--modes", arguments.modes,
                 "Visibility modes, separated by commas; ratios are against the first. /off, /paper or /exact, /cpu or "
                 "/gpu, /opengl or /native may be appended to the gpvc modes")
      ->delimiter(',')
      ->allow_extra_args(false);
  return gpvc::run_benchmark(app, argc, argv, [&] { return gpvc::efficiency::run(arguments); });
}
