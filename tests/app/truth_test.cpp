// Models whose every texel's origin is known, against the truth of the scene they were made from.
#include "app/evaluate/truth.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "app/cli/options.h"
#include "app/evaluate/texture_islands.h"
#include "app/evaluate/truth_score.h"
#include "tests/support/temporary_folder.h"
#include "visibility/oracle.h"

namespace gpvc {
namespace {

const Progress kSilent = [](std::size_t, std::size_t) {};

/// Points on a square of 100 m whose texels are, at a gain of the whole, their own colours times light(x, y).
template <class Light>
evaluate::TruthLight light_in(const Light& light) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {100, 0, 0}, {0, 100, 0}, {100, 100, 0}};
  mesh.faces = {{0, 1, 2}, {3, 2, 1}};
  evaluate::TruthPoints points;
  std::vector<std::optional<evaluate::Pixel>> texels;
  constexpr int kSteps = 200;
  for (int j = 0; j < kSteps; ++j)
    for (int i = 0; i < kSteps; ++i) {
      const float u = (static_cast<float>(i) + 0.5f) / kSteps, v = (static_cast<float>(j) + 0.5f) / kSteps;
      const bool lower = u + v <= 1;
      points.seen.push_back(lower ? evaluate::FacePoint{0, u, v, 1} : evaluate::FacePoint{1, 1 - u, 1 - v, 1});
      const evaluate::Pixel own{static_cast<float>(60 + i % 40), static_cast<float>(80 + j % 30), 90};
      points.own.emplace_back().add(own);
      evaluate::Pixel texel = own;
      const std::array<float, 3> factor = light(u, v);
      for (std::size_t c = 0; c < 3; ++c) texel[c] *= 1.1f * factor[c];
      texels.emplace_back(texel);
    }
  return evaluate::light_of(mesh, points, texels);
}

TEST(TruthLight, IsOffWhereBrightnessOrTintWander) {
  const evaluate::TruthLight even = light_in([](float, float) { return std::array{1.0f, 1.0f, 1.0f}; });
  EXPECT_EQ(even.places, 400u);
  EXPECT_NEAR(even.brightness_worst, 0, 1e-4);
  EXPECT_NEAR(even.tint_worst, 0, 1e-4);
  // From 0.8 in the west to 1.2 in the east: of twenty squares the first is at 0.81, and 1 / 0.81 is 1.23.
  const evaluate::TruthLight rising = light_in([](float u, float) {
    return std::array{0.8f + 0.4f * u, 0.8f + 0.4f * u, 0.8f + 0.4f * u};
  });
  EXPECT_NEAR(rising.brightness_worst, 0.23, 0.03);
  EXPECT_GT(rising.brightness_95, 0.15);
  EXPECT_NEAR(rising.tint_worst, 0, 1e-3);
  const evaluate::TruthLight red = light_in([](float, float v) {
    return std::array{v > 0.9f ? 1.3f : 1.0f, 1.0f, 1.0f};
  });
  EXPECT_NEAR(red.tint_worst, std::pow(1.3, 2.0 / 3) - 1, 0.01);
  EXPECT_NEAR(red.brightness_worst, std::pow(1.3, 1.0 / 3) - 1, 0.01);
}

TEST(IdColor, NamesItsSurface) {
  for (const std::uint32_t s : {0u, 1u, 2u, 77u, 4095u, 65536u, (1u << 20) - 1}) {
    const auto color = evaluate::id_color(s);
    EXPECT_EQ(evaluate::surface_of_color(color.data(), 1u << 20), s);
    EXPECT_EQ(evaluate::surface_of_color(color.data(), s), synth::kMixedSurfaces) << "a scene of fewer surfaces";
  }
  EXPECT_EQ(evaluate::surface_of_color(evaluate::id_color(synth::kNoSurface).data(), 1u << 20), synth::kNoSurface);
  EXPECT_EQ(evaluate::surface_of_color(evaluate::id_color(synth::kMixedSurfaces).data(), 1u << 20),
            synth::kMixedSurfaces);
}

Mesh quad_mesh() {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0.333333333}, {10, 10, 10}};
  mesh.faces = {{0, 1, 2}, {1, 3, 2}, {2, 3, 4}};
  return mesh;
}

