// The pipeline as a program that embeds it calls it: pictures in memory, an observer, single steps, parts of the scene.
#include "app/pipeline/pipeline.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "app/checks/scene_fit.h"
#include "app/pipeline/memory.h"
#include "app/pipeline/steps.h"
#include "app/results/output_folder.h"
#include "io/mesh.h"
#include "io/textured_model.h"
#include "io/vector.h"
#include "tests/app/photographed_city.h"
#include "tests/support/errors.h"
#include "tests/support/temporary_folder.h"

namespace gpvc {
namespace {

// Keeps what it hears, and cancels at the first progress of a stage, if it is told one.
class Listener : public results::Observer {
 public:
  explicit Listener(std::string cancel_in = "") : cancel_in_(std::move(cancel_in)) {}
  void begin(const results::StageInfo& stage) override { begun.push_back(stage.name); }
  void end(const std::string&) override { ended.push_back(begun.back()); }
  void progress(std::size_t done, std::size_t total) override {
    EXPECT_LE(done, total);
    if (begun.back() == cancel_in_) throw Cancelled();
  }
  void figure(const std::string& name, const results::Figure&) override { figures.push_back(name); }

  std::vector<std::string> begun, ended, figures;

 private:
  std::string cancel_in_;
};

using test::City;

class Pipeline : public testing::Test {
 protected:
  static void SetUpTestSuite() { city_ = std::make_unique<City>(); }
  static void TearDownTestSuite() { city_.reset(); }

  static checks::Input input() { return {city_->scene, city_->mesh, city_->views}; }
  static pipeline::TexturedMesh texture(io::PhotoSource& photos, results::Observer& observer) {
    return pipeline::texture(city_->scene, city_->mesh, {}, photos, observer);
  }
  // View selection and what comes before it, each step called alone.
  struct Chosen {
    labeling::FaceGraph graph;
    pipeline::Seen seen;
    labeling::Selection selection;
  };
  Chosen see_and_choose(const pipeline::Settings& settings) {
    Chosen all{pipeline::weighed_graph(city_->mesh, settings.edge_weights, silent_),
               pipeline::see({input(), settings, photos_, silent_}),
               {}};
    all.selection = pipeline::choose(all.seen.candidates.table, all.graph, settings.solver, silent_);
    return all;
  }

  static inline std::unique_ptr<City> city_;
  io::PictureSource photos_{city_->scene, city_->pictures};
  results::Observer silent_;
};

void expect_equal(const pipeline::TexturedMesh& a, const pipeline::TexturedMesh& b) {
  EXPECT_EQ(a.selection.labels, b.selection.labels);
  EXPECT_EQ(a.tags, b.tags);
  ASSERT_EQ(a.atlas.pages.size(), b.atlas.pages.size());
  for (std::size_t n = 0; n < a.atlas.pages.size(); ++n)
    EXPECT_TRUE(a.atlas.pages[n].pixels == b.atlas.pages[n].pixels) << "page " << n;
}

TEST_F(Pipeline, PicturesInMemoryGiveWhatFilesGive) {
  io::PhotoCache files(city_->scene);
  const pipeline::TexturedMesh from_memory = texture(photos_, silent_);
  ASSERT_FALSE(from_memory.atlas.pages.empty());
  expect_equal(from_memory, texture(files, silent_));
}

TEST_F(Pipeline, ObserverHearsTheStagesInOrder) {
  Listener listener;
  texture(photos_, listener);
  EXPECT_EQ(listener.begun, (std::vector<std::string>{"face graph", "see", "choose", "bake"}));
  EXPECT_EQ(listener.ended, listener.begun);
  for (const char* name : {"tags.seen", "patches", "charts"})
    EXPECT_EQ(std::count(listener.figures.begin(), listener.figures.end(), name), 1) << name;
}

TEST_F(Pipeline, ObserverCancelsAnyStageWithProgress) {
  for (const char* stage : {"see", "choose", "bake"}) {
    Listener listener(stage);
    EXPECT_THROW(texture(photos_, listener), Cancelled);
    EXPECT_EQ(listener.begun.back(), stage);
    EXPECT_EQ(listener.ended.size() + 1, listener.begun.size());
  }
}

TEST_F(Pipeline, StepsTogetherGiveTheWhole) {
  const pipeline::Settings settings;
  const Chosen chosen = see_and_choose(settings);
  pipeline::TexturedMesh steps;
  steps.selection = chosen.selection;
  steps.tags = chosen.seen.candidates.tags;
  const atlas::AtlasInput atlas_input =
      pipeline::atlas_input(input(), photos_, chosen.graph, chosen.seen, steps.selection.labels);
  const atlas::AtlasPlan plan = pipeline::plan(atlas_input, settings.atlas, silent_);
  steps.atlas = pipeline::bake(plan, atlas_input, settings.atlas, silent_);
  expect_equal(steps, pipeline::texture({input(), settings, photos_, silent_}));
}

class CountedPhotos final : public io::PhotoSource {
 public:
  explicit CountedPhotos(io::PhotoSource& photos) : photos_(photos) {}
  std::shared_ptr<const Image> photo(ViewId view) override {
    ++fetched;
    return photos_.photo(view);
  }
  std::shared_ptr<const io::PhotoExclusion> exclusion(ViewId view) override { return photos_.exclusion(view); }
  void keep_at_most(std::size_t bytes) override { room.push_back(bytes); }

