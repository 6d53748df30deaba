#include "tiny.h"

#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <utility>

#include "io/images.h"

namespace gpvc::fuzz {

namespace fs = std::filesystem;

namespace {

constexpr int kCells = 12, kWidth = 64, kHeight = 48;
constexpr double kEdge = 4, kFocal = 50;

void add_square(double half, double z, bool faces_up, Mesh& mesh) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (const auto& [x, y] : {std::pair{-half, -half}, {half, -half}, {half, half}, {-half, half}})
    mesh.positions.push_back({x, y, z});
  for (Triangle corners : {Triangle{0, 1, 2}, Triangle{0, 2, 3}}) {
    if (!faces_up) std::swap(corners[1], corners[2]);
    for (std::uint32_t& v : corners) v += first;
    mesh.faces.push_back(corners);
  }
}

// A ground, a table that hides a part of it, and below it what nothing shows.
Mesh tiny_mesh() {
  Mesh mesh;
  for (int y = 0; y <= kCells; ++y)
    for (int x = 0; x <= kCells; ++x)
      mesh.positions.push_back({kEdge * x / kCells - kEdge / 2, kEdge * y / kCells - kEdge / 2, 0.1 * (x % 2)});
  for (std::uint32_t y = 0; y < kCells; ++y)
    for (std::uint32_t x = 0; x < kCells; ++x) {
      const std::uint32_t v = y * (kCells + 1) + x;
      mesh.faces.push_back({v, v + 1, v + kCells + 2});
      mesh.faces.push_back({v, v + kCells + 2, v + kCells + 1});
    }
  add_square(0.7, 1, true, mesh);
  add_square(1, -1, false, mesh);
  return mesh;
}

// The ground as the view sees it from above.
Image tiny_photo(const View& view) {
  Image photo{kWidth, kHeight, 3, {}};
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const WorldPoint& eye = view.pose.centre;
      const double u = eye.x + (x + 0.5 - kWidth / 2) / kFocal * eye.z,
                   v = eye.y - (y + 0.5 - kHeight / 2) / kFocal * eye.z;
      for (const double phase : {0.0, 1.0, 2.5})
        photo.pixels.push_back(static_cast<std::uint8_t>(128 + 60 * std::sin(5 * u + phase) + 50 * std::cos(7 * v)));
    }
  return photo;
}

}  // namespace

const Tiny& tiny() {
  static const Tiny kTiny = [] {
    Tiny made;
    made.mesh = tiny_mesh();
    for (const WorldPoint& eye : {WorldPoint{0, 0, 4}, {1.2, 0.3, 4}, {-0.8, -0.6, 3.6}}) {
      View view;
      view.name = std::to_string(made.scene.views.size()) + ".png";
      view.photo = folder() / view.name;
      view.camera.width = kWidth;
      view.camera.height = kHeight;
      view.camera.fx = view.camera.fy = kFocal;
      view.camera.cx = kWidth / 2;
      view.camera.cy = kHeight / 2;
      view.pose = {{1, 0, 0, 0, -1, 0, 0, 0, -1}, eye};
      io::write_image(view.photo, tiny_photo(view), io::ImageFormat::png, 0);
      made.scene.views.push_back(view);
    }
    made.views = checks::all_views(made.scene);
    return made;
  }();
  return kTiny;
}

pipeline::Settings tiny_settings() {
  pipeline::Settings settings;
  settings.visibility.method = visibility::Gpvc{.drawing = visibility::Drawing::native};
  settings.costs.keep_odd_views = settings.allow_misfit = settings.allow_unseen = true;
  settings.atlas.page_size = 256;
  return settings;
}

std::string read(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

namespace {
// The magic number, the key and the hash of a file of io::WorkStore.
constexpr std::size_t kMagic = 8, kHead = kMagic + sizeof(io::WorkKey), kTail = sizeof(io::WorkKey);
}  // namespace

std::string stored(const fs::path& file) {
  const std::string bytes = read(file);
  return bytes.size() < kHead + kTail ? "" : bytes.substr(kHead, bytes.size() - kHead - kTail);
}

void store(const fs::path& file, std::string_view body, const char* list) {
  const std::string bytes = read(file);
  if (bytes.size() < kHead) std::abort();
  io::WorkKey key;
  std::memcpy(&key, bytes.data() + kMagic, sizeof key);
  io::WorkStore(file.parent_path(), list).keep(file.filename(), key, [&](io::WorkStore::Writer& out) {
    out.write(body.data(), body.size());
  });
}

Snapshot::Snapshot(fs::path folder) : folder_(std::move(folder)) {
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder_))
    if (entry.is_regular_file()) files_[entry.path()] = read(entry.path());
}

void Snapshot::restore() const {
  std::vector<fs::path> others;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder_))
    if (entry.is_regular_file() && !files_.contains(entry.path())) others.push_back(entry.path());
  for (const fs::path& file : others) fs::remove(file);
  for (const auto& [file, bytes] : files_) {
    if (read(file) == bytes) continue;
    fs::create_directories(file.parent_path());
    std::ofstream(file, std::ios::binary) << bytes;
  }
}

}  // namespace gpvc::fuzz
