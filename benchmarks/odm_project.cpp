// Lays out a scene as OpenDroneMap leaves it before it textures: undistorted TIFF photos and NVM files that name them relative to
// themselves, masks, a full mesh and a 2.5D one, z up, and a second band. See opendm/types.py, opensfm's export of NVM and
// stages/mvstex.py of github.com/OpenDroneMap/ODM.
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>
#include <meshoptimizer.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "app/synth/synth_scene.h"
#include "benchmarks/command.h"
#include "io/images.h"
#include "io/mesh.h"
#include "io/photos.h"
#include "io/scene_files.h"

namespace gpvc {
namespace {

namespace fs = std::filesystem;

struct Arguments {
  fs::path scene, mesh, project;
  std::optional<fs::path> images;
  std::size_t faces = 60000;  ///< of the 2.5D mesh
};

/// Takes the scene's up to z: the mean normal of the mesh, which is away from the ground where most of it is seen from above.
struct Frame {
  Eigen::Matrix3d rotation;
  Eigen::Vector3d origin;
  WorldPoint point(const WorldPoint& p) const {
    const Eigen::Vector3d moved = rotation * (Eigen::Vector3d(p.x, p.y, p.z) - origin);
    return {moved.x(), moved.y(), moved.z()};
  }
};

Frame frame_of(const Mesh& mesh, const Scene& scene) {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero(), cameras = Eigen::Vector3d::Zero();
  const auto vector = [](const WorldPoint& p) { return Eigen::Vector3d(p.x, p.y, p.z); };
  for (const WorldPoint& p : mesh.positions) middle += vector(p) / static_cast<double>(mesh.positions.size());
  for (const View& view : scene.views) cameras += vector(view.pose.centre) / static_cast<double>(scene.views.size());
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const WorldPoint& p : mesh.positions) scatter += (vector(p) - middle) * (vector(p) - middle).transpose();
  Eigen::Vector3d up = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter).eigenvectors().col(0);
  if (up.dot(cameras - middle) < 0) up = -up;
  return {Eigen::Quaterniond::FromTwoVectors(up, Eigen::Vector3d::UnitZ()).toRotationMatrix(), middle};
}

void write_tiff(const fs::path& file, const Image& image) {
  const auto out = OIIO::ImageOutput::create(file.string());
  OIIO::ImageSpec spec(image.width, image.height, image.channels, OIIO::TypeDesc::UINT8);
  spec.attribute("compression", "lzw");
  if (!out || !out->open(file.string(), spec) || !out->write_image(OIIO::TypeDesc::UINT8, image.pixels.data()) ||
      !out->close())
    throw std::runtime_error(file.string() + " cannot be written");
}

/// A band as of a camera for near infrared: one channel, 16 bits, as bright as green is more than red.
void write_second_band(const fs::path& file, const Image& photo) {
  std::vector<std::uint16_t> values;
  values.reserve(photo.pixels.size() / 3);
  for (std::size_t i = 0; i < photo.pixels.size(); i += 3)
    values.push_back(
        static_cast<std::uint16_t>(std::clamp(200 * photo.pixels[i + 1] - 100 * photo.pixels[i] + 8000, 0, 65535)));
  const auto out = OIIO::ImageOutput::create(file.string());
  const OIIO::ImageSpec spec(photo.width, photo.height, 1, OIIO::TypeDesc::UINT16);
  if (!out || !out->open(file.string(), spec) || !out->write_image(OIIO::TypeDesc::UINT16, values.data()) ||
      !out->close())
    throw std::runtime_error(file.string() + " cannot be written");
}

/// The highest places of the mesh above a grid, as triangles, simplified to some number.
Mesh heights_mesh(const Mesh& mesh, std::size_t faces) {
  constexpr int kCells = 700;  // along the longer side
  constexpr double kNone = -std::numeric_limits<double>::infinity();
  WorldPoint low = mesh.positions[0], high = low;
  for (const WorldPoint& p : mesh.positions) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), 0};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), 0};
  }
  const double cell = std::max(high.x - low.x, high.y - low.y) / kCells;
  const int columns = static_cast<int>((high.x - low.x) / cell) + 1,
            rows = static_cast<int>((high.y - low.y) / cell) + 1;
  std::vector<double> heights(pixel_index(0, rows, columns), kNone);
  for (const WorldPoint& p : mesh.positions) {
    double& height =
        heights[pixel_index(static_cast<int>((p.x - low.x) / cell), static_cast<int>((p.y - low.y) / cell), columns)];
    height = std::max(height, p.z);
  }
  // Cells without a vertex take the mean of those beside them, from the border of what is known inwards.
  for (bool any = true; any;) {
    any = false;
    std::vector<double> next = heights;
    for (int y = 0; y < rows; ++y)
      for (int x = 0; x < columns; ++x) {
        if (heights[pixel_index(x, y, columns)] != kNone) continue;
        double sum = 0;
        int count = 0;
        for (int v = std::max(0, y - 1); v <= std::min(rows - 1, y + 1); ++v)
          for (int u = std::max(0, x - 1); u <= std::min(columns - 1, x + 1); ++u)
            if (const double h = heights[pixel_index(u, v, columns)]; h != kNone) {
              sum += h;
              ++count;
            }
        if (count > 0) next[pixel_index(x, y, columns)] = sum / count;
        any = any || count > 0;
      }
    heights = std::move(next);
  }
  std::vector<float> positions;
  std::vector<unsigned int> indices;
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x) {
      const auto at = static_cast<unsigned int>(pixel_index(x, y, columns)),
                 below = at + static_cast<unsigned int>(columns);
      for (const double value : {low.x + (x + 0.5) * cell, low.y + (y + 0.5) * cell, heights[at]})
        positions.push_back(static_cast<float>(value));
      if (x + 1 < columns && y + 1 < rows)
        for (const unsigned int corner : {at, at + 1, below + 1, at, below + 1, below}) indices.push_back(corner);
    }
  std::vector<unsigned int> kept(indices.size());
  kept.resize(meshopt_simplify(kept.data(), indices.data(), indices.size(), positions.data(), positions.size() / 3,
                               3 * sizeof(float), 3 * faces, 1.0f, 0, nullptr));
  Mesh result;
  for (std::size_t i = 0; i < positions.size(); i += 3)
    result.positions.push_back({double{positions[i]}, double{positions[i + 1]}, double{positions[i + 2]}});
  for (std::size_t i = 0; i < kept.size(); i += 3) result.faces.push_back({kept[i], kept[i + 1], kept[i + 2]});
  return result;
}