  std::atomic<std::size_t> fetched = 0;
  std::vector<std::size_t> room;  ///< for photos, each time that it was changed

 private:
  io::PhotoSource& photos_;
};

// Pages that are baked one by one and given away must not differ from pages that are baked together, although partial and
// unseen faces take colours from charts on other pages.
TEST_F(Pipeline, PagesBakedOneByOneEqualPagesBakedTogether) {
  pipeline::Settings settings;
  settings.atlas.page_size = 256;
  const Chosen chosen = see_and_choose(settings);
  const auto [seen, partial, unseen, background] = checks::count_tags(chosen.seen.candidates.tags);
  ASSERT_GT(partial, 0u);
  ASSERT_GT(unseen, 0u);
  CountedPhotos photos(photos_);
  const atlas::AtlasInput from =
      pipeline::atlas_input(input(), photos, chosen.graph, chosen.seen, chosen.selection.labels);
  const atlas::AtlasPlan plan = atlas::plan_atlas(from, settings.atlas);
  const atlas::TextureAtlas whole = atlas::bake_atlas(plan, from, nullptr);
  ASSERT_GT(whole.pages.size(), 2u);
  std::vector<Image> taken;
  std::size_t last = 0;
  const auto forward = [&](std::size_t done, std::size_t total) {
    EXPECT_LE(last, done);
    EXPECT_LE(done, total);
    last = done;
  };
  const auto take = [&](std::size_t number, Image page) {
    EXPECT_TRUE(taken[number].pixels.empty());
    taken[number] = std::move(page);
  };
  // Without coarse photos on disk, with a few of them, and with all.
  const Camera& camera = city_->scene.views[0].camera;
  const std::size_t coarse = pixel_index(0, camera.height, camera.width) * 3 / 4;
  std::vector<std::size_t> fetched;
  for (const std::size_t coarse_bytes : {std::size_t{0}, 3 * coarse, 1000 * coarse}) {
    io::CoarsePhotos with_coarse(photos, city_->scene, testing::TempDir(), coarse_bytes);
    const atlas::AtlasInput of_these =
        pipeline::atlas_input(input(), with_coarse, chosen.graph, chosen.seen, chosen.selection.labels);
    const atlas::BakeOptions one_by_one{
        .take_model = {}, .take_page = take, .page_bytes = 1, .batch_bytes = 1, .scratch_folder = testing::TempDir()};
    taken.assign(whole.pages.size(), {});
    last = 0;
    photos.fetched = 0;
    const atlas::TextureAtlas pieces = atlas::bake_atlas(plan, of_these, forward, one_by_one);
    fetched.push_back(photos.fetched);
    EXPECT_TRUE(pieces.pages.empty());
    EXPECT_EQ(pieces.statistics.padded_texels, whole.statistics.padded_texels);
    EXPECT_EQ(pieces.model.face_page, whole.model.face_page);
    for (std::size_t n = 0; n < taken.size(); ++n)
      EXPECT_TRUE(taken[n].pixels == whole.pages[n].pixels) << "page " << n << " of " << taken.size();
  }
  EXPECT_GT(fetched[0], fetched[1]);
  EXPECT_GT(fetched[1], fetched[2]);
}

// Seams and blending make do with coarse photos, which are made when a view is looked at.
TEST_F(Pipeline, PhotosAreFetchedToSeeAndToPaint) {
  const test::TemporaryFolder folder;
  CountedPhotos photos(photos_);
  const pipeline::Settings settings;
  results::OutputFolder out(folder.path() / "out");
  const pipeline::TexturedFiles made = pipeline::texture_into({input(), settings, photos, silent_}, out);
  EXPECT_GT(made.textured.atlas.statistics.blended_faces, 0u);
  EXPECT_GT(made.textured.atlas.statistics.seam_edges, 0u);
  EXPECT_LE(photos.fetched, 2 * city_->views.size());
}

// They would otherwise stay while all that views see of all faces is compared, which a limit has no room for.
TEST_F(Pipeline, PhotosMakeRoomBeforeViewsAreJudged) {
  CountedPhotos photos(photos_);
  pipeline::Settings settings;
  settings.memory_bytes = 2'000'000'000;
  const pipeline::MemoryPlan plan = pipeline::plan_memory(input(), settings);
  pipeline::see_and_choose({input(), settings, photos, silent_}, plan);
  ASSERT_EQ(photos.room.size(), 3u) << "to see, to judge, to choose";
  EXPECT_EQ(photos.room[0], plan.photos_while_seeing());
  EXPECT_LT(photos.room[1], plan.photos_while_judging(24.0 * static_cast<double>(city_->mesh.faces.size())))
      << "more than a record a face is held";
  EXPECT_GT(photos.room[1], 0u);
  EXPECT_EQ(photos.room[2], plan.photos_while_choosing());
}

TEST_F(Pipeline, FacesOfAPartHaveTheCandidatesOfTheWhole) {
  const pipeline::Seen whole = pipeline::see({input(), {}, photos_, silent_});
  std::vector<FaceId> part;
  for (std::uint32_t f = 0; f < city_->mesh.faces.size(); f += 3) part.push_back(FaceId{f});
  const pipeline::Seen seen = pipeline::see({input(), {}, photos_, silent_}, {.faces = part, .on_view = {}});
  const labeling::CostTable &all = whole.candidates.table, &some = seen.candidates.table;
  ASSERT_EQ(some.faces(), all.faces());
  for (std::size_t f = 0; f < all.faces(); ++f) {
    if (f % 3 != 0) {
      EXPECT_EQ(some.first[f], some.first[f + 1]);
      EXPECT_EQ(seen.candidates.tags[f], labeling::FaceTag::unseen);
      continue;
    }
    EXPECT_EQ(seen.candidates.tags[f], whole.candidates.tags[f]);
    ASSERT_EQ(some.first[f + 1] - some.first[f], all.first[f + 1] - all.first[f]);
    for (std::size_t i = 0; i < some.first[f + 1] - some.first[f]; ++i) {
      EXPECT_EQ(some.views[some.first[f] + i], all.views[all.first[f] + i]);
      EXPECT_EQ(some.costs[some.first[f] + i], all.costs[all.first[f] + i]);
    }
  }
  EXPECT_TRUE(std::all_of(seen.coverage.entries.begin(), seen.coverage.entries.end(),
                          [](const visibility::FaceCoverage& entry) { return index(entry.face) % 3 == 0; }));
}

TEST_F(Pipeline, OnlyTheGivenViewsAreUsed) {
  const std::vector<ViewId> some{ViewId{1}, ViewId{4}};
  const pipeline::Seen seen = pipeline::see({{city_->scene, city_->mesh, some}, {}, photos_, silent_});
  ASSERT_FALSE(seen.candidates.table.views.empty());
  EXPECT_TRUE(std::all_of(seen.candidates.table.views.begin(), seen.candidates.table.views.end(),
                          [](std::uint32_t view) { return view == 1 || view == 4; }));
}

TEST_F(Pipeline, LabelsAroundAPartStay) {
  const pipeline::Settings settings;
  const auto [graph, seen, selection] = see_and_choose(settings);
  std::vector<ViewId> fixed = selection.labels;
  for (std::size_t f = 0; f < fixed.size() / 2; ++f) fixed[f] = kNoView;  // to be chosen again
  const labeling::Selection again = pipeline::choose(seen.candidates.table, graph, settings.solver, silent_, fixed);
  for (std::size_t f = fixed.size() / 2; f < fixed.size(); ++f) EXPECT_EQ(again.labels[f], fixed[f]);
}

// Half the faces textured, the others given as their border: in no model file.
TEST_F(Pipeline, ABorderIsNotWritten) {
  const pipeline::Settings settings;
  const Chosen chosen = see_and_choose(settings);
  pipeline::TexturedMesh part;
  part.selection = chosen.selection;
  part.tags = chosen.seen.candidates.tags;
  atlas::AtlasInput atlas_input =
      pipeline::atlas_input(input(), photos_, chosen.graph, chosen.seen, part.selection.labels);
  std::vector<std::uint8_t> border;
  std::vector<Triangle> inside;
  for (const Triangle& t : city_->mesh.faces) {
    border.push_back(city_->mesh.positions[t[0]].x > 0 ? 1 : 0);
    if (border.back() == 0) inside.push_back(t);
  }
  ASSERT_TRUE(!inside.empty() && inside.size() < border.size());
  atlas_input.border = border;
  part.atlas = pipeline::make_atlas(atlas_input, settings.atlas, silent_);
  test::TemporaryFolder out;
  results::OutputFolder folder(out.path() / "part", false, "test");
  pipeline::write({input(), settings, photos_, silent_}, part, folder);
  folder.publish();
  EXPECT_EQ(io::read_mesh(out.path() / "part/model.obj").faces, inside);
  EXPECT_EQ(io::read_textured_model(out.path() / "part/model.glb").mesh.faces.size(), inside.size());
}

TEST_F(Pipeline, AMeshThatNoPhotoSeesIsRefused) {
  Mesh away = city_->mesh;
  for (WorldPoint& p : away.positions) p.x += 1e6;
  EXPECT_THROW(pipeline::texture(city_->scene, away, {}, photos_, silent_), InputError);
}

// Keeps warnings.
class Warned : public results::Observer {
 public:
  void warning(const std::string& text, const std::vector<Cure>& cures = {}) override {
    warnings.push_back(text);
    cures_of_last = cures;
  }
  std::vector<std::string> warnings;
  std::vector<Cure> cures_of_last;
};

// With enough faces for a judgement about each photo.
class PhotosAndPoses : public Pipeline {
 protected:
  static void SetUpTestSuite() { city_ = std::make_unique<City>(50000, 720); }
};

TEST_F(PhotosAndPoses, PhotosOfOtherPosesAreLeftOut) {
  std::vector<io::Picture> pictures = city_->pictures;
  std::swap(pictures[1].image, pictures[4].image);
  io::PictureSource swapped(city_->scene, pictures);
  pipeline::Settings settings;
  Warned observer;
  const pipeline::Seen seen = pipeline::see({input(), settings, swapped, observer});
  for (const labeling::ViewAgreement& each : seen.candidates.agreement) {
    EXPECT_TRUE(each.judged) << each.steps;
    EXPECT_EQ(each.by_chance, index(each.view) == 1 || index(each.view) == 4)
        << index(each.view) << ": " << each.correlation << " where chance gives " << each.chance;
  }
  EXPECT_TRUE(std::ranges::none_of(seen.candidates.table.views, [](auto view) { return view == 1 || view == 4; }));
  ASSERT_EQ(observer.warnings.size(), 1u);
  EXPECT_NE(observer.warnings[0].find("2 of 6 photos"), std::string::npos) << observer.warnings[0];
  EXPECT_EQ(observer.cures_of_last, std::vector{Cure::keep_odd_views});

  settings.costs.keep_odd_views = true;
  const pipeline::Seen kept = pipeline::see({input(), settings, swapped, observer});
  EXPECT_TRUE(std::ranges::any_of(kept.candidates.table.views, [](auto view) { return view == 1; }));
}

TEST_F(PhotosAndPoses, PhotosInAnotherOrderAreRefused) {
  std::vector<io::Picture> pictures(city_->pictures.rbegin(), city_->pictures.rend());
  io::PictureSource reversed(city_->scene, pictures);
  pipeline::Settings settings;
  try {
    pipeline::see({input(), settings, reversed, silent_});
    FAIL() << "no photo belongs to its pose";
  } catch (const InputError& error) {
    EXPECT_EQ(error.cures(), std::vector{Cure::allow_misfit});
    EXPECT_EQ(test::measured(error, "agreement.judged"), 6);
    EXPECT_GT(test::measured(error, "agreement.by_chance"), 3);
    EXPECT_NE(std::string(error.what()).find("with the photos in reverse order"), std::string::npos) << error.what();
  }
  settings.allow_misfit = true;
  EXPECT_NO_THROW(pipeline::see({input(), settings, reversed, silent_}));
}

TEST_F(PhotosAndPoses, PhotosUpsideDownAreNamedInTheError) {
  std::vector<io::Picture> pictures = city_->pictures;
  for (io::Picture& picture : pictures) {
    Pixels& levels = picture.image.pixels;
    std::ranges::reverse(levels);
    for (std::size_t i = 0; i < levels.size(); i += 3) std::swap(levels[i], levels[i + 2]);
  }
  io::PictureSource turned(city_->scene, pictures);
  try {
    pipeline::see({input(), {}, turned, silent_});
    FAIL() << "no photo fits its pose";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("with the photos turned by 180 degrees"), std::string::npos)
        << error.what();
  }
}

// NVM and Bundler state no size of photos: where these were reduced since, the focal lengths are of larger ones.
void enlarge_focal_lengths(Scene& scene) {
  for (View& view : scene.views)
    for (double* length : {&view.camera.fx, &view.camera.fy}) *length *= 1.94;
}
constexpr const char *kReduced = "with focal lengths times 0.51", *kEnlarged = "(were the photos enlarged since";

TEST_F(PhotosAndPoses, CamerasOfPhotosOfAnotherSizeAreNamedInTheError) {
  Scene larger = city_->scene, smaller = city_->scene;
  enlarge_focal_lengths(larger);
  for (View& view : smaller.views) {
    Camera& camera = view.camera;
    for (double* length : {&camera.fx, &camera.fy, &camera.cx, &camera.cy}) *length /= 2;
  }
  for (const auto& [scene, expected] : {std::pair{&larger, kReduced}, {&smaller, kEnlarged}}) {
    const std::string error = test::input_error([&, of = scene] {
      pipeline::see({{*of, city_->mesh, city_->views}, pipeline::Settings{}, photos_, silent_});
    });
    EXPECT_TRUE(test::contains(error, expected)) << error;
  }
}

// The mesh is made a thousand times too large. The photos then see only a little of its ground.
TEST_F(PhotosAndPoses, AMeshOfWhichHardlyAnythingIsSeenIsRefused) {
  Mesh large = city_->mesh;
  for (WorldPoint& p : large.positions) p = 1000.0 * p;
  const std::vector<ViewId> all = checks::all_views(city_->scene), one{ViewId{0}};
  pipeline::Settings settings;
  const auto look = [&](const std::vector<ViewId>& views, results::Observer& observer) {
    pipeline::see({{city_->scene, large, views}, settings, photos_, observer});
  };
  const std::optional<Error> error = test::caught([&] { look(all, silent_); });
  ASSERT_TRUE(error);
  EXPECT_TRUE(test::contains(error->what(), "photos see less than 5 % of the faces")) << error->what();
  EXPECT_EQ(error->cures(), std::vector{Cure::allow_unseen});
  EXPECT_LT(test::measured(*error, "seen_share"), 0.05);
  // A part of the photos may well show a small part of the mesh, and one alone is compared with none.
  for (const auto& [views, keep] : {std::pair{one, false}, std::pair{all, true}}) {
    settings.allow_unseen = settings.allow_misfit = keep;
    Warned observer;
    ASSERT_NO_THROW(look(views, observer));
    ASSERT_FALSE(observer.warnings.empty());
    EXPECT_TRUE(test::contains(observer.warnings[0], "photos see less than 5 % of the faces; are mesh and cameras in"));
  }
}

TEST_F(PhotosAndPoses, ExposureAndOverlapRaiseNoFalseAlarm) {
  std::vector<io::Picture> pictures = city_->pictures;
  for (std::size_t n = 0; n < pictures.size(); n += 2)
    for (std::uint8_t& level : pictures[n].image.pixels) level = static_cast<std::uint8_t>(level / 3);
  io::PictureSource dark(city_->scene, pictures);
  for (std::uint32_t a = 0; a < 6; ++a)
    for (std::uint32_t b = a + 1; b < 6; ++b) {
      const std::vector<ViewId> two{ViewId{a}, ViewId{b}};
      const pipeline::Seen seen = pipeline::see({{city_->scene, city_->mesh, two}, {}, dark, silent_});
      for (const labeling::ViewAgreement& each : seen.candidates.agreement)
        EXPECT_FALSE(each.by_chance) << a << " and " << b << ": " << each.correlation;
    }
}

// With too few pixels for a judgement about photos that do not fit.
class SmallPhotos : public Pipeline {
 protected:
  static void SetUpTestSuite() { city_ = std::make_unique<City>(8000, 600, 16); }
};

TEST_F(SmallPhotos, AnExplanationAloneRefusesAScene) {
  Warned observer;
  EXPECT_NO_THROW(pipeline::see({input(), {}, photos_, observer}));
  EXPECT_TRUE(observer.warnings.empty());
  Scene inverse = city_->scene;
  for (View& view : inverse.views) {
    const auto [rotation, centre] = view.pose;
    const CameraPoint minus_t = camera_from_world({rotation, {}}, centre);
    for (std::size_t i = 0; i < 9; ++i) view.pose.rotation[i] = rotation[i % 3 * 3 + i / 3];
    view.pose.centre = {-minus_t.x, -minus_t.y, -minus_t.z};
  }
  const checks::Input turned{inverse, city_->mesh, city_->views};
  pipeline::Settings settings;
  const std::string error = test::input_error([&] { pipeline::see({turned, settings, photos_, silent_}); });
  EXPECT_TRUE(test::contains(error, "with the poses inverted they would agree on the mesh")) << error;
  settings.allow_misfit = true;
  EXPECT_NO_THROW(pipeline::see({turned, settings, photos_, silent_}));
  Scene larger = city_->scene;
  enlarge_focal_lengths(larger);
  const std::string of_focal = test::input_error([&] {
    pipeline::see({{larger, city_->mesh, city_->views}, pipeline::Settings{}, photos_, silent_});
  });
  EXPECT_TRUE(test::contains(of_focal, kReduced)) << of_focal;
}

// With views enough that most faces are seen by two that lie close to each other.
class MeshElsewhere : public Pipeline {
 protected:
  static void SetUpTestSuite() { city_ = std::make_unique<City>(50000, 720, 20); }

