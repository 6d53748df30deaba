// Results that are changed by other rules about photos (gpvc texture --from).
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <map>
#include <memory>
#include <mutex>
#include <random>
#include <set>

#include "app/pipeline/edit_files.h"
#include "io/npy.h"
#include "tests/app/photographed_city.h"
#include "tests/support/errors.h"

namespace gpvc {
namespace {

namespace fs = std::filesystem;
using pipeline::EditModel;
using test::City;

// Keeps the figures and notes of a run.
class EditListener : public results::Observer {
 public:
  void figure(const std::string& name, const results::Figure& value) override { figures[name] = value; }
  void note(const std::string& text) override { notes.push_back(text); }
  std::size_t count(const std::string& name) const { return std::get<std::size_t>(figures.at(name)); }
  std::map<std::string, results::Figure> figures;
  std::vector<std::string> notes;
};

// Photos from files, and which of them were decoded.
class WatchedPhotos : public io::PhotoSource {
 public:
  explicit WatchedPhotos(const Scene& scene) : photos_(scene) {}
  std::shared_ptr<const Image> photo(ViewId view) override {
    const std::lock_guard lock(mutex_);
    decoded.insert(view);
    return photos_.photo(view);
  }
  std::shared_ptr<const io::PhotoExclusion> exclusion(ViewId view) override { return photos_.exclusion(view); }
  std::optional<io::WorkKey> key(ViewId view) override { return photos_.key(view); }
  std::set<ViewId> decoded;

 private:
  io::PhotoCache photos_;
  std::mutex mutex_;
};

// The texture of a result as its files have it.
struct SavedTexture {
  EditModel edit;
  std::vector<Image> pages;
  std::vector<std::uint8_t> tags;