int run(const Arguments& arguments) {
  io::SceneOptions reader;
  reader.images_dir = arguments.images;
  Scene scene = io::read_scene(arguments.scene, reader);
  Mesh mesh = io::read_mesh(arguments.mesh);
  const Frame frame = frame_of(mesh, scene);
  for (WorldPoint& p : mesh.positions) p = frame.point(p);
  const fs::path undistorted = arguments.project / "opensfm" / "undistorted",
                 meshing = arguments.project / "odm_meshing";
  for (const fs::path& folder : {undistorted / "images", undistorted / "masks", meshing,
                                 arguments.project / "odm_texturing", arguments.project / "odm_texturing_25d"})
    fs::create_directories(folder);
  io::PhotoCache photos(scene);
  std::vector<fs::path> places, band_places;
  Image mask;
  for (std::size_t v = 0; v < scene.views.size(); ++v) {
    View& view = scene.views[v];
    const Image photo = *photos.photo(ViewId{static_cast<std::uint32_t>(v)});
    if (!view.camera.distortion.is_identity())
      throw std::runtime_error(view.name + " is distorted: expected undistorted photos");
    const std::string name = fs::path(view.name).filename().string();
    places.push_back(fs::path("images") / (name + ".tif"));
    band_places.push_back(fs::path("images") / (name + "_nir.tif"));
    write_tiff(undistorted / places.back(), photo);
    write_second_band(undistorted / band_places.back(), photo);
    if (v == 0) {  // of one photo, whose lower left corner it takes out
      mask = {photo.width, photo.height, 1, std::vector<std::uint8_t>(pixel_index(0, photo.height, photo.width), 255)};
      for (int y = photo.height * 3 / 4; y < photo.height; ++y)
        for (int x = 0; x < photo.width / 4; ++x) *mask.at(x, y) = 0;
      for (const fs::path& place : {places.back(), band_places.back()})
        io::write_image(undistorted / "masks" / (place.filename().string() + ".png"), mask, io::ImageFormat::png, 0);
    }
    const Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> rotation(view.pose.rotation.data());
    const Eigen::Matrix3d turned = rotation * frame.rotation.transpose();
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 3; ++column)
        view.pose.rotation[static_cast<std::size_t>(3 * row + column)] = turned(row, column);
    view.pose.centre = frame.point(view.pose.centre);
  }
  const std::vector<ViewId> all = all_views(scene);
  io::write_scene(io::SceneTarget::nvm, scene, all, band_places, undistorted);
  fs::rename(undistorted / "scene.nvm", undistorted / "reconstruction_nir.nvm");
  io::write_scene(io::SceneTarget::nvm, scene, all, places, undistorted);
  fs::rename(undistorted / "scene.nvm", undistorted / "reconstruction.nvm");
  synth::write_synth_mesh(meshing / "odm_mesh.ply", mesh, {});
  const Mesh heights = heights_mesh(mesh, arguments.faces);
  synth::write_synth_mesh(meshing / "odm_25dmesh.ply", heights, {});
  fmt::print("{}: {} photos, {} and {} faces\n", arguments.project.string(), places.size(), mesh.faces.size(),
             heights.faces.size());
  return 0;
}

}  // namespace
}  // namespace gpvc

int main(int argc, char** argv) {
  CLI::App app("Lays out a scene as OpenDroneMap leaves it before it textures");
  gpvc::Arguments arguments;
  app.add_option("SCENE", arguments.scene, "Cameras and undistorted photos: gpvc convert --undistort")->required();
  app.add_option("MESH", arguments.mesh, "Triangle mesh")->required();
  app.add_option("--images", arguments.images, "Folder of the photos");
  app.add_option("--faces", arguments.faces, "Faces of the 2.5D mesh, about")->capture_default_str();
  app.add_option("-o", arguments.project, "Folder of the project")->required();
  return gpvc::run_benchmark(app, argc, argv, [&] { return gpvc::run(arguments); });
}