  // The same city with another mesh.
  static checks::MeshFit fit_of(const Mesh& mesh, bool keep, Warned& observer) {
    pipeline::Settings settings;
    settings.allow_misfit = keep;
    const std::vector<ViewId> views = checks::all_views(city_->scene);
    io::PictureSource photos(city_->scene, city_->pictures);
    return pipeline::see({{city_->scene, mesh, views}, settings, photos, observer}).fit;
  }
};

TEST_F(MeshElsewhere, TheRightMeshFits) {
  Warned observer;
  const checks::MeshFit fit = fit_of(city_->mesh, false, observer);
  EXPECT_EQ(fit.verdict, checks::MeshFit::Verdict::fits) << checks::photo_fit_text(fit);
  EXPECT_GT(fit.share, 0.9) << checks::photo_fit_text(fit);
  EXPECT_TRUE(observer.warnings.empty()) << observer.warnings[0];
}

TEST_F(MeshElsewhere, ExposureJumpsRaiseNoAlarm) {
  std::vector<io::Picture> pictures = city_->pictures;
  for (std::size_t n = 0; n < pictures.size(); n += 2)
    for (std::uint8_t& level : pictures[n].image.pixels) level = static_cast<std::uint8_t>(level / 2);
  io::PictureSource dark(city_->scene, pictures);
  Warned observer;
  EXPECT_EQ(pipeline::see({input(), {}, dark, observer}).fit.verdict, checks::MeshFit::Verdict::fits);
  EXPECT_TRUE(observer.warnings.empty()) << observer.warnings[0];
}

TEST_F(MeshElsewhere, AMovedOrScaledMeshIsNamed) {
  Mesh raised = city_->mesh, scaled = city_->mesh;
  for (WorldPoint& p : raised.positions) p.z += 5;
  for (WorldPoint& p : scaled.positions) p = {1.05 * p.x, 1.05 * p.y, 1.05 * p.z + 1};
  for (const Mesh& mesh : {raised, scaled}) {
    Warned observer;
    const checks::MeshFit fit = fit_of(mesh, false, observer);
    EXPECT_EQ(fit.verdict, checks::MeshFit::Verdict::elsewhere) << checks::photo_fit_text(fit);
    ASSERT_FALSE(observer.warnings.empty());
    EXPECT_TRUE(test::contains(observer.warnings.back(), "the mesh seems to be moved, scaled, turned or mirrored"));
    EXPECT_EQ(observer.cures_of_last, std::vector{Cure::look_at_fit});
  }
}

// Buildings of three times their height and distances, on the same level ground: photos alone agree about the ground. Tie
// points at the right surfaces tell.
TEST_F(MeshElsewhere, TiePointsOffTheMeshAreNamed) {
  Warned observer;
  const pipeline::Seen right = pipeline::see({input(), {}, photos_, observer});
  EXPECT_EQ(right.tie_point_fit.places, 0u);
  std::string text;
  for (std::uint32_t f = 0; f < city_->mesh.faces.size(); f += 7) {
    const auto views = right.candidates.table.views_of(f);
    if (views.size() < 2) continue;
    const Triangle& t = city_->mesh.faces[f];
    const auto& at = city_->mesh.positions;
    const WorldPoint p = (at[t[0]] + at[t[1]] + at[t[2]]) * (1.0 / 3);
    text += fmt::format("{} {} {} {} 0 0 0 0", f, p.x, p.y, p.z);
    for (const std::uint32_t view : views) text += fmt::format(" {} 0", view + 1);
    text += '\n';
  }
  const test::TemporaryFolder folder;
  Scene scene = city_->scene;
  scene.format = "COLMAP";
  scene.files = {folder.write("points3D.txt", text)};
  for (std::uint32_t v = 0; v < scene.views.size(); ++v) scene.views[v].number = v + 1;
  Mesh large = city_->mesh;
  for (WorldPoint& p : large.positions) p = {3 * p.x, 3 * p.y, 3 * p.z};
  pipeline::Settings settings;
  settings.allow_misfit = true;
  using enum checks::MeshFit::Verdict;
  for (const auto& [mesh, verdict] : {std::pair{&city_->mesh, fits}, {&large, elsewhere}}) {
    Warned warned;
    const checks::MeshFit fit = pipeline::see({{scene, *mesh, city_->views}, settings, photos_, warned}).tie_point_fit;
    EXPECT_EQ(fit.verdict, verdict) << checks::tie_point_fit_text(fit);
    EXPECT_EQ(verdict == fits, warned.warnings.empty());
  }
  scene.files = {folder.write("points3D.txt", "1 2 3\n")};
  Warned warned;
  EXPECT_EQ(pipeline::see({{scene, city_->mesh, city_->views}, settings, photos_, warned}).tie_point_fit.verdict,
            unknown);
  ASSERT_EQ(warned.warnings.size(), 1u);
  EXPECT_TRUE(test::contains(warned.warnings[0], "points3D.txt: line 1: expected POINT3D_ID"));
}

}  // namespace
}  // namespace gpvc