  explicit SavedTexture(const fs::path& folder) : edit(pipeline::read_edit_model(folder)) {
    for (std::size_t p = 0; p < edit.page_sizes.size(); ++p) pages.push_back(io::read_image(page(folder, p)));
    tags = io::read_npy<std::uint8_t>(folder / "tags.npy").values;
  }
  static fs::path page(const fs::path& folder, std::size_t number) {
    return folder / ("model_" + std::to_string(number) + ".jpg");
  }
  // The red, green and blue at the middle of an edge of a face.
  std::array<double, 3> color(const Mesh& mesh, std::uint32_t face, std::uint32_t a, std::uint32_t b) const {
    const Image& image = pages[edit.model.face_page[face]];
    double u = 0, v = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      if (mesh.faces[face][i] != a && mesh.faces[face][i] != b) continue;
      const io::TexCoord& at = edit.model.texcoords[edit.model.face_texcoords[face][i]];
      u += double{at.u} / 2;
      v += double{at.v} / 2;
    }
    const int x = std::min(static_cast<int>(u * image.width), image.width - 1);
    const int y = std::min(static_cast<int>(v * image.height), image.height - 1);
    const std::uint8_t* texel = image.at(x, y);
    return {double(texel[0]), double(texel[1]), double(texel[2])};
  }
  // Mean step, in grey levels, across the edges between charts of which one has one of the faces.
  double step(const Mesh& mesh, const labeling::FaceGraph& graph, const std::vector<std::uint8_t>& of) const {
    double sum = 0, count = 0;
    for (const auto& [a, b] : graph.edges) {
      if (edit.face_chart[a] == edit.face_chart[b] || (of[a] == 0 && of[b] == 0)) continue;
      std::vector<std::uint32_t> shared;
      for (const std::uint32_t v : mesh.faces[a])
        if (std::ranges::find(mesh.faces[b], v) != mesh.faces[b].end()) shared.push_back(v);
      if (shared.size() != 2) continue;
      const auto one = color(mesh, a, shared[0], shared[1]), other = color(mesh, b, shared[0], shared[1]);
      for (std::size_t c = 0; c < 3; ++c) sum += std::abs(one[c] - other[c]) / 3;
      ++count;
    }
    return count > 0 ? sum / count : 0;
  }
};

const io::Region kVetoedBlock = io::GroundRegion{{{2, 2}, {14, 2}, {14, 14}, {2, 14}}};

class Retexture : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    city_ = std::make_unique<City>();
    folder_ = std::make_unique<test::TemporaryFolder>();
    first_ = folder_->path() / "first";
    EditListener listener;
    run(settings(), {}, first_, listener);
  }
  static void TearDownTestSuite() {
    folder_.reset();
    city_.reset();
  }

  static pipeline::Settings settings(std::vector<pipeline::ViewRule> rules = {}) {
    pipeline::Settings settings;
    settings.editable = true;
    settings.atlas.page_size = 256;
    settings.view_rules = std::move(rules);
    return settings;
  }
  static checks::Input input() { return {city_->scene, city_->mesh, city_->views}; }
  static void run(const pipeline::Settings& settings, const fs::path& from, const fs::path& out,
                  results::Observer& observer) {
    WatchedPhotos photos(city_->scene);
    run(settings, from, out, observer, photos, input());
  }
  static void run(const pipeline::Settings& settings, const fs::path& from, const fs::path& out,
                  results::Observer& observer, io::PhotoSource& photos, const checks::Input& input) {
    results::OutputFolder folder(out, true, "texture");
    if (from.empty())
      pipeline::texture_into({input, settings, photos, observer}, folder);
    else
      pipeline::retexture_into(from, {input, settings, photos, observer}, folder);
    const fs::path json = folder.file("run.json");
    std::ofstream(json) << R"({"program": "gpvc", "command": "texture", "outputs": )" << json_list(folder.promised())
                        << "}";
    folder.publish();
  }
  static std::string json_list(const std::vector<std::string>& names) {
    std::string text = "[";
    for (const std::string& name : names) text += (text.size() > 1 ? ", \"" : "\"") + name + "\"";
    return text + "]";
  }
  // The view that most faces of the block show.
  static ViewId favourite(const SavedTexture& texture) {
    const std::vector<std::uint8_t> inside = io::faces_in(kVetoedBlock, city_->mesh);
    std::map<ViewId, std::size_t> faces;
    for (std::size_t f = 0; f < inside.size(); ++f)
      if (inside[f] != 0 && texture.edit.labels[f] != kNoView) ++faces[texture.edit.labels[f]];
    return std::ranges::max_element(faces, {}, [](const auto& item) { return item.second; })->first;
  }
  static std::vector<pipeline::ViewRule> veto(std::vector<ViewId> views) {
    return {{kVetoedBlock, false, views, "rule"}};
  }
  // Faces whose texels another result does not have.
  static std::vector<std::uint8_t> made(const SavedTexture& before, const SavedTexture& after) {
    std::vector<std::uint8_t> flags(before.edit.labels.size(), 0);
    for (std::size_t f = 0; f < flags.size(); ++f)
      flags[f] = before.edit.face_chart[f] != after.edit.face_chart[f] ? 1 : 0;
    return flags;
  }
  static std::string refused(const pipeline::Settings& settings, const fs::path& from, const checks::Input& input) {
    EditListener listener;
    WatchedPhotos photos(city_->scene);
    return test::input_error([&] { run(settings, from, folder_->path() / "refused", listener, photos, input); });
  }

  static inline std::unique_ptr<City> city_;
  static inline std::unique_ptr<test::TemporaryFolder> folder_;
  static inline fs::path first_;
  fs::path second_ = folder_->path() / "second", third_ = folder_->path() / "third";
  EditListener heard_;
};

TEST_F(Retexture, AVetoChangesItsRegionAloneAndKeepsThePages) {
  const SavedTexture before(first_);
  const ViewId vetoed = favourite(before);
  run(settings(veto({vetoed})), first_, second_, heard_);
  const SavedTexture after(second_);
  EditListener whole_run;
  run(settings(veto({vetoed})), {}, third_, whole_run);
  const SavedTexture whole(third_);

  const std::vector<std::uint8_t> inside = io::faces_in(kVetoedBlock, city_->mesh), is_made = made(before, after);
  EXPECT_EQ(after.tags, whole.tags);
  std::size_t relabeled = 0, outside = 0;
  for (std::size_t f = 0; f < inside.size(); ++f) {
    if (inside[f] != 0) {
      ASSERT_NE(after.edit.labels[f], vetoed) << f;
    }
    relabeled += inside[f] != 0 && after.edit.labels[f] != before.edit.labels[f];
    outside += inside[f] == 0 && is_made[f] != 0;
    if (is_made[f] != 0) continue;
    ASSERT_EQ(after.edit.labels[f], before.edit.labels[f]) << f;
    ASSERT_EQ(after.edit.model.face_page[f], before.edit.model.face_page[f]) << f;
    for (std::size_t i = 0; i < 3; ++i) {
      const io::TexCoord& was = before.edit.model.texcoords[before.edit.model.face_texcoords[f][i]];
      const io::TexCoord& is = after.edit.model.texcoords[after.edit.model.face_texcoords[f][i]];
      ASSERT_TRUE(was.u == is.u && was.v == is.v) << f;
    }
  }
  EXPECT_GT(relabeled, 50u);
  EXPECT_LT(outside, inside.size() / 10);

  ASSERT_GT(before.pages.size(), 1u);
  EXPECT_EQ(heard_.count("edit.pages_kept"), before.pages.size());
  EXPECT_EQ(heard_.count("edit.pages_kept") + heard_.count("edit.pages_made"), after.pages.size());
  for (std::size_t p = 0; p < before.pages.size(); ++p)
    EXPECT_EQ(test::read_file(SavedTexture::page(first_, p)), test::read_file(SavedTexture::page(second_, p))) << p;
  EXPECT_EQ(test::read_file(first_ / "edit-views.bin"), test::read_file(second_ / "edit-views.bin"));
  EXPECT_EQ(heard_.count("edit.faces_made"), static_cast<std::size_t>(std::ranges::count(is_made, 1)));
  EXPECT_GT(heard_.count("edit.charts_kept"), heard_.count("edit.charts_touched"));

  // As good as if all had been made anew.
  const double energy = std::get<double>(heard_.figures.at("energy"));
  EXPECT_LT(energy, 1.02 * std::get<double>(whole_run.figures.at("energy")));
  const labeling::FaceGraph graph = labeling::face_graph(city_->mesh);
  const double step = after.step(city_->mesh, graph, is_made), of_whole = whole.step(city_->mesh, graph, is_made);
  EXPECT_GT(of_whole, 0);
  EXPECT_LT(step, 1.1 * of_whole + 0.5);
}

