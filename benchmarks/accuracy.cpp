// Accuracy of visibility against the oracle: the paper's tables 1 to 6 and figure 15, and a table that it does not have.
//
//   accuracy [-o DIR] [--quick] [--device N]
//
// Prints Markdown; -o writes it to DIR/accuracy.md, every table to a CSV file, and figure 15 as pictures. Exit status 1 if
// gpvc with the exact correction is wrong about a face without a tie, or if figure 15 does not show its effect; 77 without
// a device to draw on.
#include "benchmarks/accuracy.h"

#include <fmt/format.h>

#include <cstdio>
#include <iostream>

#include "benchmarks/command.h"
#include "io/images.h"
#include "visibility/device.h"
#include "visibility/visibility.h"

namespace gpvc::accuracy {

TrueScene with_truth(std::string name, Mesh mesh, View view) {
  TrueScene scene{std::move(name), std::move(mesh), std::move(view), {}};
  scene.truth = visibility::oracle_visibility(scene.mesh, scene.view);
  return scene;
}

namespace {

visibility::ViewVisibility seen(visibility::GraphicsDevice& device, const TrueScene& scene,
                                const visibility::VisibilityOptions& options) {
  visibility::VisibilityStage stage(scene.mesh, options, &device);
  return stage.classify(scene.view, ViewId{0}, nullptr);
}

}  // namespace

visibility::Ivm drawn(visibility::GraphicsDevice& device, const TrueScene& scene,
                      const visibility::VisibilityOptions& options) {
  return seen(device, scene, options).ivm;
}

void write_layers(const std::filesystem::path& file, const visibility::Ivm& ivm, bool (*is_upper)(std::size_t face)) {
  Image picture{ivm.width, ivm.height, 3, std::vector<std::uint8_t>(3 * ivm.faces.size(), 255)};
  for (std::size_t i = 0; i < ivm.faces.size(); ++i) {
    if (ivm.faces[i] == kNoFace) continue;
    const std::size_t face = index(ivm.faces[i]), shade = face * 37 % 48;
    const bool upper = is_upper(face);
    const std::size_t color[] = {(upper ? 200 : 30) + shade, 110 + shade, (upper ? 40 : 170) + shade};
    for (std::size_t c = 0; c < 3; ++c) picture.pixels[3 * i + c] = static_cast<std::uint8_t>(color[c]);
  }
  io::write_image(file, picture, io::ImageFormat::png, 0);
}

Score score(visibility::GraphicsDevice& device, const TrueScene& scene, const visibility::VisibilityOptions& options) {
  const visibility::ViewVisibility found = seen(device, scene, options);
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
  bool as_expected = true;
  for (const auto& part : {paper_tables, depth_table, layer_table}) {
    const Part result = part(setup);
    std::cout << result.markdown << std::flush;
    text += result.markdown;
    as_expected = as_expected && result.as_expected;
  }
  if (!folder.empty()) write_text(folder / "accuracy.md", text);
  if (!as_expected)
    std::fputs("accuracy: gpvc is wrong about a face without a tie, or figure 15 does not show its effect\n", stderr);
  return as_expected ? 0 : 1;
}

}  // namespace
}  // namespace gpvc::accuracy

int main(int argc, char** argv) {
  CLI::App app("Accuracy of visibility against the oracle");
  std::filesystem::path folder;
  bool quick = false;
  int device = -1;
  app.add_option("-o", folder, "Folder for accuracy.md, the tables as CSV and pictures");
  app.add_flag("--quick", quick, "Fewer epsilons and smaller scenes");
  app.add_option("--device", device, "EGL device, as `gpvc --device list` numbers them");
  return gpvc::run_benchmark(app, argc, argv, [&] { return gpvc::accuracy::run(folder, quick, device); });
}
