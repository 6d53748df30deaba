// A model within its bytes: what gives way, and in which order.
#include "app/pipeline/web_model.h"

#include <random>

#include "io/photos.h"
#include "tests/support/errors.h"
#include "tests/support/temporary_folder.h"

namespace gpvc::pipeline {
namespace {

using test::contains;

// A square on a page of noise, which is hard to compress.
struct NoisySquare {
  explicit NoisySquare(int edge = 512) {
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
    mesh.faces = {{0, 1, 2}, {3, 2, 1}};
    model.mesh = &mesh;
    model.texcoords = {{0, 0}, {1, 0}, {0, 1}, {1, 1}};
    model.face_texcoords = mesh.faces;
    model.face_page = {0, 0};
    Image page{edge, edge, 3, {}};
    std::mt19937 random(1);
    for (int i = 0; i < 3 * edge * edge; ++i) page.pixels.push_back(static_cast<std::uint8_t>(random() % 256));
    pages = {{folder.path() / "model_0.png", io::ImageFormat::png}};
    io::write_image(pages[0].file, page, io::ImageFormat::png, 0);
    settings.output.target = Target::web;
    options.coding = io::GltfCoding::quantized;
  }
  WebModel written(std::size_t max_bytes) {
    settings.output.max_bytes = max_bytes;
    return write_web_model({input, settings, photos, observer}, folder.path() / "model", model, pages, options);
  }
  std::size_t size() const { return std::filesystem::file_size(folder.path() / "model.glb"); }

  test::TemporaryFolder folder;
  Scene scene;
  Mesh mesh;
  io::TexturedModel model;
  std::vector<io::PageFile> pages;
  Settings settings;
  io::ModelOptions options;
  Observer observer;
  const Input input{scene, mesh, {}};
  io::CallbackSource photos{scene, [](ViewId) { return io::Picture{}; }};
};

TEST(WebModel, QualityFallsFirstThenTexels) {
  NoisySquare square;
  const WebModel all = square.written(0);
  EXPECT_EQ(all.pages.quality, 85);
  EXPECT_EQ(all.bytes, square.size());
  int reduction = 1;
  for (const double share : {0.8, 0.6, 0.3, 0.1, 0.03}) {
    const auto most = static_cast<std::size_t>(share * static_cast<double>(all.bytes));
    const WebModel model = square.written(most);
    EXPECT_LE(square.size(), most);
    EXPECT_EQ(model.bytes, square.size());
    EXPECT_GE(model.pages.quality, 50);
    EXPECT_GE(model.pages.reduction, reduction) << share;
    if (share == 0.8) {
      EXPECT_LT(model.pages.quality, 85);
      EXPECT_EQ(model.pages.reduction, 1) << "quality falls first";
    }
    const io::LoadedModel back = io::read_textured_model(square.folder.path() / "model.glb");
    EXPECT_EQ(back.pages[0].width, 512 / model.pages.reduction);
    reduction = model.pages.reduction;
  }
  EXPECT_GE(reduction, 4);
  EXPECT_EQ(square.folder.count(), 2u) << "the page that it was made from and the GLB";
}

TEST(WebModel, LowQualityThatIsAskedForIsKept) {
  NoisySquare square;
  square.settings.output.webp_quality = 20;
  EXPECT_EQ(square.written(0).pages.quality, 20);
}

TEST(WebModel, IsRefusedWhereNothingHelps) {
  NoisySquare square;
  const auto error = test::caught([&] { square.written(6000); });
  ASSERT_TRUE(error.has_value());
  EXPECT_TRUE(contains(error->what(), "model.glb: would have ")) << error->what();
  EXPECT_TRUE(contains(error->what(), "with the smallest pages")) << error->what();
  EXPECT_EQ(error->cures(), (std::vector{Cure::more_bytes, Cure::fewer_faces}));
  EXPECT_FALSE(std::filesystem::exists(square.folder.path() / "model.glb"));
}

TEST(WebModel, PagesOfOddEdgesKeepTheirSize) {
  NoisySquare square(511);
  const WebModel model = square.written(0);
  EXPECT_FALSE(model.pages.can_shrink) << "a column would be cut off, and texture coordinates mean other places";
  // Nor is their fallback smaller.
  square.settings.output.gltf = io::GltfContainer::files;
  EXPECT_EQ(square.written(0).pages.files[0].fallback, square.pages[0].file);
}

TEST(WithTarget, LeavesFullModelsAlone) {
  Settings settings;
  settings = with_target(settings, 1000);
  EXPECT_EQ(settings.atlas.max_pages, 0u);
  EXPECT_EQ(settings.output.max_bytes, 0u);
}

TEST(WithTarget, AsksForOnePageAndTheTexelsThatFit) {
  Settings settings;
  settings.output.target = Target::web;
  EXPECT_EQ(with_target(settings, 500000).atlas.max_pages, 1u);
  EXPECT_EQ(with_target(settings, 500000).atlas.max_texels, 0u) << "150 MB hold more than a page of 8192";
  EXPECT_EQ(with_target(settings, 500000).output.max_bytes, kWebBytes);
  settings.output.max_bytes = 10'000'000;
  const Settings small = with_target(settings, 500000);
  EXPECT_GT(small.atlas.max_texels, 20'000'000u);
  EXPECT_LT(small.atlas.max_texels, 50'000'000u);
  EXPECT_LT(with_target(settings, 1'000'000).atlas.max_texels, small.atlas.max_texels);
  EXPECT_EQ(with_target(small, 500000).atlas.max_texels, small.atlas.max_texels) << "twice is once";
  settings.atlas.max_pages = 3;
  settings.atlas.max_texels = 5000;
  EXPECT_EQ(with_target(settings, 500000).atlas.max_pages, 3u);
  EXPECT_EQ(with_target(settings, 500000).atlas.max_texels, 5000u);
  EXPECT_EQ(test::cures_of([&] { with_target(settings, 20'000'000); }),
            (std::vector{Cure::more_bytes, Cure::fewer_faces}));
}

}  // namespace
}  // namespace gpvc::pipeline