TEST_F(Retexture, RulesCanBeTakenBackInPlace) {
  const SavedTexture before(first_);
  run(settings(veto({favourite(before)})), first_, second_, heard_);
  const SavedTexture vetoed(second_);
  run(settings(), second_, second_, heard_);
  const SavedTexture after(second_);
  EXPECT_EQ(after.tags, before.tags);
  EXPECT_EQ(test::read_file(SavedTexture::page(first_, 0)), test::read_file(SavedTexture::page(second_, 0)));
  const std::vector<std::uint8_t> inside = io::faces_in(kVetoedBlock, city_->mesh);
  std::size_t back = 0;
  for (std::size_t f = 0; f < inside.size(); ++f)
    back += inside[f] != 0 && after.edit.labels[f] != vetoed.edit.labels[f];
  EXPECT_GT(back, 50u);
}

TEST_F(Retexture, NothingToChangeIsACopy) {
  run(settings(), first_, second_, heard_);
  std::size_t files = 0;
  for (const auto& entry : fs::directory_iterator(first_)) {
    const fs::path name = entry.path().filename();
    if (name == "run.json" || name == "preview.png") continue;  // which is drawn from the pages as JPEG has left them
    EXPECT_EQ(test::read_file(entry), test::read_file(second_ / name)) << name;
    ++files;
  }
  EXPECT_GT(files, 8u);
  EXPECT_EQ(heard_.count("edit.faces_made"), 0u);
  EXPECT_TRUE(std::ranges::any_of(heard_.notes, [](const auto& n) { return n.starts_with("nothing changes"); }));
}

TEST_F(Retexture, FacesThatLoseAllPhotosAreFilledFromTheFinishedOnesAround) {
  const SavedTexture before(first_);
  run(settings(veto(city_->views)), first_, second_, heard_);
  const SavedTexture after(second_);
  const std::vector<std::uint8_t> inside = io::faces_in(kVetoedBlock, city_->mesh);
  for (std::size_t f = 0; f < inside.size(); ++f) {
    if (inside[f] == 0) continue;
    ASSERT_EQ(after.tags[f], 2) << f;
    ASSERT_EQ(after.edit.labels[f], kNoView) << f;
  }
  // Each corner of an unseen face on the border has the mean of the colours around it, so steps there are small.
  EXPECT_LT(after.step(city_->mesh, labeling::face_graph(city_->mesh), inside), 25);
}

