// Bakes photos into a texture and renders it from the photos' own cameras: the photos must come back.
#include <gtest/gtest.h>

#include "app/pipeline/render_model.h"
#include "tests/atlas/atlas_scene.h"

namespace gpvc::atlas {
namespace {

/// Waves with periods above a metre, which is 40 px in the photos.
Color waves(double x, double y) {
  return {static_cast<float>(128 + 70 * std::sin(2 * x) * std::cos(1.7 * y)),
          static_cast<float>(120 + 60 * std::cos(3.3 * x + y)), static_cast<float>(90 + 6 * x + 4 * y)};
}

/// Two cameras, the second slightly turned, which share the faces in a chequered pattern.
void two_views(AtlasScene& s, const Distortion& distortion) {
  s.add_plane(12, 9, 1.0);
  for (int v = 0; v < 2; ++v) {
    View& view = s.add_view(5.2 + 1.3 * v, 4.3, 10, 640, 480, 400);
    if (v == 1) {
      const double c = std::cos(0.2), n = std::sin(0.2);
      view.pose.rotation = {c, 0, -n, 0, -1, 0, -n, 0, -c};
      view.pose.centre.x += 2.0;
    }
    view.camera.distortion = distortion;
    limit_distortion(view.camera);
    s.photograph(static_cast<std::size_t>(v), waves);
  }
  for (std::size_t f = 0; f < s.labels.size(); ++f) {
    const WorldPoint p = point_at(s.mesh, f, 1.0 / 3, 1.0 / 3);
    s.labels[f] = ViewId{(int(p.x / 3) + int(p.y / 3)) % 2 ? 1u : 0u};
  }
}

/// PSNR of the rendered texture against the view of an ideal pinhole camera, without silhouettes and two pixels beside
/// them.
double psnr(const AtlasScene& s, const TextureAtlas& atlas, std::size_t v) {
  View view = s.scene.views[v];
  view.camera.distortion = {};
  const pipeline::RenderResult drawn =
      pipeline::render_model(atlas.model, atlas.pages, view.camera, view.pose, {.cull_back_faces = true});
  const auto covered = [&](int x, int y) {
    return x >= 0 && y >= 0 && x < drawn.image.width && y < drawn.image.height &&
           drawn.textured[static_cast<std::size_t>(y) * static_cast<std::size_t>(drawn.image.width) +
                          static_cast<std::size_t>(x)] != 0;
  };
  double squares = 0;
  std::size_t count = 0;
  for (int y = 0; y < drawn.image.height; ++y) {
    for (int x = 0; x < drawn.image.width; ++x) {
      bool inner = true;
      for (int j = -2; j <= 2 && inner; ++j)
        for (int i = -2; i <= 2 && inner; ++i) inner = covered(x + i, y + j);
      if (!inner) continue;
      const WorldPoint w = AtlasScene::on_ground(view, {x + 0.5, y + 0.5});
      const Color d = load(drawn.image.at(x, y)) - waves(w.x, w.y);
      squares += double(d.r * d.r + d.g * d.g + d.b * d.b) / 3;
      ++count;
    }
  }
  EXPECT_GT(count, 100000u);
  return 10 * std::log10(255 * 255 / (squares / static_cast<double>(count)));
}

void expect_round_trip(const Distortion& distortion, double texel_size) {
  AtlasScene s;
  two_views(s, distortion);
  AtlasOptions options;
  options.seams = SeamLeveling::none;
  options.texel_size = texel_size;
  const TextureAtlas atlas = s.build(options);
  for (std::size_t v = 0; v < 2; ++v) EXPECT_GE(psnr(s, atlas, v), 40) << "view " << v;
}

TEST(AtlasRender, PinholePhotosComeBack) { expect_round_trip({}, 0); }

TEST(AtlasRender, DistortedPhotosComeBackUndistorted) { expect_round_trip({-0.12, 0.03, 0.001, -0.0015, 0.002}, 0); }

/// Texels have twice the edge of a pixel. The waves are smooth enough to survive that.
TEST(AtlasRender, ReducedTexturesComeBackSmoother) { expect_round_trip({-0.12, 0.03, 0, 0, 0}, 0.05); }

}  // namespace
}  // namespace gpvc::atlas
