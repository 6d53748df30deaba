#include "app/evaluate/truth.h"

#include <fmt/format.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "io/mesh.h"
#include "io/npy.h"
#include "io/paths.h"
#include "visibility/oracle.h"

namespace gpvc::evaluate {
namespace {

namespace fs = std::filesystem;

// Products with an odd number permute what 24 bits hold; near numbers land far apart.
constexpr std::uint32_t kSpread = 0x9E3779u, kColors = 1u << 24, kMostSurfaces = 1u << 20;

constexpr std::uint32_t inverse(std::uint32_t odd) {
  std::uint32_t x = odd;  // right in the lowest 3 bits; each step doubles them (Newton)
  for (int i = 0; i < 4; ++i) x *= 2 - odd * x;
  return x % kColors;
}

constexpr std::uint32_t number_of(std::uint32_t code) { return code * inverse(kSpread) % kColors; }
static_assert(number_of(5u * kSpread % kColors) == 5);
static_assert(number_of(0xFFFFFF) > kMostSurfaces, "white means mixed");

nlohmann::json read_json(const fs::path& file) {
  io::refuse_special_file(file);
  std::ifstream in(file);
  if (!in) throw InputError(file, "", "cannot be read; a synthetic scene's folder is expected", {Cure::synthesize});
  try {
    return nlohmann::json::parse(in);
  } catch (const nlohmann::json::exception& e) {
    throw InputError(file, "", e.what());
  }
}

Image read_picture(const fs::path& file, int width, int height) {
  Image picture = io::read_image(file);
  if (picture.width != width || picture.height != height)
    throw InputError(file, "",
                     fmt::format("{} x {}, but the photo is {} x {}", picture.width, picture.height, width, height));
  return picture;
}

}  // namespace

std::array<std::uint8_t, 3> id_color(std::uint32_t surface) {
  if (surface == synth::kMixedSurfaces) return {255, 255, 255};
  if (surface == synth::kNoSurface) return {0, 0, 0};
  const std::uint32_t code = (surface + 1) * kSpread % kColors;
  return {static_cast<std::uint8_t>(code >> 16), static_cast<std::uint8_t>(code >> 8), static_cast<std::uint8_t>(code)};
}

std::uint32_t surface_of_color(const std::uint8_t* rgb, std::size_t surfaces) {
  const std::uint32_t code = std::uint32_t{rgb[0]} << 16 | std::uint32_t{rgb[1]} << 8 | rgb[2];
  if (code == 0) return synth::kNoSurface;
  const std::uint32_t number = number_of(code);
  return number - 1 < surfaces ? number - 1 : synth::kMixedSurfaces;
}

Truth read_truth(const fs::path& dir) {
  Truth truth;
  truth.dir = dir;
  const fs::path file = dir / "truth.json";
  const nlohmann::json json = read_json(file);
  try {
    truth.surfaces = json.at("surfaces").get<std::size_t>();
    truth.all_surfaces = truth.surfaces + json.at("moving_surfaces").get<std::size_t>();
    truth.least_gain = json.at("least_gain").get<double>();
    truth.most_gain = json.at("most_gain").get<double>();
    for (const auto& [name, exposure] : json.at("photos").items())
      truth.exposures[name] = {exposure.at("gain").get<std::array<double, 3>>(),
                               exposure.at("vignetting").get<double>()};
  } catch (const nlohmann::json::exception& e) {
    throw InputError(file, "", e.what());
  }
  if (truth.all_surfaces > kMostSurfaces) throw InputError(file, "", "more than 2^20 surfaces");
  truth.unmodelled = fs::is_directory(dir / "unmodelled");
  const fs::path exact = dir / "true_mesh.ply";
  truth.mesh = io::read_mesh(fs::exists(exact) ? exact : dir / "mesh.ply");
  truth.face_surface = io::read_npy<std::uint32_t>(dir / "surfaces.npy").values;
  if (truth.face_surface.size() != truth.mesh.faces.size())
    throw InputError(dir / "surfaces.npy", "",
                     fmt::format("{} surfaces for {} faces", truth.face_surface.size(), truth.mesh.faces.size()));
  for (const std::uint32_t surface : truth.face_surface)
    if (surface >= truth.surfaces)
      throw InputError(dir / "surfaces.npy", "", fmt::format("there is no surface {}", surface));
  return truth;
}

std::vector<std::uint32_t> read_id_picture(const Truth& truth, const std::string& view, int width, int height) {
  const Image picture = read_picture(truth.dir / "ids" / (view + ".png"), width, height);
  std::vector<std::uint32_t> surfaces(picture.pixels.size() / 3);
  for (std::size_t i = 0; i < surfaces.size(); ++i)
    surfaces[i] = surface_of_color(picture.pixels.data() + 3 * i, truth.all_surfaces);
  return surfaces;
}

Image read_unmodelled_picture(const Truth& truth, const std::string& view, int width, int height) {
  return read_picture(truth.dir / "unmodelled" / (view + ".png"), width, height);
}

std::vector<visibility::FaceClass> best_classes(const Mesh& mesh, const Scene& scene, std::span<const ViewId> used,
                                                const Progress& progress) {
  const auto rank = [](visibility::FaceClass c) {
    return c == visibility::FaceClass::full ? 2 : c == visibility::FaceClass::partial ? 1 : 0;
  };
  std::vector<visibility::FaceClass> best(mesh.faces.size(), visibility::FaceClass::hidden);
  for (std::size_t n = 0; n < used.size(); ++n) {
    progress(n, used.size());
    const visibility::OracleView view = visibility::oracle_visibility(mesh, scene.views[index(used[n])]);
    for (std::size_t f = 0; f < best.size(); ++f)
      if (rank(view.classes[f]) > rank(best[f])) best[f] = view.classes[f];
  }
  return best;
}

}  // namespace gpvc::evaluate