TEST(MatchModel, FindsFacesThatWereDroppedTurnedAndRounded) {
  const Mesh mesh = quad_mesh();
  // Another program's: the last face first and turned, the second left out, each face with vertices of its own, six
  // digits; and a face that is not the mesh's.
  Mesh theirs;
  theirs.positions = {{10, 10, 10}, {0, 1, 0}, {1, 1, 0.333333}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  theirs.faces = {{0, 1, 2}, {3, 4, 5}, {0, 3, 4}};
  io::TexturedModel model;
  model.mesh = &theirs;
  model.face_page.assign(3, 0);
  const evaluate::MatchedModel matched = evaluate::match_model(mesh, model, {}, {});
  EXPECT_EQ(matched.model_face, (std::vector<std::uint32_t>{1, evaluate::kNoModelFace, 0}));
  EXPECT_EQ(matched.corners[0], (std::array<std::uint8_t, 3>{0, 1, 2}));
  EXPECT_EQ(matched.corners[2], (std::array<std::uint8_t, 3>{1, 2, 0}));
  EXPECT_EQ(matched.unmatched_faces, 1u);
}

TEST(MatchModel, AddsTheOffset) {
  const Mesh mesh = quad_mesh();
  Mesh theirs = mesh;
  for (WorldPoint& p : theirs.positions) p.x -= 4096;
  io::TexturedModel model;
  model.mesh = &theirs;
  model.face_page.assign(3, 0);
  EXPECT_EQ(evaluate::match_model(mesh, model, {}, {4096, 0, 0}).model_face, (std::vector<std::uint32_t>{0, 1, 2}));
  EXPECT_EQ(evaluate::match_model(mesh, model, {}, {}).unmatched_faces, 3u);
}

TEST(TextureIslands, EndWhereTextureCoordinatesOrPagesDiffer) {
  // A strip of six faces along which coordinates jump once, a page changes once and one face has no texture.
  Mesh strip;
  for (int i = 0; i < 8; ++i) strip.positions.push_back({i / 2 * 1.0, i % 2 * 1.0, 0});
  io::TexturedModel model;
  for (std::uint32_t f = 0; f < 6; ++f) {
    strip.faces.push_back(f % 2 == 0 ? Triangle{f, f + 2, f + 1} : Triangle{f, f + 1, f + 2});
    for (const std::uint32_t v : strip.faces.back())
      model.texcoords.push_back({static_cast<float>(v) / 16 + (f >= 2 ? 0.5F : 0.0F), v % 2 == 0 ? 0.0F : 0.25F});
    model.face_texcoords.push_back({3 * f, 3 * f + 1, 3 * f + 2});
  }
  model.mesh = &strip;
  model.face_page = {0, 0, 0, 0, 1, io::kNoPage};
  EXPECT_EQ(evaluate::texture_islands(model), 3u);
  model.face_page = {0, 0, 0, 0, 0, 0};
  EXPECT_EQ(evaluate::texture_islands(model), 2u);
}

// A small city, and models of it whose pages are the photos: a face's texture is its projection into one.
class TruthOfACity : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new test::TemporaryFolder;
    cli::SynthOptions options = cli::synth_defaults(cli::SynthKind::city);
    options.faces = 9000;
    options.flight.size_m = 50;
    options.flight.photos = 10;
    options.flight.width = 480;
    options.flight.height = 320;
    options.flight.distorted = false;
    options.out = folder_->path() / "city";
    cli::Console console(cli::Loudness::quiet, {});
    cli::run_synth(options, console);
    scene_ = new Scene(io::read_scene(options.out / "colmap", {}));
    truth_ = new evaluate::Truth(evaluate::read_truth(options.out));
    for (std::uint32_t v = 0; v < scene_->views.size(); ++v) {
      used_->push_back(ViewId{v});
      oracle_->push_back(visibility::oracle_visibility(truth_->mesh, scene_->views[v]));
      pages_->push_back(io::read_image(scene_->views[v].photo));
      ids_->push_back(
          evaluate::read_id_picture(*truth_, scene_->views[v].name, options.flight.width, options.flight.height));
    }
  }
  static void TearDownTestSuite() {
    delete scene_;
    delete truth_;
    delete folder_;
  }

  // Textures face f from view `views[f]`; none for kNoView.
  io::TexturedModel textured(const std::vector<ViewId>& views) const {
    io::TexturedModel model;
    model.mesh = &truth_->mesh;
    for (std::size_t f = 0; f < views.size(); ++f) {
      Triangle corners{};
      model.face_page.push_back(views[f] == kNoView ? io::kNoPage : static_cast<std::uint32_t>(index(views[f])));
      for (std::size_t i = 0; i < 3; ++i) {
        corners[i] = static_cast<std::uint32_t>(model.texcoords.size());
        model.texcoords.emplace_back();
        if (views[f] == kNoView) continue;
        const View& view = scene_->views[index(views[f])];
        const CameraPoint c = camera_from_world(view.pose, truth_->mesh.positions[truth_->mesh.faces[f][i]]);
        const PixelPoint p = pixel_from_camera(view.camera, c);
        model.texcoords.back() = {static_cast<float>(p.x / view.camera.width),
                                  static_cast<float>(p.y / view.camera.height)};
      }
      model.face_texcoords.push_back(corners);
    }
    return model;
  }
  evaluate::TruthScore score(const std::vector<ViewId>& views) const {
    const io::TexturedModel model = textured(views);
    io::PhotoCache photos(*scene_, 0);
    const evaluate::TruthScorer scorer({*truth_, truth_->mesh, *scene_, *used_, photos}, kSilent);
    return scorer.score(evaluate::match_model(truth_->mesh, model, *pages_, {}), kSilent);
  }
  // Where a face lies in a view, in pixels, and whether all of it is in the picture.
  struct Box {
    double x0 = 1e9, y0 = 1e9, x1 = -1e9, y1 = -1e9;
    bool inside = true;
  };
  static Box box(std::size_t f, ViewId v) {
    const View& view = scene_->views[index(v)];
    Box box;
    for (const std::uint32_t corner : truth_->mesh.faces[f]) {
      const CameraPoint c = camera_from_world(view.pose, truth_->mesh.positions[corner]);
      if (c.z <= 0) return {0, 0, 0, 0, false};
      const PixelPoint p = pixel_from_camera(view.camera, c);
      box = {std::min(box.x0, p.x), std::min(box.y0, p.y), std::max(box.x1, p.x), std::max(box.y1, p.y), true};
    }
    box.inside = box.x0 >= 3 && box.y0 >= 3 && box.x1 <= view.camera.width - 3 && box.y1 <= view.camera.height - 3;
    return box;
  }
  // Whether the face's box and 2 px around it show its surface alone.
  static bool alone(std::size_t f, ViewId v) {
    const Box at = box(f, v);
    if (!at.inside) return false;
    for (int y = static_cast<int>(at.y0) - 2; y <= static_cast<int>(at.y1) + 2; ++y)
      for (int x = static_cast<int>(at.x0) - 2; x <= static_cast<int>(at.x1) + 2; ++x)
        if ((*ids_)[index(v)][static_cast<std::size_t>(y * scene_->views[0].camera.width + x)] !=
            truth_->face_surface[f])
          return false;
    return true;
  }
  // The first view that sees a face whole and, by its id picture, well away from other surfaces.
  static std::vector<ViewId> good_views() {
    std::vector<ViewId> views(truth_->mesh.faces.size(), kNoView);
    for (const ViewId v : *used_)
      for (std::size_t f = 0; f < views.size(); ++f)
        if (views[f] == kNoView && (*oracle_)[index(v)].classes[f] == visibility::FaceClass::full && alone(f, v))
          views[f] = v;
    return views;
  }
  static double area(std::size_t f) {
    const Triangle& t = truth_->mesh.faces[f];
    const WorldPoint &a = truth_->mesh.positions[t[0]], &b = truth_->mesh.positions[t[1]],
                     &c = truth_->mesh.positions[t[2]];
    const double ux = b.x - a.x, uy = b.y - a.y, uz = b.z - a.z, vx = c.x - a.x, vy = c.y - a.y, vz = c.z - a.z;
    const double x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx;
    return std::sqrt(x * x + y * y + z * z) / 2;
  }

  static inline test::TemporaryFolder* folder_ = nullptr;
  static inline Scene* scene_ = nullptr;
  static inline evaluate::Truth* truth_ = nullptr;
  static inline std::vector<ViewId>* used_ = new std::vector<ViewId>;
  static inline std::vector<visibility::OracleView>* oracle_ = new std::vector<visibility::OracleView>;
  static inline std::vector<std::vector<std::uint32_t>>* ids_ = new std::vector<std::vector<std::uint32_t>>;
  static inline std::vector<Image>* pages_ = new std::vector<Image>;
};

