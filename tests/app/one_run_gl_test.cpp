// What every way to texture a mesh has: rules about photos, and work that is kept. (Whether mesh and photos fit: one_run_test.)
#include <gtest/gtest.h>

#include <array>
#include <map>
#include <memory>

#include "app/checks/frame_check.h"
#include "app/pipeline/keys.h"
#include "app/tiles/make_job.h"
#include "app/tiles/units.h"
#include "app/tileset/tileset.h"
#include "io/textured_model.h"
#include "tests/app/photographed_city.h"

namespace gpvc {
namespace {

namespace fs = std::filesystem;
using test::City;

// The colour of a view's photo.
std::array<std::uint8_t, 3> color_of(ViewId view) {
  const auto level = static_cast<std::uint8_t>(40 + 30 * index(view));
  return {level, 100, static_cast<std::uint8_t>(255 - level)};
}

class OneRun : public testing::Test {
 protected:
  static void SetUpTestSuite() { city_ = std::make_unique<City>(); }
  static void TearDownTestSuite() { city_.reset(); }

  OneRun() {
    for (View& view : scene_.views) {
      Image image{view.camera.width, view.camera.height, 3, {}};
      const auto color = color_of(ViewId{static_cast<std::uint32_t>(&view - scene_.views.data())});
      for (int n = 0; n < image.width * image.height; ++n)
        image.pixels.insert(image.pixels.end(), color.begin(), color.end());
      view.photo = folder_.path() / view.photo.filename();
      io::write_image(view.photo, image, io::ImageFormat::png, 0);
    }
    const checks::Box box = checks::box_of(city_->mesh);
    middle_ = (box.low.x + box.high.x) / 2;
    settings_.texture.atlas.seams = atlas::SeamLeveling::none;
    settings_.texture.atlas.blend = atlas::Blending::none;
    settings_.texture.atlas.unseen = atlas::UnseenFaces::color;
    settings_.texture.atlas.unseen_color = {1, 2, 3};
    settings_.texture.costs.keep_odd_views = settings_.texture.allow_misfit = true;
    settings_.texture.output.texture = io::ImageFormat::png;
    settings_.tiles.faces_per_tile = 1000;
  }

  // "In the west this photo alone", of a place or of faces.
  pipeline::ViewRule west_shows(ViewId view, bool by_faces) const {
    io::BoxRegion box{{-1e6, -1e6, -1e6}, {middle_, 1e6, 1e6}};
    if (!by_faces) return {box, true, {view}, "rule"};
    io::FaceRegion faces;
    const std::vector<std::uint8_t> inside = io::faces_in(box, city_->mesh);
    for (std::uint32_t f = 0; f < inside.size(); ++f)
      if (inside[f] != 0) faces.ranges.push_back({f, f});
    return {faces, true, {view}, "rule"};
  }

  // Faces west of the middle show the view, where any, on all levels; others show all views.
  void expect_west_shows(ViewId view, const fs::path& tiles, int levels) const {
    for (int level = 0; level < levels; ++level) {
      std::size_t shown = 0, others = 0;
      std::map<std::array<std::uint8_t, 3>, std::size_t> elsewhere;
      for (const auto& entry : fs::directory_iterator(tiles)) {
        if (!entry.path().filename().string().starts_with(std::to_string(level) + "_")) continue;
        const io::LoadedModel loaded = io::read_textured_model(entry.path());
        for (std::size_t f = 0; f < loaded.mesh.faces.size(); ++f) {
          double most = -1e9;
          float u = 0, v = 0;
          for (std::size_t i = 0; i < 3; ++i) {
            most = std::max(most, loaded.mesh.positions[loaded.mesh.faces[f][i]].x);
            u += loaded.model.texcoords[loaded.model.face_texcoords[f][i]].u / 3;
            v += loaded.model.texcoords[loaded.model.face_texcoords[f][i]].v / 3;
          }
          const Image& page = loaded.pages[loaded.model.face_page[f]];
          const std::uint8_t* texel =
              page.at(std::min(static_cast<int>(u * static_cast<float>(page.width)), page.width - 1),
                      std::min(static_cast<int>(v * static_cast<float>(page.height)), page.height - 1));
          const std::array color{texel[0], texel[1], texel[2]};
          if (most < middle_) {
            for (const ViewId id : city_->views) (id == view ? shown : others) += color == color_of(id) ? 1 : 0;
          } else {
            ++elsewhere[color];
          }
        }
      }
      EXPECT_GT(shown, 20u) << "level " << level;
      // Where the view does not see a face's middle, that is filled from around; without rules nine of ten show others.
      EXPECT_LE(others, shown / 10) << "level " << level << ": " << shown << " show it";
      EXPECT_GE(elsewhere.size(), 3u) << "level " << level;
    }
  }

  // The files of a tileset, by name.
  std::map<std::string, std::string> make_tileset(const fs::path& where, results::Observer& observer, bool publish) {
    io::PhotoCache photos(scene_);
    results::OutputFolder out(where, true, "tileset");
    tileset::tileset_into({{scene_, city_->mesh, city_->views}, settings_.texture, photos, observer}, settings_.tiles,
                          out);
    std::map<std::string, std::string> files;
    for (const auto& entry : fs::recursive_directory_iterator(out.in_making()))
      if (entry.is_regular_file()) files[fs::relative(entry.path(), out.in_making())] = test::read_file(entry.path());
    if (publish) out.publish();
    return files;
  }

