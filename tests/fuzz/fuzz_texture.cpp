// Meshes and cameras as another program may hand them over in memory: numbers of all kinds, indices that lead nowhere.
#include <algorithm>
#include <cstring>
#include <random>

#include "app/pipeline/pipeline.h"
#include "fuzz.h"

namespace gpvc::fuzz {
namespace {

/// Takes values off an input; zeros when it has ended.
class Values {
 public:
  Values(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}
  std::uint8_t byte() { return at_ < size_ ? data_[at_++] : 0; }
  /// Mostly small numbers, so that faces, frames and photos meet; now and then eight bytes as they are.
  double number() {
    const std::uint8_t kind = byte();
    if (kind < 255 || byte() < 200) return (kind - 120) / 20.0 + byte() / 5120.0;
    std::uint64_t bits = 0;
    for (int n = 0; n < 8; ++n) bits = bits << 8 | byte();
    double value = 0;
    std::memcpy(&value, &bits, sizeof value);
    return value;
  }
  std::uint32_t index(std::size_t count) {
    const std::uint8_t kind = byte();
    if (kind < 255 || byte() < 200) return count == 0 ? 0 : static_cast<std::uint32_t>(kind % count);
    return static_cast<std::uint32_t>(kind * 0x01010101u);
  }

 private:
  const std::uint8_t* data_;
  std::size_t size_, at_ = 0;
};

/// A rotation about the axis that points down, and now and then no rotation.
std::array<double, 9> rotation(Values& values) {
  std::array<double, 9> r{1, 0, 0, 0, -1, 0, 0, 0, -1};
  const std::uint8_t kind = values.byte();
  if (kind % 4 == 1) r = {0, 1, 0, 1, 0, 0, 0, 0, -1};
  if (kind % 4 == 2) r = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  if (kind >= 252) r[kind % 9] = values.number();
  return r;
}

std::vector<std::string> random_bytes(const std::filesystem::path& /*corpus*/) {
  std::vector<std::string> seeds;
  for (std::uint32_t seed = 0; seed < 12; ++seed) {
    std::mt19937 random(seed);
    std::string& bytes = seeds.emplace_back();
    for (int n = 0; n < 6000; ++n) bytes += static_cast<char>(random());
  }
  return seeds;
}

}  // namespace

GPVC_FUZZ_TARGET(texture, random_bytes) {
  Values values(data, size);
  Mesh mesh;
  mesh.positions.resize(values.byte() % 64u);
  for (WorldPoint& p : mesh.positions) p = {values.number(), values.number(), values.number()};
  mesh.faces.resize(values.byte() % 96u);
  for (Triangle& face : mesh.faces)
    for (std::uint32_t& v : face) v = values.index(mesh.positions.size());
  Scene scene;
  std::vector<io::Picture> pictures;
  scene.views.resize(values.byte() % 4u);
  for (View& view : scene.views) {
    view.name = std::to_string(pictures.size());
    const int width = values.byte() % 64, height = values.byte() % 64;
    view.camera = {
        width, height, 10 * values.number() + 40, 0, values.number() + width / 2.0, values.number() + height / 2.0, {}};
    view.camera.fy = view.camera.fx + values.number();
    if (values.byte() % 2 == 1) view.camera.distortion.k1 = values.number() / 10;
    view.pose = {rotation(values), {values.number(), values.number(), values.number() + 5}};
    Image image{std::max(1, width), std::max(1, height), 3, {}};
    for (int n = 0; n < 3 * image.width * image.height; ++n) image.pixels.push_back(values.byte());
    pictures.push_back({std::move(image), {}});
  }
  pipeline::Settings settings;
  settings.visibility.method = visibility::Gpvc{.drawing = visibility::Drawing::native};
  settings.costs.keep_odd_views = settings.allow_misfit = settings.allow_unseen = values.byte() % 2 == 0;
  settings.atlas.page_size = 256;
  settings.atlas.max_texels = 1 << 20;
  return succeeds_or_fails([&] {
    io::CallbackSource photos(scene, [&](ViewId view) { return pictures[gpvc::index(view)]; });
    pipeline::Observer silent;
    pipeline::texture(scene, mesh, settings, photos, silent);
  });
}

}  // namespace gpvc::fuzz