TEST_F(TruthOfACity, WhatMasksExcludeIsSeenByNobody) {
  const auto samples = [&](const Scene& scene) {
    io::PhotoCache photos(scene, 0);
    const evaluate::TruthScorer scorer({*truth_, truth_->mesh, scene, *used_, photos}, kSilent);
    const io::TexturedModel model = textured(std::vector<ViewId>(truth_->mesh.faces.size(), kNoView));
    return scorer.score(evaluate::match_model(truth_->mesh, model, *pages_, {}), kSilent).samples;
  };
  Scene masked = *scene_;
  Image mask;
  mask.width = masked.views[0].camera.width;
  mask.height = masked.views[0].camera.height;
  mask.pixels.assign(static_cast<std::size_t>(mask.width) * static_cast<std::size_t>(mask.height) * 3, 255);
  std::fill_n(mask.pixels.begin(), mask.pixels.size() / 2, std::uint8_t{0});  // the upper half
  for (View& view : masked.views) {
    view.mask = folder_->path() / "upper.png";
    io::write_image(view.mask, mask, io::ImageFormat::png, 0);
  }
  const std::size_t all = samples(*scene_), lower = samples(masked);
  EXPECT_LT(lower, all);
  EXPECT_GT(lower, 0u);
  std::fill(mask.pixels.begin(), mask.pixels.end(), std::uint8_t{0});
  io::write_image(folder_->path() / "upper.png", mask, io::ImageFormat::png, 0);
  EXPECT_EQ(samples(masked), 0u);
}

