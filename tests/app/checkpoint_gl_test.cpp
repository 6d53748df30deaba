// Runs that are cut off and go on from the work that they kept.
#include "app/pipeline/checkpoint.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <map>
#include <memory>

#include "app/pipeline/pipeline.h"
#include "app/pipeline/stored.h"
#include "app/results/output_folder.h"
#include "atlas/leveling/seam_leveling.h"
#include "tests/app/photographed_city.h"

namespace gpvc {
namespace {

namespace fs = std::filesystem;
using pipeline::KeepWork;
using test::City;

// Cancels a stage when it has done so much, and counts what was taken over.
class Cutter : public results::Observer {
 public:
  explicit Cutter(std::string stage = "", std::size_t done = 0) : cut_in_(std::move(stage)), cut_at_(done) {}
  void begin(const results::StageInfo& stage) override { now_ = stage.name; }
  void progress(std::size_t done, std::size_t) override {
    if (now_ == cut_in_ && done >= cut_at_) throw Cancelled();
  }
  void end(const std::string& summary) override {
    selection_was_kept |= now_ == "choose" && test::contains(summary, "kept by an earlier run");
  }
  void figure(const std::string& name, const results::Figure& value) override {
    if (name == "kept.views") views = std::get<std::size_t>(value);
  }
  void warning(const std::string& text, const std::vector<Cure>& /*cures*/ = {}) override { warnings.push_back(text); }

  std::size_t views = 0;
  bool selection_was_kept = false;
  std::vector<std::string> warnings;

 private:
  std::string cut_in_, now_;
  std::size_t cut_at_;
};

class CheckpointTest : public testing::Test {
 protected:
  static void SetUpTestSuite() { city_ = std::make_unique<City>(); }
  static void TearDownTestSuite() { city_.reset(); }

  void texture(const pipeline::Settings& settings, results::Observer& observer) const {
    results::OutputFolder out(out_, true, "texture");
    io::PhotoCache photos(city_->scene);
    pipeline::texture_into({{city_->scene, city_->mesh, city_->views}, settings, photos, observer}, out);
    std::ofstream(out.file("run.json")) << R"({"program": "gpvc", "command": "texture"})";
    out.publish();
  }
  // The files of a run that keeps nothing.
  std::map<std::string, std::string> undisturbed(pipeline::Settings settings = {}) const {
    settings.keep_work = KeepWork::never;
    Cutter cutter;
    texture(settings, cutter);
    EXPECT_EQ(cutter.views, 0u);
    return take_result();
  }
  // A run that is cut off when a stage has done so much.
  void cut_off(const std::string& stage, std::size_t done) const {
    pipeline::Settings settings;
    settings.keep_work = KeepWork::always;
    Cutter cutter(stage, done);
    EXPECT_THROW(texture(settings, cutter), Cancelled);
    EXPECT_TRUE(fs::exists(work_));
    EXPECT_FALSE(fs::exists(out_ / "model.obj"));
  }
  // The same command again, to its end.
  std::map<std::string, std::string> go_on(Cutter& cutter, pipeline::Settings settings = {}) const {
    texture(settings, cutter);
    EXPECT_FALSE(fs::exists(work_));
    return take_result();
  }
  std::map<std::string, std::string> take_result() const {
    std::map<std::string, std::string> files;
    for (const auto& entry : fs::directory_iterator(out_)) files[entry.path().filename()] = test::read_file(entry);
    fs::remove_all(out_);
    return files;
  }

  static inline std::unique_ptr<City> city_;
  test::TemporaryFolder folder_;
  fs::path out_ = folder_.path() / "out", work_ = out_ / ".work";
};

TEST_F(CheckpointTest, GoesOnFromWhereverItWasCutOff) {
  const auto whole = undisturbed();
  ASSERT_TRUE(whole.contains("model.glb"));
  const std::size_t views = city_->views.size();
  const struct {
    const char* stage;
    std::size_t done, least_views;
    bool selection;
  } cuts[] = {{"see", 3, 2, false}, {"choose", 0, views, false}, {"bake", 3, views, true}};
  for (const auto& cut : cuts) {
    cut_off(cut.stage, cut.done);
    Cutter cutter;
    EXPECT_EQ(go_on(cutter), whole) << cut.stage;
    EXPECT_GE(cutter.views, cut.least_views) << cut.stage;
    EXPECT_EQ(cutter.selection_was_kept, cut.selection) << cut.stage;
  }
}

// Gives each photo the bytes of the next one when a stage begins, and their own at the end.
class Shuffler : public results::Observer {
 public:
  Shuffler(const Scene& scene, std::string stage) : stage_(std::move(stage)) {
    for (const View& view : scene.views) photos_.emplace_back(view.photo, test::read_file(view.photo));
  }
  ~Shuffler() override { write(0); }
  Shuffler(const Shuffler&) = delete;
  Shuffler& operator=(const Shuffler&) = delete;
  void begin(const results::StageInfo& stage) override {
    if (stage.name == stage_) write(1);
  }

