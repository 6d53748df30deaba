// Tables 7 to 9 of the paper: what GPVC, shadow maps and rays cost on the same views. `efficiency` makes a mesh of
// 611,618 faces and 43 views of 12 megapixels; `efficiency SCENE MESH` takes a real one. Exit code 1 when HIVERS and
// dense sampling disagree on any face.
#include "efficiency.h"

#include <fmt/format.h>
#include <tbb/info.h>

#include <charconv>
#include <cstdio>
#include <exception>
#include <stdexcept>

namespace gpvc::efficiency {
namespace {

constexpr const char* kUsage =
    "usage: efficiency [SCENE MESH] [--images DIR] [-o DIR] [--views N] [--modes LIST] [--device N]\n"
    "  -o DIR        also write table7.csv, table8.csv and table9.csv there\n"
    "  --views N     only N views, spread over all\n"
    "  --modes LIST  separated by commas: gpvc visibility modes, each with /off, /paper or /exact, "
    "/cpu or\n"
    "                /gpu, /opengl or /native appended where wanted; ratios are against the first\n";

struct Arguments {
  std::vector<std::string> files;
  std::filesystem::path images, folder;
  std::size_t views = 0;
  int device = -1;
  std::string modes;
};

std::size_t whole_number(const std::string& option, const std::string& word) {
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
  if (error != std::errc() || end != word.data() + word.size())
    throw std::invalid_argument(option + ": '" + word + "' is not a whole number");
  return number;
}

Arguments parse(int argc, char** argv) {
  Arguments arguments;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (!word.starts_with("-")) {
      arguments.files.push_back(word);
      continue;
    }
    if (i + 1 >= argc) throw std::invalid_argument(word + " needs a value\n" + kUsage);
    const std::string value = argv[++i];
    if (word == "--images") {
      arguments.images = value;
    } else if (word == "-o") {
      arguments.folder = value;
    } else if (word == "--views") {
      arguments.views = whole_number(word, value);
    } else if (word == "--device") {
      arguments.device = static_cast<int>(whole_number(word, value));
    } else if (word == "--modes") {
      arguments.modes = value;
    } else {
      throw std::invalid_argument(word + " is unknown\n" + kUsage);
    }
  }
  if (!arguments.files.empty() && arguments.files.size() != 2) throw std::invalid_argument(kUsage);
  return arguments;
}

std::vector<Row> rows_of(const std::string& list) {
  std::vector<Row> rows;
  for (std::size_t at = 0; at <= list.size();) {
    const std::size_t comma = std::min(list.find(',', at), list.size());
    rows.push_back(parse_row(list.substr(at, comma - at)));
    at = comma + 1;
  }
  return rows;
}

/// Biases that suit a scene some hundred metres away. Shaders on a software renderer run where the CPU classifier does,
/// and slower.
std::string usual_modes(bool software) {
  std::string list = software ? "gpvc,gpvc/opengl," : "gpvc,gpvc/native,";
  list += "gpvc:ves,gpvc:dense,gpvc/paper/cpu,gpvc:ves/paper/cpu,gpvc:dense/paper/cpu,";
  if (!software) list += "gpvc/exact/gpu,gpvc/exact/cpu,gpvc/paper/gpu,gpvc:ves/paper/gpu,gpvc:dense/paper/gpu,";
  return list + "shadow-map:spc:0.001,shadow-map:apc:1e-12,ray:sparse:0.01,ray:dense:0.01";
}

BenchScene scene_of(const Arguments& arguments) {
  if (arguments.files.empty()) return generated_scene();
  io::SceneOptions options;
  if (!arguments.images.empty()) options.images_dir = arguments.images;
  return {arguments.files[0], io::read_mesh(arguments.files[1]), io::read_scene(arguments.files[0], options).views};
}

void keep(std::vector<View>& views, std::size_t wanted) {
  if (wanted == 0 || wanted >= views.size()) return;
  std::vector<View> kept;
  for (std::size_t i = 0; i < wanted; ++i) kept.push_back(views[i * views.size() / wanted]);
  views = kept;
}

int run(const Arguments& arguments) {
  visibility::GraphicsDevice device(arguments.device);
  BenchScene scene = scene_of(arguments);
  keep(scene.views, arguments.views);
  if (!arguments.folder.empty()) std::filesystem::create_directories(arguments.folder);
  double megapixels = 0;
  for (const View& view : scene.views) megapixels += 1e-6 * view.camera.width * view.camera.height;
  fmt::print("{}: {} faces, {} views of {:.1f} megapixels on average\n{} ({}), {} threads\n", scene.name,
             scene.mesh.faces.size(), scene.views.size(), megapixels / static_cast<double>(scene.views.size()),
             device.info().renderer, device.info().driver, tbb::info::default_concurrency());
  std::size_t differing = 0;
  const std::vector<Row> rows =
      rows_of(arguments.modes.empty() ? usual_modes(device.info().software) : arguments.modes);
  const std::vector<Measured> measured = measure(device, scene, rows, differing);
  print_tables(scene, measured, arguments.folder);
  fmt::print(
      "\nTime consumption: all in, wall, start included: compiling shaders, making buffers. Shaders and "
      "claims\n"
      "are parts of classification: what compute shaders take, and deciding what they leave open on the CPU\n"
      "(exact). CPU time: of all threads, the software renderer's included. Sampling count: look-ups until "
      "a\n"
      "face is known to be fully visible or not.\n"
      "Rows other than GPVC do without the IVM, which texturing needs from them as well. Faces whose class\n"
      "under HIVERS differs from dense sampling's: {}\n",
      differing);
  return differing == 0 ? 0 : 1;
}

}  // namespace
}  // namespace gpvc::efficiency

int main(int argc, char** argv) {
  try {
    return gpvc::efficiency::run(gpvc::efficiency::parse(argc, argv));
  } catch (const std::invalid_argument& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