TEST_F(TruthOfACity, IdPicturesShowWhatTheOracleSees) {
  // A face of some pixels that the oracle sees whole shows its surface at its middle; samples of the picture are a
  // quarter of a pixel off the centre.
  const View& view = scene_->views[0];
  std::size_t shown = 0;
  for (std::size_t f = 0; f < truth_->mesh.faces.size(); ++f) {
    if ((*oracle_)[0].classes[f] != visibility::FaceClass::full) continue;
    std::array<PixelPoint, 3> at;
    for (std::size_t i = 0; i < 3; ++i)
      at[i] = pixel_from_camera(view.camera,
                                camera_from_world(view.pose, truth_->mesh.positions[truth_->mesh.faces[f][i]]));
    const auto edge = [&](std::size_t i, std::size_t j) { return std::hypot(at[j].x - at[i].x, at[j].y - at[i].y); };
    const double twice_area =
        std::abs((at[1].x - at[0].x) * (at[2].y - at[0].y) - (at[2].x - at[0].x) * (at[1].y - at[0].y));
    if (twice_area / (edge(0, 1) + edge(1, 2) + edge(2, 0)) < 1.5) continue;  // the inscribed circle's radius
    WorldPoint centre;
    for (const std::uint32_t v : truth_->mesh.faces[f]) {
      const WorldPoint& p = truth_->mesh.positions[v];
      centre = {centre.x + p.x / 3, centre.y + p.y / 3, centre.z + p.z / 3};
    }
    const PixelPoint p = pixel_from_camera(view.camera, camera_from_world(view.pose, centre));
    const std::uint32_t id =
        (*ids_)[0][static_cast<std::size_t>(static_cast<int>(p.y) * view.camera.width + static_cast<int>(p.x))];
    if (id == synth::kMixedSurfaces) continue;
    EXPECT_EQ(id, truth_->face_surface[f]) << f;
    ++shown;
  }
  EXPECT_GT(shown, 300u);
}

