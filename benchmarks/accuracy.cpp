// Accuracy of visibility against the oracle: the paper's tables 1 to 6, and one the paper does not have.
//
//   accuracy [-o DIR] [--quick] [--device N]
//
// Prints Markdown; -o writes it to DIR/accuracy.md and every table to a CSV file. Exit status 1 if gpvc with the exact
// correction is wrong about a face without a tie, 77 without a device to draw on.
#include "benchmarks/accuracy.h"

#include <fmt/format.h>

#include <cstdio>
#include <iostream>

#include "benchmarks/command.h"

#include "visibility/device.h"
#include "visibility/visibility.h"

namespace gpvc::accuracy {

TrueScene with_truth(std::string name, Mesh mesh, View view) {
  TrueScene scene{std::move(name), std::move(mesh), std::move(view), {}};
  scene.truth = visibility::oracle_visibility(scene.mesh, scene.view);
  return scene;
}

Score score(visibility::GraphicsDevice& device, const TrueScene& scene, const visibility::VisibilityOptions& options) {
  visibility::VisibilityStage stage(scene.mesh, options, &device);
  const visibility::ViewVisibility found = stage.classify(scene.view, ViewId{0}, nullptr);
  Score score;
  for (std::size_t f = 0; f < found.classes.size(); ++f) {
    const bool visible = found.classes[f] == visibility::FaceClass::full, tied = scene.truth.tied[f] != 0;
    ++(visible ? score.visible : score.occluded);
    score.right += tied || visible == (scene.truth.classes[f] == visibility::FaceClass::full);
    score.wrong_classes += !tied && found.classes[f] != scene.truth.classes[f];
  }
  return score;
}

visibility::VisibilityOptions mode(const std::string& name) { return {visibility::parse_visibility_mode(name)}; }

std::vector<double> epsilons(std::size_t step) {
  std::vector<double> values;
  std::size_t number = 0;
  for (double epsilon = 0.1; epsilon >= 1e-13; epsilon /= 2)
    if (number++ % step == 0) values.push_back(epsilon);
  return values;
}

namespace {

constexpr int kNoDevice = 77;  // CTest counts the test as skipped

int run(const std::filesystem::path& folder, bool quick, int device_number) {
  if (visibility::list_devices().empty()) {
    std::fputs("accuracy: no EGL device has an OpenGL 4.5 context here; nothing measured\n", stderr);
    return kNoDevice;
  }
  if (!folder.empty()) std::filesystem::create_directories(folder);
  visibility::GraphicsDevice device(device_number);
  const Setup setup{device, folder, quick};
  std::string text =
      fmt::format("# Accuracy of visibility\n\nOn {} ({}).\n\n", device.info().renderer, device.info().driver);
  std::cout << text;
  bool perfect = true;
  for (const auto& part : {paper_tables, layer_table}) {
    const Part result = part(setup);
    std::cout << result.markdown << std::flush;
    text += result.markdown;
    perfect = perfect && result.perfect;
  }
  if (!folder.empty()) write_text(folder / "accuracy.md", text);
  if (!perfect) std::fputs("accuracy: gpvc is wrong about a face without a tie\n", stderr);
  return perfect ? 0 : 1;
}

}  // namespace
}  // namespace gpvc::accuracy

int main(int argc, char** argv) {
  CLI::App app("Accuracy of visibility against the oracle");
  std::filesystem::path folder;
  bool quick = false;
  int device = -1;
  app.add_option("-o", folder, "Folder for accuracy.md and the tables as CSV");
  app.add_flag("--quick", quick, "Fewer epsilons and smaller scenes");
  app.add_option("--device", device, "EGL device, as `gpvc --device list` numbers them");
  return gpvc::run_benchmark(app, argc, argv, [&] { return gpvc::accuracy::run(folder, quick, device); });
}