  static inline std::unique_ptr<City> city_;
  test::TemporaryFolder folder_;
  Scene scene_ = city_->scene;
  double middle_ = 0;
  tiles::JobSettings settings_;
  results::Observer silent_;
};

TEST_F(OneRun, RulesHoldInATilesetOnAllLevels) {
  io::PhotoCache photos(scene_);
  for (const bool by_faces : {false, true}) {
    settings_.texture.view_rules = {west_shows(ViewId{2}, by_faces)};
    results::OutputFolder out(folder_.path() / (by_faces ? "faces" : "box"));
    const tileset::TilesetReport report = tileset::tileset_into(
        {{scene_, city_->mesh, city_->views}, settings_.texture, photos, silent_}, settings_.tiles, out);
    ASSERT_EQ(report.levels.size(), 2u);
    expect_west_shows(ViewId{2}, out.in_making() / "tiles", 2);
  }
}

TEST_F(OneRun, RulesHoldInAJobOnAllLevels) {
  for (const bool by_faces : {false, true}) {
    settings_.texture.view_rules = {west_shows(ViewId{3}, by_faces)};
    const tiles::JobFolder folder(folder_.path() / (by_faces ? "faces" : "box"));
    tiles::make_job(folder, {scene_, city_->mesh, city_->views}, settings_, "test", silent_);
    tiles::UnitRunner runner(folder, {}, silent_);
    for (const tiles::Unit& unit : runner.units()) runner.run(unit);
    expect_west_shows(ViewId{3}, folder.path() / "result" / "tiles", 2);
  }
}

// Cancels a run when its atlas has been begun so many times.
class WriteCutter : public results::Observer {
 public:
  explicit WriteCutter(int bakes) : left_(bakes) {}
  void begin(const results::StageInfo& stage) override {
    if (stage.name == "write" && --left_ == 0) throw Cancelled();
  }
  void end(const std::string& summary) override {
    if (test::contains(summary, "kept by an earlier run")) ++taken_over;
  }
  int taken_over = 0;

 private:
  int left_;
};

TEST_F(OneRun, ATilesetGoesOnFromWhereItWasCutOff) {
  settings_.texture.keep_work = pipeline::KeepWork::never;
  const auto whole = make_tileset(folder_.path() / "whole", silent_, false);
  ASSERT_TRUE(whole.contains("tiles/1_0.glb"));
  settings_.texture.keep_work = pipeline::KeepWork::always;
  for (const int cut : {1, 2}) {  // while level 0 is written, and level 1
    const fs::path out = folder_.path() / ("cut" + std::to_string(cut));
    WriteCutter cutter(cut), rest(-1);
    EXPECT_THROW(make_tileset(out, cutter, false), Cancelled);
    EXPECT_TRUE(fs::exists(out / ".work" / ("level-" + std::to_string(cut - 1))));
    EXPECT_EQ(make_tileset(out, rest, true), whole);
    // See, choose and bake of each level that was finished.
    EXPECT_EQ(rest.taken_over, 3 * cut);
    EXPECT_FALSE(fs::exists(out / ".work")) << "nothing is left behind a complete result";
  }
}

TEST_F(OneRun, TilesDivideTheGroundBelowTheAxisThatIsUp) {
  for (const bool x_is_up : {false, true}) {
    if (x_is_up) settings_.texture.output.up = io::UpAxis::pos_x;
    const fs::path out = folder_.path() / (x_is_up ? "x" : "found");
    make_tileset(out, silent_, true);
    int on_both_sides = 0;
    for (int tile = 0; tile < 4; ++tile) {
      const io::LoadedModel loaded = io::read_textured_model(out / "tiles" / ("0_" + std::to_string(tile) + ".glb"));
      const checks::Box box = checks::box_of(loaded.mesh);
      const double fifth = (checks::box_of(city_->mesh).high.x - checks::box_of(city_->mesh).low.x) / 5;
      on_both_sides += box.low.x < middle_ - fifth && box.high.x > middle_ + fifth ? 1 : 0;
    }
    EXPECT_EQ(on_both_sides, x_is_up ? 4 : 0);
  }
}

TEST_F(OneRun, AnEarlierResultsDeviceDoesNotMatter) {
  io::PhotoCache photos(scene_);
  const checks::Input input{scene_, city_->mesh, city_->views};
  pipeline::Settings other = settings_.texture;
  other.device = 1;
  const auto keys = pipeline::result_keys({input, settings_.texture, photos, silent_});
  EXPECT_EQ(pipeline::difference(keys, pipeline::result_keys({input, other, photos, silent_})), "");
  other.visibility.method = visibility::ShadowMap{.epsilon = 0.1};
  pipeline::Settings one = other;
  one.device = 0;
  EXPECT_NE(pipeline::difference(pipeline::result_keys({input, one, photos, silent_}),
                                 pipeline::result_keys({input, other, photos, silent_})),
            "");
}

}  // namespace
}  // namespace gpvc