TEST_F(TruthOfACity, GoodModelHasNothingWrong) {
  const std::vector<ViewId> views = good_views();
  const evaluate::TruthScore result = score(views);
  const auto textured =
      static_cast<std::size_t>(std::count_if(views.begin(), views.end(), [](ViewId v) { return v != kNoView; }));
  EXPECT_EQ(result.textured[0], textured);
  EXPECT_GE(result.faces[0], textured);
  EXPECT_EQ(result.textured[1] + result.textured[2], 0u);
  EXPECT_GT(result.full.textured, 0.5);
  EXPECT_EQ(result.partial.textured, 0);
  EXPECT_GT(result.full.seen_area, 0.5 * result.all.area);
  EXPECT_LT(result.all.wrong, 1e-4);
  EXPECT_LT(result.all.unexplained, 1e-3);
}

// Every fifth face that can be is painted from a photo in which another surface hides it entirely.
TEST_F(TruthOfACity, WrongColorsAreFoundUpToThoseThatCannotBeTold) {
  std::vector<ViewId> views = good_views();
  double spoilt = 0, sound = 0;
  for (std::size_t f = 0; f < views.size(); ++f) {
    if (views[f] == kNoView) continue;
    bool hidden = false;
    for (const ViewId v : *used_) {
      if (f % 5 != 0 || hidden || (*oracle_)[index(v)].classes[f] != visibility::FaceClass::hidden) continue;
      hidden = box(f, v).inside;
      if (hidden) views[f] = v;
    }
    (hidden ? spoilt : sound) += area(f);
  }
  const double share = spoilt / (spoilt + sound);
  ASSERT_GT(share, 0.02);
  const evaluate::TruthScore result = score(views);
  // A face turned away from the camera shows its own surface's other side where nothing else hides it, and colours of
  // some surfaces are alike: two thirds are found at least.
  EXPECT_GT(result.full.wrong + result.full.unexplained, 0.6 * share);
  EXPECT_LT(result.full.wrong, 1.2 * share);
  std::size_t found = 0;
  for (const std::uint32_t f : result.wrong_faces) found += f % 5 == 0;
  EXPECT_GT(static_cast<double>(found), 0.97 * static_cast<double>(result.wrong_faces.size()));
}

// What the photos' pixels say needs no colours: nothing goes unnoticed.
TEST_F(TruthOfACity, OriginsAreToldByThePixelsTheyLieIn) {
  std::vector<ViewId> views = good_views();
  std::vector<std::int32_t> labels(views.size(), -1);
  std::vector<std::uint8_t> tags(views.size(), static_cast<std::uint8_t>(labeling::FaceTag::unseen));
  std::vector<bool> hidden(views.size(), false);
  for (std::size_t f = 0; f < views.size(); ++f) {
    if (views[f] == kNoView) continue;
    for (const ViewId v : *used_) {
      if (f % 5 != 0 || hidden[f] || (*oracle_)[index(v)].classes[f] != visibility::FaceClass::hidden) continue;
      hidden[f] = box(f, v).inside;
      if (hidden[f]) views[f] = v;
    }
    labels[f] = static_cast<std::int32_t>(index(views[f]));
    tags[f] = static_cast<std::uint8_t>(f % 7 == 0 ? labeling::FaceTag::partial : labeling::FaceTag::seen);
  }
  io::PhotoCache photos(*scene_, 0);
  const evaluate::TruthScorer scorer({*truth_, truth_->mesh, *scene_, *used_, photos}, kSilent);
  const evaluate::OriginScore score = scorer.score(evaluate::origins_of_labels(truth_->mesh, *scene_, labels, tags));

  double seen = 0, taken = 0, away = 0;
  for (const evaluate::WrongPoint& p : score.wrong) {
    EXPECT_TRUE(hidden[p.face]) << p.face;
    EXPECT_EQ(p.view, views[p.face]);
    EXPECT_NE(p.surface, truth_->face_surface[p.face]);
    const auto at =
        static_cast<std::size_t>(static_cast<int>(p.at.y) * scene_->views[0].camera.width + static_cast<int>(p.at.x));
    EXPECT_EQ(p.surface, (*ids_)[index(p.view)][at]);
  }
  for (std::size_t f = 0; f < views.size(); ++f) {
    if (tags[f] != static_cast<std::uint8_t>(labeling::FaceTag::seen)) {
      EXPECT_EQ(score.right_area[f], 0.0F) << "nothing is known of it, or it is filled";
      continue;
    }
    seen += area(f);
    if (hidden[f]) away += area(f);
    if (score.right_area[f] > 0 || !hidden[f]) taken += area(f);
  }
  ASSERT_GT(away, 0.02 * seen);
  // Hidden by its own surface, as at the far side of a crown, a face is where the picture says its surface is.
  EXPECT_GT(score.all.wrong, 0.6 * away / seen);
  EXPECT_LT(score.all.wrong, 1.1 * away / seen);
  EXPECT_GT(score.all.unknown, 0.05);
  EXPECT_LT(score.all.photo, 1.0) << "some are filled";
  EXPECT_NEAR(score.all.right, score.all.photo * (1 - score.all.wrong), 1e-9);
  EXPECT_GT(taken, 0.9 * (seen - away));
}

