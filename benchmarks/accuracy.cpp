// Accuracy of visibility against the oracle: the paper's tables 1 to 6, and one the paper does not have.
//
//   accuracy [-o DIR] [--quick] [--device N]
//
// Prints Markdown; DIR gets it as accuracy.md and every table as CSV. Exit status 1 when gpvc with the exact
// correction is wrong about a face without a tie, 77 without a device to draw on.
#include "benchmarks/accuracy.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <stdexcept>

namespace gpvc::accuracy {

TrueScene with_truth(std::string name, Mesh mesh, View view) {
  TrueScene scene{std::move(name), std::move(mesh), std::move(view), {}};
  scene.truth = visibility::oracle_visibility(scene.mesh, scene.view);
  return scene;
}

Score score(visibility::GraphicsDevice& device, const TrueScene& scene, const visibility::VisibilityOptions& options) {
  visibility::VisibilityStage stage(device, scene.mesh, options);
  const visibility::ViewVisibility found = stage.classify(scene.view, ViewId{0});
  Score score;
  for (std::size_t f = 0; f < found.classes.size(); ++f) {
    const bool visible = found.classes[f] == visibility::FaceClass::full, tied = scene.truth.tied[f] != 0;
    ++(visible ? score.visible : score.occluded);
    score.right += tied || visible == (scene.truth.classes[f] == visibility::FaceClass::full);
    score.wrong_classes += !tied && found.classes[f] != scene.truth.classes[f];
  }
  return score;
}

visibility::VisibilityOptions mode(const std::string& name) {
  visibility::VisibilityOptions options;
  visibility::set_visibility_mode(name, options);
  return options;
}

std::vector<double> epsilons(std::size_t step) {
  std::vector<double> values;
  std::size_t number = 0;
  for (double epsilon = 0.1; epsilon >= 1e-13; epsilon /= 2)
    if (number++ % step == 0) values.push_back(epsilon);
  return values;
}

std::string Table::markdown() const {
  std::vector<std::size_t> widths(rows_[0].size(), 3);
  for (const auto& row : rows_)
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  std::string text;
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    for (std::size_t i = 0; i < widths.size(); ++i) text += fmt::format("| {:{}} ", rows_[r][i], widths[i]);
    text += "|\n";
    if (r > 0) continue;
    for (const std::size_t width : widths) text += fmt::format("|{:-<{}}", "", width + 2);
    text += "|\n";
  }
  return text;
}

void Table::write_csv(const std::filesystem::path& file) const {
  std::ofstream out(file);
  for (const auto& row : rows_)
    for (std::size_t i = 0; i < row.size(); ++i) out << row[i] << (i + 1 < row.size() ? "," : "\n");
  out.flush();
  if (!out) throw std::runtime_error(file.string() + ": cannot be written");
}

}  // namespace gpvc::accuracy

namespace {

constexpr int kNoDevice = 77;  // what CTest takes for a skipped test

struct Arguments {
  std::filesystem::path folder;
  bool quick = false;
  int device = -1;
};

Arguments parse(int argc, char** argv) {
  Arguments arguments;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const auto value = [&] {
      if (i + 1 == argc) throw std::invalid_argument(word + " lacks its value");
      return std::string(argv[++i]);
    };
    if (word == "-o")
      arguments.folder = value();
    else if (word == "--device")
      arguments.device = std::stoi(value());
    else if (word == "--quick")
      arguments.quick = true;
    else
      throw std::invalid_argument("'" + word + "' is unknown; usage: accuracy [-o DIR] [--quick] [--device N]");
  }
  return arguments;
}

}  // namespace

int main(int argc, char** argv) {
  using namespace gpvc;
  try {
    const Arguments arguments = parse(argc, argv);
    if (visibility::list_devices().empty()) {
      std::fputs("accuracy: no EGL device makes an OpenGL 4.5 context here; nothing measured\n", stderr);
      return kNoDevice;
    }
    if (!arguments.folder.empty()) std::filesystem::create_directories(arguments.folder);
    visibility::GraphicsDevice device(arguments.device);
    const accuracy::Setup setup{device, arguments.folder, arguments.quick};
    std::string text =
        fmt::format("# Accuracy of visibility\n\nOn {} ({}).\n\n", device.info().renderer, device.info().driver);
    bool perfect = true;
    std::cout << text;
    for (const auto& part : {accuracy::paper_tables, accuracy::layer_table}) {
      const accuracy::Part result = part(setup);
      std::cout << result.markdown << std::flush;
      text += result.markdown;
      perfect = perfect && result.perfect;
    }
    if (!arguments.folder.empty()) {
      std::ofstream out(arguments.folder / "accuracy.md");
      out << text << std::flush;
      if (!out) throw std::runtime_error((arguments.folder / "accuracy.md").string() + ": cannot be written");
    }
    if (!perfect) std::fputs("accuracy: gpvc is wrong about a face without a tie\n", stderr);
    return perfect ? 0 : 1;
  } catch (const std::invalid_argument& e) {
    std::fprintf(stderr, "accuracy: %s\n", e.what());
    return 2;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "accuracy: %s\n", e.what());
    return 1;
  }
}
