// gpvc texture --layers: further photos on the same pages.
#include <algorithm>

#include "io/images.h"
#include "io/textured_model.h"
#include "tests/app/app_fixture.h"

namespace gpvc {
namespace {

using namespace test;

class Layers : public App {
 protected:
  // Photos of the scene's names and sizes, each of one grey level, which says which view it is of.
  fs::path classes() const {
    const fs::path folder = folder_.path() / "classes";
    fs::create_directories(folder);
    for (const fs::directory_entry& photo : fs::directory_iterator(scene_ / "images")) {
      Image flat = io::read_image(photo.path());
      std::ranges::fill(flat.pixels.data(), flat.pixels.data() + flat.pixels.size(), level_of(photo.path().filename()));
      io::write_image(folder / photo.path().filename(), flat, io::ImageFormat::jpg, 100);
    }
    return folder;
  }
  fs::path five_bands() const {
    const fs::path folder = folder_.path() / "five_bands";
    fs::create_directories(folder);
    for (const fs::directory_entry& photo : fs::directory_iterator(scene_ / "images")) {
      const io::ImageSize size = io::read_image_size(photo.path());
      Samples samples{size.width, size.height, 5, SampleType::u8, {}};
      samples.bytes.resize(pixel_index(0, size.height, size.width) * 5);
      // What they are, their first bytes say.
      const fs::path file = folder / photo.path().filename(), tiff = fs::path(file).replace_extension(".tif");
      io::write_samples(tiff, samples, {SampleType::u8, std::vector<Band>(5)});
      fs::rename(tiff, file);
    }
    return folder;
  }
  std::uint8_t level_of(const fs::path& photo) const {
    std::vector<fs::path> all;
    for (const fs::directory_entry& each : fs::directory_iterator(scene_ / "images"))
      all.push_back(each.path().filename());
    std::ranges::sort(all);
    return static_cast<std::uint8_t>(20 + 30 * (std::ranges::find(all, photo) - all.begin()));
  }
  // In the middle of each face that is seen whole, the layer shows the photo that the model shows.
  void expect_classes(const fs::path& out, const std::string& model_file = "model.obj") const {
    const io::LoadedModel model = io::read_textured_model(out / model_file);
    const auto labels = npy<std::int32_t>(out / "labels.npy");
    const auto tags = npy<std::uint8_t>(out / "tags.npy");
    std::vector<int> levels;
    const auto views = nlohmann::json::parse(read_file(out / "views.json"));
    for (const auto& view : views["views"]) levels.push_back(level_of(view["name"].get<std::string>()));
    std::vector<Image> pages;
    for (std::size_t n = 0; n < model.pages.size(); ++n) {
      pages.push_back(io::read_image(out / "layers" / "classes" / ("model_" + std::to_string(n) + ".png")));
      ASSERT_EQ(pages[n].width, model.pages[n].width);
      ASSERT_EQ(pages[n].height, model.pages[n].height);
    }
    std::size_t looked_at = 0, wrong = 0;
    for (std::size_t f = 0; f < labels.size(); ++f) {
      if (tags[f] != 0) continue;
      double u = 0, v = 0;
      for (const std::uint32_t t : model.model.face_texcoords[f]) {
        u += double{model.model.texcoords[t].u} / 3;
        v += double{model.model.texcoords[t].v} / 3;
      }
      const Image& page = pages[model.model.face_page[f]];
      const std::uint8_t* texel = page.at(static_cast<int>(u * page.width), static_cast<int>(v * page.height));
      ++looked_at;
      wrong += std::abs(texel[0] - levels[static_cast<std::size_t>(labels[f])]) > 2;
    }
    EXPECT_GT(looked_at, 100u);
    EXPECT_LT(wrong, looked_at / 100) << "of faces thinner than a texel";
  }
};

TEST_F(Layers, LieOnTheModelsPagesWithTheirValues) {
  const std::string layer = classes().string();
  const test::Outcome outcome = run(texture(out_, {"--texture", "png", "--layers", layer}));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  expect_classes(out_);
  const test::Outcome alone = run(texture(folder_.path() / "alone", {"--texture", "png"}));
  ASSERT_EQ(alone.exit_code, 0);
  EXPECT_EQ(read_file(out_ / "model.glb"), read_file(folder_.path() / "alone" / "model.glb")) << "as without";
  EXPECT_TRUE(contains(read_file(out_ / "run.json"), "layers/classes/model_0.png")) << "what a later run may replace";
}

TEST_F(Layers, OfTheSamePhotosAreTheModelsPages) {
  const fs::path again = folder_.path() / "again";
  fs::copy(scene_ / "images", again, fs::copy_options::recursive);
  const test::Outcome outcome = run(texture(out_, {"--texture", "png", "--level-layers", "--layers", again.string()}));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(read_file(out_ / "layers" / "again" / "model_0.png"), read_file(out_ / "model_0.png"));
}

TEST_F(Layers, LieOnTextureCoordinatesThatAreKept) {
  const fs::path first = folder_.path() / "first";
  ASSERT_EQ(run(texture(first, {"--texture", "png"})).exit_code, 0);
  std::vector<std::string> words = texture(out_, {"--keep-uv", "--texture", "png", "--layers", classes().string()});
  words[2] = (first / "model.obj").string();
  const test::Outcome outcome = run(words);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  expect_classes(out_);
}

TEST_F(Layers, LieOnTheFinishedResultThatIsChanged) {
  const fs::path first = folder_.path() / "first", rules = folder_.path() / "rules.csv";
  ASSERT_EQ(run(texture(first, {"--texture", "png", "--editable"})).exit_code, 0);
  const std::string layer = classes().string();
  const test::Outcome same = run(texture(out_, {"--texture", "png", "--from", first.string(), "--layers", layer}));
  ASSERT_EQ(same.exit_code, 0) << same.err;
  expect_classes(out_);
  EXPECT_EQ(read_file(out_ / "model_0.png"), read_file(first / "model_0.png"));
  const std::string name = nlohmann::json::parse(read_file(first / "views.json"))["views"][0]["name"];
  std::ofstream(rules) << "photo," << name << " 0 0 200 200\n";
  const fs::path changed = folder_.path() / "changed";
  const test::Outcome outcome = run(
      texture(changed, {"--texture", "png", "--from", first.string(), "--allow", rules.string(), "--layers", layer}));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_GT(run_json(changed)["counts"]["edit"]["faces_made"], 0);
  expect_classes(changed);
}

TEST_F(Layers, AreRefusedInOneSentence) {
  const fs::path layer = classes();
  expect_one_sentence(run(texture(out_, {"--layers", (folder_.path() / "none").string()})), "none",
                      "is no folder of photos");
  const fs::path photo = fs::directory_iterator(layer)->path();
  Image small = io::read_image(photo);
  io::write_image(photo, io::reduce_image(small, 2), io::ImageFormat::jpg, 90);
  expect_one_sentence(run(texture(out_, {"--layers", layer.string()})), photo.filename().string(),
                      "the size of the photo that it lies over");
  fs::remove(photo);
  expect_one_sentence(run(texture(out_, {"--layers", layer.string()})), photo.filename().string(), "");
  EXPECT_FALSE(fs::exists(out_));
  // Before anything is baked.
  const test::Outcome bands =
      run(texture(out_, {"--layers", five_bands().string(), "--band-format", "png", "--verbose"}));
  expect_one_sentence(bands, "five_bands", "holds 5 bands of u8, and a PNG holds 1 to 4 of u8 or u16");
  EXPECT_FALSE(contains(bands.err, "bake"));
  EXPECT_FALSE(fs::exists(out_));
  EXPECT_EQ(run(texture(out_, {"--level-layers"})).exit_code, 2);
  EXPECT_EQ(run(texture(out_, {"--layers", layer.string(), layer.string() + "/"})).exit_code, 2);
}

}  // namespace
}  // namespace gpvc