// Faces that no photo sees, painted from one where another surface lies before them.
TEST_F(TruthOfACity, GhostsAreWhatHiddenFacesTakeFromOthers) {
  const std::vector<ViewId> good = good_views();
  const std::vector<visibility::FaceClass> best = evaluate::best_classes(truth_->mesh, *scene_, *used_, kSilent);
  std::vector<std::int32_t> labels(good.size(), -1), painted;
  std::vector<std::uint8_t> tags(good.size(), static_cast<std::uint8_t>(labeling::FaceTag::unseen)), painted_tags;
  for (std::size_t f = 0; f < good.size(); ++f) {
    if (good[f] == kNoView) continue;
    labels[f] = static_cast<std::int32_t>(index(good[f]));
    tags[f] = static_cast<std::uint8_t>(labeling::FaceTag::seen);
  }
  painted = labels;
  painted_tags = tags;
  double area_painted = 0;
  for (std::size_t f = 0; f < good.size(); ++f) {
    if (best[f] != visibility::FaceClass::hidden) continue;
    for (const ViewId v : *used_) {
      if (painted[f] >= 0 || !box(f, v).inside) continue;
      painted[f] = static_cast<std::int32_t>(index(v));
      painted_tags[f] = static_cast<std::uint8_t>(labeling::FaceTag::seen);
      area_painted += area(f);
    }
  }
  io::PhotoCache photos(*scene_, 0);
  const evaluate::TruthScorer scorer({*truth_, truth_->mesh, *scene_, *used_, photos}, kSilent);
  const evaluate::OriginShares clean =
      scorer.score(evaluate::origins_of_labels(truth_->mesh, *scene_, labels, tags)).all;
  const evaluate::OriginScore score =
      scorer.score(evaluate::origins_of_labels(truth_->mesh, *scene_, painted, painted_tags));
  const evaluate::OriginShares& all = score.all;
  EXPECT_GT(clean.hidden_area, 0.1 * clean.seen_area);
  EXPECT_EQ(clean.ghost, 0);
  EXPECT_EQ(clean.hidden_area, all.hidden_area);
  EXPECT_EQ(clean.right, all.right) << "what is seen is the same";
  ASSERT_GT(area_painted, 0.1 * all.seen_area);
  EXPECT_GT(score.none.hidden_photo, 0.5);
  // The rest takes its own surface's near side, as at a crown.
  EXPECT_GT(score.none.ghost, 0.7 * score.none.hidden_photo);
  const double photos_area = all.photo * all.seen_area + all.hidden_photo * all.hidden_area;
  EXPECT_NEAR(all.foreign * photos_area, all.wrong * all.photo * all.seen_area + all.ghost * all.hidden_area,
              1e-9 * photos_area);
  EXPECT_NEAR(all.faithful * (all.seen_area + all.hidden_area),
              all.right * all.seen_area + (1 - all.ghost) * all.hidden_area, 1e-9 * all.seen_area);
  EXPECT_GT(clean.faithful, all.faithful + 0.05);
  double faithful = 0;
  for (const float a : score.faithful_area) faithful += static_cast<double>(a);
  EXPECT_NEAR(faithful, all.faithful * (all.seen_area + all.hidden_area), 1e-4 * all.seen_area);
}