 private:
  void write(std::size_t shift) const {
    for (std::size_t i = 0; i < photos_.size(); ++i)
      std::ofstream(photos_[i].first, std::ios::binary) << photos_[(i + shift) % photos_.size()].second;
  }
  std::string stage_;
  std::vector<std::pair<fs::path, std::string>> photos_;
};

// Photos are read for the keys of kept work before they are looked at.
TEST_F(CheckpointTest, PhotosThatAreReplacedMeanwhileAreRefusedByName) {
  pipeline::Settings settings;
  settings.keep_work = KeepWork::always;
  Shuffler shuffler(city_->scene, "see");
  const std::string said = test::input_error([&] { texture(settings, shuffler); });
  EXPECT_TRUE(test::contains(said, "has changed since it was first read")) << said;
  EXPECT_TRUE(test::contains(said, city_->scene.views[0].photo.parent_path().string())) << said;
  EXPECT_FALSE(fs::exists(out_ / "model.obj"));
}

// Changes a part that is kept, and makes its hash right again.
template <typename Part, typename Change>
void change_part(const fs::path& folder, const std::string& name, const Change& change) {
  const std::string bytes = test::read_file(folder / name);
  io::WorkKey key;
  std::memcpy(&key, bytes.data() + 8, sizeof key);
  io::WorkStore store(folder, results::kCheckpointHashes);
  Part part;
  ASSERT_TRUE(store.read(name, key, [&](io::WorkStore::Reader& in) { part = in.get<Part>(); }));
  change(part);
  store.keep(name, key, [&](io::WorkStore::Writer& out) { out.add(part); });
}

TEST_F(CheckpointTest, ValuesThatNoRunKeepsCountAsNoneThoughTheHashIsRight) {
  using pipeline::SeenView;
  const auto whole = undisturbed();
  cut_off("bake", 3);
  change_part<SeenView>(work_, "view-0", [](SeenView& seen) { seen.coverage.view = ViewId{1000}; });
  change_part<SeenView>(work_, "view-1", [](SeenView& seen) { seen.coverage.bytes.assign(40, 0xFF); });
  change_part<SeenView>(work_, "view-2", [](SeenView& seen) { seen.statistics.assign(20, std::byte{0x7F}); });
  change_part<SeenView>(work_, "view-3", [](SeenView& seen) { seen.fit.preview.image.height += 1000; });
  change_part<labeling::Selection>(work_, "labels", [](labeling::Selection& s) { s.labels[5] = ViewId{1000}; });
  Cutter cutter;
  EXPECT_EQ(go_on(cutter), whole);
  EXPECT_EQ(cutter.views, city_->views.size() - 4);
  EXPECT_FALSE(cutter.selection_was_kept);
}

TEST_F(CheckpointTest, OtherOptionsRedoOnlyWhatDependsOnThem) {
  const auto with = [](const auto& change) {
    pipeline::Settings settings;
    change(settings);
    return settings;
  };
  const std::size_t views = city_->views.size();
  const struct {
    const char* name;
    pipeline::Settings settings;
    std::size_t views;
    bool selection;
  } changes[] = {
      {"pages and files", with([](auto& s) {
         s.atlas.seams = atlas::SeamLeveling::none;
         s.atlas.page_size = 256;
         s.atlas.unseen = atlas::UnseenFaces::color;
         s.output.texture = io::ImageFormat::png;
         s.output.up = io::UpAxis::pos_x;
       }),
       views, true},
      {"choose", with([](auto& s) {
         s.solver.smoothness = 2;
         s.costs.data_weight = 0.5;
       }),
       views, false},
      {"rules about photos", with([](auto& s) {
         s.view_rules = {
             {io::GroundRegion{{{-9, -9}, {9, -9}, {9, 9}, {-9, 9}}}, false, {ViewId{1}, ViewId{2}}, "rule"}};
       }),
       views, false},
      {"data term", with([](auto& s) { s.costs.term = labeling::DataTerm::gmi; }), 0, false},
      {"sampling", with([](auto& s) { s.visibility.method = visibility::NoTest{}; }), 0, false},
  };
  for (const auto& change : changes) {
    const auto whole = undisturbed(change.settings);
    cut_off("bake", 3);
    Cutter cutter;
    EXPECT_EQ(go_on(cutter, change.settings), whole) << change.name;
    EXPECT_EQ(cutter.views, change.views) << change.name;
    EXPECT_EQ(cutter.selection_was_kept, change.selection) << change.name;
  }
}

TEST_F(CheckpointTest, AnotherPhotoOrMeshIsSeenAnew) {
  cut_off("bake", 3);
  const fs::path photo = city_->scene.views[2].photo;
  const std::string before = test::read_file(photo);
  io::write_image(photo, city_->pictures[3].image, io::ImageFormat::png, 0);
  pipeline::Settings keep;
  keep.costs.keep_odd_views = true;  // it is the photo of another pose
  Cutter cutter;
  const auto result = go_on(cutter, keep);
  EXPECT_EQ(cutter.views, city_->views.size() - 1);
  EXPECT_EQ(result, undisturbed(keep));
  std::ofstream(photo, std::ios::binary) << before;

  cut_off("bake", 3);
  const WorldPoint corner = city_->mesh.positions[0];
  city_->mesh.positions[0].z += 1e-9;
  Cutter moved;
  go_on(moved);
  EXPECT_EQ(moved.views, 0u);
  city_->mesh.positions[0] = corner;
}

TEST_F(CheckpointTest, DamagedFilesAreMadeAgain) {
  const auto whole = undisturbed();
  cut_off("bake", 3);
  for (const char* name : {"view-1", "labels", "leveling"}) {
    ASSERT_TRUE(fs::exists(work_ / name)) << name;
    fs::resize_file(work_ / name, fs::file_size(work_ / name) - 1);
  }
  Cutter cutter;
  EXPECT_EQ(go_on(cutter), whole);
  EXPECT_EQ(cutter.views, city_->views.size() - 1);
  EXPECT_FALSE(cutter.selection_was_kept);
}

TEST_F(CheckpointTest, WhereItCannotBeKeptTheRunGoesOn) {
  const auto whole = undisturbed();
  fs::create_directories(out_);
  std::ofstream(work_) << "a file";  // where the folder is to be
  pipeline::Settings settings;
  settings.keep_work = KeepWork::always;
  Cutter cutter;
  texture(settings, cutter);
  ASSERT_EQ(cutter.warnings.size(), 1u);
  EXPECT_TRUE(test::contains(cutter.warnings[0], ".work"));
  EXPECT_TRUE(test::contains(cutter.warnings[0], "no more work is kept"));
  EXPECT_EQ(test::read_file(work_), "a file");
  fs::remove(work_);
  EXPECT_EQ(take_result(), whole);
}

TEST_F(CheckpointTest, ALinkIsNotFollowed) {
  const fs::path elsewhere = folder_.path() / "elsewhere";
  fs::create_directories(elsewhere);
  fs::create_directories(out_);
  fs::create_directory_symlink(elsewhere, work_);
  pipeline::Settings settings;
  for (const KeepWork keep : {KeepWork::automatic, KeepWork::never}) {
    settings.keep_work = keep;
    Cutter cutter;
    EXPECT_THROW(texture(settings, cutter), OutputError);
    EXPECT_FALSE(fs::exists(out_ / "model.obj")) << "refused before anything is published";
  }
  EXPECT_TRUE(fs::is_empty(elsewhere));
}

TEST_F(CheckpointTest, ShortRunsKeepNothing) {
  Cutter cutter("bake", 3);
  EXPECT_THROW(texture({}, cutter), Cancelled);
  EXPECT_FALSE(fs::exists(out_));
}

// Pages are taken over one by one, whatever they wait for.
TEST_F(CheckpointTest, PagesGoOnFromTheOnesThatWerePainted) {
  pipeline::Settings settings;
  settings.atlas.page_size = 256;
  results::Observer silent;
  io::PhotoCache photos(city_->scene);
  const checks::Input input{city_->scene, city_->mesh, city_->views};
  const labeling::FaceGraph graph = pipeline::weighed_graph(city_->mesh, settings.edge_weights, silent);
  const pipeline::Seen seen = pipeline::see({input, settings, photos, silent});
  const labeling::Selection selection = pipeline::choose(seen.candidates.table, graph, settings.solver, silent);
  const atlas::AtlasInput from = pipeline::atlas_input(input, photos, graph, seen, selection.labels);
  const atlas::AtlasPlan plan = atlas::plan_atlas(from, settings.atlas);
  const atlas::TextureAtlas whole = atlas::bake_atlas(plan, from, nullptr);
  ASSERT_GT(whole.pages.size(), 3u);

  io::WorkStore store(work_, results::kCheckpointHashes);
  const atlas::BakeOptions options{
      .page_bytes = 1, .batch_bytes = 1, .scratch_folder = testing::TempDir(), .kept = {&store, {{1, 2}}}};
  std::size_t before = 0;
  for (const double share : {0.3, 0.7, 2.0}) {
    const auto cut = [&](std::size_t done, std::size_t total) {
      if (static_cast<double>(done) > share * static_cast<double>(total)) throw Cancelled();
    };
    if (share < 1) {
      EXPECT_THROW(atlas::bake_atlas(plan, from, cut, options), Cancelled);
      continue;
    }
    const atlas::TextureAtlas pieces = atlas::bake_atlas(plan, from, cut, options);
    before = pieces.statistics.kept_pages;
    EXPECT_EQ(pieces.statistics.seam_step_after, whole.statistics.seam_step_after);
    ASSERT_EQ(pieces.pages.size(), whole.pages.size());
    for (std::size_t n = 0; n < whole.pages.size(); ++n)
      EXPECT_TRUE(pieces.pages[n].pixels == whole.pages[n].pixels) << "page " << n;
  }
  EXPECT_GT(before, 0u);
  EXPECT_LT(before, whole.pages.size());
  fs::resize_file(work_ / "page-1", fs::file_size(work_ / "page-1") - 1);
  const atlas::TextureAtlas again = atlas::bake_atlas(plan, from, nullptr, options);
  EXPECT_TRUE(again.pages[1].pixels == whole.pages[1].pixels) << "its file is damaged";

  // Values that no painting leaves, though the hash is right: a page is painted anew.
  const auto expect_made_anew = [&](const char* what) {
    const atlas::TextureAtlas made = atlas::bake_atlas(plan, from, nullptr, options);
    for (std::size_t n = 0; n < whole.pages.size(); ++n)
      EXPECT_TRUE(made.pages[n].pixels == whole.pages[n].pixels) << what << ", page " << n;
  };
  using Leveling = atlas::LevelingResult;
  change_part<Leveling>(work_, "leveling", [](Leveling& r) { r.correction.nodes.at(5)[1] = 0x7FFFFFFF; });
  expect_made_anew("a node that is not there");
  change_part<Leveling>(work_, "leveling", [](Leveling& r) { r.correction.exposure.pop_back(); });
  expect_made_anew("a view without exposure");
  change_part<Leveling>(work_, "leveling", [](Leveling& r) {
    std::ranges::find_if(r.correction.strips, [](const atlas::ChartStrip& s) { return !s.empty(); })->columns = 1000;
  });
  expect_made_anew("cells that are not there");
  const std::size_t texels = whole.pages[1].pixels.size() / 3;
  const auto change_page = [&](const auto& change) {
    const std::string bytes = test::read_file(work_ / "page-1");
    std::string body = bytes.substr(24, bytes.size() - 40);
    change(body);
    store.keep("page-1", options.kept.key, [&](io::WorkStore::Writer& out) { out.write(body.data(), body.size()); });
  };
  change_page([&](std::string& body) { body[8 + 3 * texels + 7] = 9; });
  expect_made_anew("a state that texels do not have");
  for (const std::uint32_t chart : {0u, 0x7FFFFFFFu})
    for (const std::uint64_t claimed : {std::uint64_t{1} << 40, ~std::uint64_t{0}}) {
      change_page([&](std::string& body) {
        body.resize(8 + 4 * texels);
        const auto put = [&](const auto& value) { body.append(reinterpret_cast<const char*>(&value), sizeof value); };
        put(std::uint64_t{1});
        put(chart);
        put(claimed);
        put(std::uint64_t{0});
      });
      expect_made_anew("more texels than the file has");
    }
}

}  // namespace
}  // namespace gpvc