TEST_F(Retexture, OnlyPhotosOfChangedFacesAreDecoded) {
  pipeline::Settings plain = settings();
  plain.atlas.blend = atlas::Blending::none;
  const fs::path from = folder_->path() / "plain";
  run(plain, {}, from, heard_);
  const SavedTexture before(from);
  // One of the block that many photos see.
  const std::vector<std::uint8_t> inside = io::faces_in(kVetoedBlock, city_->mesh);
  const ViewId most = favourite(before);
  std::uint32_t face = 0;
  while (inside[face] == 0 || before.tags[face] != 0 || before.edit.labels[face] != most) ++face;
  plain.view_rules = {{io::FaceRegion{{{face, face}}}, false, {before.edit.labels[face]}, "rule"}};
  WatchedPhotos photos(city_->scene);
  run(plain, from, second_, heard_, photos, input());
  const SavedTexture after(second_);
  std::set<ViewId> shown;
  bool partial = false;  // such faces are pieced together from other views, too
  const std::vector<std::uint8_t> is_made = made(before, after);
  for (std::size_t f = 0; f < is_made.size(); ++f) {
    if (is_made[f] == 0) continue;
    shown.insert(after.edit.labels[f]);
    partial |= after.tags[f] == 1;
  }
  ASSERT_NE(is_made[face], 0);
  EXPECT_TRUE(std::ranges::includes(photos.decoded, shown));
  EXPECT_TRUE(partial || photos.decoded == shown);
  EXPECT_LT(photos.decoded.size(), city_->views.size());
  EXPECT_GT(after.pages.size(), before.pages.size());

  plain.view_rules = {};
  run(plain, second_, third_, heard_);
  if (std::ranges::count(is_made, 1) == 1) {
    // No face is left on the page that the veto had made.
    EXPECT_EQ(heard_.count("edit.pages_kept"), before.pages.size());
  }
}

// Writes a kept result anew, under its key and with a hash that is right.
template <typename Write>
void rewrite(const fs::path& file, const Write& write) {
  const std::string bytes = test::read_file(file);
  io::WorkKey key;
  std::memcpy(&key, bytes.data() + 8, sizeof key);
  std::string body = bytes.substr(8 + sizeof key, bytes.size() - 8 - 2 * sizeof key);
  io::WorkStore(file.parent_path(), pipeline::kEditHashesFile)
      .keep(file.filename(), key, [&](io::WorkStore::Writer& out) { write(out, body); });
}

TEST_F(Retexture, ValuesThatNoResultHasAreRefusedThoughTheHashIsRight) {
  const fs::path copy = folder_->path() / "copy";
  const auto error_of_copy = [&] {
    WatchedPhotos photos(city_->scene);
    const auto error = test::caught([&] { run(settings(veto({ViewId{0}})), copy, second_, heard_, photos, input()); });
    return error ? std::string(error->what()) : std::string();
  };
  const auto with_model = [&](const auto& change) {
    fs::remove_all(copy);
    fs::copy(first_, copy, fs::copy_options::recursive);
    EditModel model = pipeline::read_edit_model(first_);
    change(model);
    rewrite(copy / "edit-model.bin", [&](io::WorkStore::Writer& out, const std::string&) { out.add(model); });
    return error_of_copy();
  };
  EXPECT_EQ(with_model([](EditModel&) {}), "");
  const auto expect_refused = [&](const char* what, const auto& change) {
    EXPECT_TRUE(test::contains(with_model(change), "edit-model.bin: holds values that no result")) << what;
  };
  expect_refused("label", [](EditModel& m) { m.labels[7] = ViewId{1000}; });
  expect_refused("labels", [](EditModel& m) { m.labels.pop_back(); });
  expect_refused("page", [](EditModel& m) { m.model.face_page[7] = 0x7FFFFFFF; });
  expect_refused("corner", [](EditModel& m) { m.model.face_texcoords[7][1] = 0x7FFFFFFF; });
  expect_refused("place", [](EditModel& m) { m.model.texcoords[7].u = 1e9f; });
  expect_refused("page files", [](EditModel& m) { m.page_files.clear(); });
  expect_refused("chart", [](EditModel& m) { m.face_chart[7] = 0xFFFFFFFF; });
  expect_refused("exposure", [](EditModel& m) { m.exposure.resize(2); });
  expect_refused("gain", [](EditModel& m) { m.exposure.at(1).gain[0] = 0; });
  expect_refused("size of a page", [](EditModel& m) { m.page_sizes[0][1] = -5; });
  expect_refused("large page", [](EditModel& m) { m.page_sizes[0] = {1 << 30, 1 << 30}; });
  expect_refused("reduction", [](EditModel& m) { m.reduction = -1; });
  expect_refused("rule", [](EditModel& m) { m.rules = veto({ViewId{1000}}); });

  // What one view sees, many times: a few bytes each, and a frame of bits.
  fs::remove_all(copy);
  fs::copy(first_, copy, fs::copy_options::recursive);
  rewrite(copy / "edit-views.bin", [&](io::WorkStore::Writer& out, const std::string& body) {
    const std::size_t count = city_->views.size();
    const std::string as_bytes(reinterpret_cast<const char*>(&count), sizeof count);
    std::string more = body;
    const std::size_t at = more.rfind(as_bytes + std::string(4, '\0'));  // the number of views, and the first of them
    ASSERT_NE(at, std::string::npos);
    more[at] = static_cast<char>(2 * count);
    more += body.substr(at + sizeof count);
    out.write(more.data(), more.size());
  });
  EXPECT_TRUE(test::contains(error_of_copy(), "edit-views.bin: is damaged"));

  std::mt19937 random(11);
  for (const char* name : {"edit-model.bin", "edit-views.bin"})
    for (int i = 0; i < 20; ++i) {
      fs::remove_all(copy);
      fs::copy(first_, copy, fs::copy_options::recursive);
      rewrite(copy / name, [&](io::WorkStore::Writer& out, std::string body) {
        const std::size_t at = random() % (body.size() - 64) / 4 * 4;
        for (std::size_t n = 0; n < 64; n += 4) std::memcpy(body.data() + at + n, "\xff\xff\xff\x7f", 4);
        out.write(body.data(), body.size());
      });
      error_of_copy();  // or used, as colours may be any
    }
}