// One photo shows nothing but what the mesh lacks, another half of it in each pixel.
TEST_F(TruthOfACity, UnmodelledObjectsCountByTheirShareOfThePixels) {
  const std::vector<ViewId> good = good_views();
  std::vector<std::int32_t> labels(good.size(), -1);
  std::vector<std::uint8_t> tags(good.size(), static_cast<std::uint8_t>(labeling::FaceTag::unseen));
  std::vector<double> shown(scene_->views.size(), 0);
  double all = 0;
  for (std::size_t f = 0; f < good.size(); ++f) {
    if (good[f] == kNoView) continue;
    labels[f] = static_cast<std::int32_t>(index(good[f]));
    tags[f] = static_cast<std::uint8_t>(labeling::FaceTag::seen);
    shown[index(good[f])] += area(f);
    all += area(f);
  }
  evaluate::Truth truth = *truth_;
  truth.dir = folder_->path() / "unmodelled_truth";
  std::filesystem::create_directories(truth.dir);
  std::filesystem::copy(truth_->dir / "ids", truth.dir / "ids");
  const Camera& camera = scene_->views[0].camera;
  for (std::size_t v = 0; v < scene_->views.size(); ++v) {
    Image share{camera.width, camera.height, 3, {}};
    share.pixels.assign(static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height) * 3,
                        static_cast<std::uint8_t>(v == 0   ? 255
                                                  : v == 1 ? 51
                                                           : 0));
    std::filesystem::create_directories(truth.dir / "unmodelled");
    io::write_image(truth.dir / "unmodelled" / (scene_->views[v].name + ".png"), share, io::ImageFormat::png, 0);
  }
  const auto score = [&](bool known) {
    truth.unmodelled = known;
    io::PhotoCache photos(*scene_, 0);
    const evaluate::TruthScorer scorer({truth, truth.mesh, *scene_, *used_, photos}, kSilent);
    return scorer.score(evaluate::origins_of_labels(truth.mesh, *scene_, labels, tags));
  };
  const evaluate::OriginScore counted = score(true);
  ASSERT_GT(shown[0] + shown[1], 0.05 * all);
  EXPECT_NEAR(counted.all.unmodelled, (shown[0] + 0.2 * shown[1]) / all, 0.02);
  EXPECT_TRUE(evaluate::shares_json(counted.all).contains("unmodelled"));
  EXPECT_EQ(score(false).all.unmodelled, 0);
}

TEST(OriginVerdict, CallsAnEdgeWhatLiesLessThanAPixelFromItsOwnSurface) {
  // Four by four pixels: surface 1 left, 2 right, a mixed one at (1, 3).
  std::vector<std::uint32_t> picture{1, 1, 2, 2, 1, 1, 2, 2, 1, 1, 2, 2, 1, synth::kMixedSurfaces, 2, 2};
  Camera camera;
  camera.width = camera.height = 4;
  camera.fx = camera.fy = 1;
  evaluate::WrongPoint place;
  const auto verdict = [&](double x, double y, std::uint32_t own) {
    return evaluate::origin_verdict(camera, picture, {x, y}, own, place);
  };
  EXPECT_EQ(verdict(1.0, 1.0, 1), evaluate::OriginVerdict::right);
  EXPECT_EQ(verdict(1.6, 1.0, 1), evaluate::OriginVerdict::edge) << "reads a pixel of the other";
  EXPECT_EQ(verdict(2.4, 1.0, 1), evaluate::OriginVerdict::edge) << "lies in the other, beside its own";
  EXPECT_EQ(verdict(2.6, 1.0, 1), evaluate::OriginVerdict::wrong);
  EXPECT_EQ(place.surface, 2u);
  EXPECT_EQ(verdict(1.5, 3.5, 7), evaluate::OriginVerdict::edge) << "a pixel of several surfaces";
  EXPECT_EQ(verdict(0.5, 0.5, 2), evaluate::OriginVerdict::wrong);
  EXPECT_EQ(verdict(9.0, 0.5, 2), evaluate::OriginVerdict::wrong) << "off the photo";
}

}  // namespace
}  // namespace gpvc
