// Mistakes of photos.
#include <algorithm>
#include <cstdint>

#include "app/synth/synth_builder.h"
#include "benchmarks/wrong_scenes.h"
#include "io/images.h"
#include "io/vector.h"

namespace gpvc {
namespace {

Image photo_of(const Input& in, std::size_t view) { return io::read_image(in.scene.views[view].photo); }

Image mirrored(Image image) {
  const auto width = static_cast<std::size_t>(image.width), channels = static_cast<std::size_t>(image.channels);
  for (int y = 0; y < image.height; ++y) {
    std::uint8_t* row = image.at(0, y);
    for (std::size_t x = 0; x < width / 2; ++x)
      std::swap_ranges(row + channels * x, row + channels * (x + 1), row + channels * (width - 1 - x));
  }
  return image;
}

OtherPhotos all_mirrored(const Input& in) {
  OtherPhotos photos;
  for (std::size_t v = 0; v < in.scene.views.size(); ++v) photos[v] = mirrored(photo_of(in, v));
  return photos;
}

// --- another day

/// The mesh as a scene of one grey surface: ratios of its renders under two suns tell what light does to a photo.
synth::SynthScene grey(const Mesh& mesh) {
  synth::SynthScene scene;
  scene.mesh = mesh;
  scene.face_surface.assign(mesh.faces.size(), 0);
  synth::Surface surface{synth::Material::paint, {}, {1, 0, 0}, {0, 1, 0}};
  surface.scale = 1e9;  // one colour
  scene.surfaces.push_back(surface);
  return scene;
}

/// Things as large as lorries on every so many of the level faces of one half of the mesh.
synth::SynthScene things_on(const Mesh& mesh) {
  const double size = extent_of(mesh) / 25;
  synth::SynthBuilder builder(size, 1024, 1);
  constexpr std::uint32_t kOneIn = 40;
  double middle = 0;
  for (const WorldPoint& p : mesh.positions) middle += p.x / static_cast<double>(mesh.positions.size());
  for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) {
    const Triangle& t = mesh.faces[f];
    const WorldPoint &p = mesh.positions[t[0]], &q = mesh.positions[t[1]], &r = mesh.positions[t[2]];
    if (unit(cross(q - p, r - p)).z < 0.95 || p.x > middle || synth::synth_hash(f) % kOneIn != 0) continue;
    builder.box(synth::Material::paint, {p}, {-size / 2, -size / 4, 0}, {size / 2, size / 4, size / 3}, false);
  }
  return builder.take();
}

/// Every third photo has the sun elsewhere, and shows things that the others do not.
OtherPhotos of_another_day(const Input& in) {
  const synth::SynthScene scene = grey(in.mesh), things = things_on(in.mesh);
  synth::SynthRenderer renderer(scene);
  synth::Shot later;
  later.towards_sun = unit({-0.7, 0.3, 0.5});
  OtherPhotos photos;
  for (std::size_t v = 0; v < in.scene.views.size(); v += 3) {
    const View& view = in.scene.views[v];
    Image photo = photo_of(in, v);
    const Image before = renderer.photo(view.camera, view.pose).image;
    const synth::SynthPhoto after = renderer.photo(view.camera, view.pose, later, &things);
    for (int y = 0; y < photo.height; ++y)
      for (int x = 0; x < photo.width; ++x) {
        std::uint8_t* out = photo.at(x, y);
        const std::uint8_t *was = before.at(x, y), *is = after.image.at(x, y);
        const bool thing = after.unmodelled[pixel_index(x, y, photo.width)] > 127;
        for (int c = 0; c < 3; ++c)
          out[c] = thing ? is[c] : static_cast<std::uint8_t>(std::min(255, out[c] * is[c] / std::max<int>(1, was[c])));
      }
    photos[v] = std::move(photo);
  }
  return photos;
}

Mistake of_photos(const char* name, std::function<OtherPhotos(const Input&)> photos) {
  Mistake mistake;
  mistake.name = name;
  mistake.keeps_sightings = true;
  mistake.photos = std::move(photos);
  return mistake;
}

}  // namespace

std::vector<Mistake> mistakes_of_photos() {
  return {
      of_photos("one photo mirrored",
                [](const Input& in) {
                  const std::size_t view = in.scene.views.size() / 2;
                  return OtherPhotos{{view, mirrored(photo_of(in, view))}};
                }),
      of_photos("all photos mirrored", all_mirrored),
      of_photos("one photo a copy of another",
                [](const Input& in) {
                  return OtherPhotos{{in.scene.views.size() / 2, photo_of(in, 0)}};
                }),
      of_photos("a third of the photos of another day", of_another_day),
  };
}

}  // namespace gpvc