TEST_F(Retexture, SaysWhatCannotBeChanged) {
  const auto with_file = [&](const std::string& name, const auto& change) {
    const fs::path copy = folder_->path() / "copy";
    fs::remove_all(copy);
    fs::copy(first_, copy, fs::copy_options::recursive);
    change(copy / name);
    return refused(settings(veto({ViewId{0}})), copy, input());
  };
  const auto overwrite = [](std::size_t at) {
    return [at](const fs::path& file) {
      std::fstream out(file, std::ios::binary | std::ios::in | std::ios::out);
      out.seekp(static_cast<std::streamoff>(at));
      out.write("?!", 2);
    };
  };
  const auto remove = [](const fs::path& file) { fs::remove(file); };
  const auto contains = [](const std::string& text, const char* part) { return test::contains(text, part); };
  EXPECT_PRED2(contains, with_file("model.obj", remove), "copy: holds no textured model");
  EXPECT_PRED2(contains, with_file("edit-model.bin", remove),
               "edit-model.bin: is missing, without which the result cannot be changed");
  EXPECT_EQ(test::cures_of([&] { pipeline::read_edit_model(folder_->path() / "copy"); }),
            std::vector{Cure::make_editable});
  EXPECT_PRED2(contains, with_file("edit-views.bin", remove), "edit-views.bin: is missing");
  EXPECT_PRED2(contains, with_file("edit-hashes.txt", remove), "edit-hashes.txt: is missing");
  EXPECT_PRED2(contains, with_file("edit-model.bin", overwrite(9)), "edit-model.bin: is of another version of gpvc");
  EXPECT_PRED2(contains, with_file("edit-model.bin", overwrite(500)), "edit-model.bin: is damaged");
  EXPECT_PRED2(contains, with_file("edit-views.bin", overwrite(500)), "edit-views.bin: is damaged");
  EXPECT_PRED2(contains, with_file("model_0.jpg", remove), "model_0.jpg");
  EXPECT_PRED2(contains,
               with_file("model_0.jpg", [&](const fs::path& file) { overwrite(fs::file_size(file) / 2)(file); }),
               "model_0.jpg: is not the page that was written there");
  EXPECT_PRED2(contains,
               with_file("model_0.jpg",
                         [&](const fs::path& file) {
                           fs::copy_file(file.parent_path() / "preview.png", file,
                                         fs::copy_options::overwrite_existing);
                         }),
               "model_0.jpg");

  Mesh mesh = city_->mesh;
  mesh.positions[0].z += 0.5;
  EXPECT_PRED2(contains, refused(settings(), first_, {city_->scene, mesh, city_->views}),
               "was textured from another mesh; only the rules about photos");
  EXPECT_PRED2(
      contains, refused(settings(), first_, {city_->scene, city_->mesh, std::span(city_->views).first(5)}),
      ("was textured with photos that are not among those given: " + city_->scene.views[5].name + ";").c_str());
  Scene moved = city_->scene;
  moved.views[2].pose.centre.x += 1;
  EXPECT_PRED2(contains, refused(settings(), first_, {moved, city_->mesh, city_->views}),
               ("was textured with other cameras or poses of " + moved.views[2].name + ";").c_str());
  pipeline::Settings other = settings();
  other.atlas.padding = 4;
  EXPECT_PRED2(contains, refused(other, first_, input()), "was textured with padding 8, and 4 is asked for now");
  other = settings();
  other.costs.term = labeling::DataTerm::gmi;
  EXPECT_PRED2(contains, refused(other, first_, input()),
               "was textured with data-term area-angle, and gmi is asked for");
}

}  // namespace
}  // namespace gpvc
