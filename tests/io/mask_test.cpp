// Masks and alpha channels: which are found, what they exclude, and that no colour of theirs is ever handed out.
#include <OpenImageIO/imageio.h>

#include <fstream>

#include "io/images.h"
#include "io/photos.h"
#include "io/scene_files.h"
#include "tests/support/temporary_folder.h"

namespace gpvc::io {
namespace {

using test::contains;
using test::input_error;
using test::TemporaryFolder;

constexpr int kMaskWidth = 70, kMaskHeight = 50;  // more than a word a row
using Bytes = std::vector<std::uint8_t>;

template <typename T>
void store(const std::filesystem::path& file, int width, int height, int channels, OIIO::TypeDesc type,
           const std::vector<T>& samples) {
  std::filesystem::create_directories(file.parent_path());
  OIIO::ImageSpec spec(width, height, channels, type);
  spec["oiio:UnassociatedAlpha"] = 1;
  const auto out = OIIO::ImageOutput::create(file.string());
  ASSERT_TRUE(out && out->open(file.string(), spec) && out->write_image(type, samples.data()) && out->close());
}

/// Two photos of mid grey in a sub-folder, as a COLMAP scene.
class Masks : public testing::Test {
 protected:
  void SetUp() override {
    folder_.write("sparse/cameras.txt", "1 PINHOLE 70 50 60 60 35 25\n");
    folder_.write("sparse/images.txt", "1 1 0 0 0 0 0 0 1 a/p.tif\n\n2 1 0 0 0 0 0 0 1 a/q.jpg\n\n");
    store(photo("p.tif"), kMaskWidth, kMaskHeight, 3, OIIO::TypeUInt8, Bytes(3 * kMaskWidth * kMaskHeight, 128));
    write_image(photo("q.jpg"), {kMaskWidth, kMaskHeight, 3, Bytes(3 * kMaskWidth * kMaskHeight, 128)},
                ImageFormat::jpg, 100);
  }
  std::filesystem::path photo(const std::string& name) const { return folder_.path() / "images" / "a" / name; }
  /// White but for a black block.
  static Bytes block(int x0, int y0, int x1, int y1, int channels = 1) {
    Bytes samples(static_cast<std::size_t>(kMaskWidth * kMaskHeight * channels), 255);
    for (int y = y0; y < y1; ++y)
      for (int x = x0; x < x1; ++x)
        for (int c = 0; c < channels; ++c) samples[static_cast<std::size_t>((y * kMaskWidth + x) * channels + c)] = 0;
    return samples;
  }
  void mask(const std::filesystem::path& file, const Bytes& samples, int channels = 1) const {
    store(file, kMaskWidth, kMaskHeight, channels, OIIO::TypeUInt8, samples);
  }
  Scene scene(const SceneOptions& options = {}) const { return read_scene(folder_.path() / "sparse", options); }
  static void expect_block(const std::optional<PhotoExclusion>& found, int x0, int y0, int x1, int y1) {
    ASSERT_TRUE(found);
    for (int y = 0; y < found->height; ++y)
      for (int x = 0; x < found->width; ++x)
        ASSERT_EQ(found->excludes(x, y), x >= x0 && y >= y0 && x < x1 && y < y1) << x << ", " << y;
  }
  TemporaryFolder folder_;
};

TEST_F(Masks, AreFoundBesideThePhotoByWholeNameFirst) {
  EXPECT_FALSE(read_exclusion(scene().views[0]));
  mask(photo("p.mask.png"), block(1, 2, 5, 6));
  EXPECT_EQ(scene().views[0].mask, photo("p.mask.png"));
  mask(photo("p.tif.mask.png"), block(60, 10, 70, 50));
  const Scene both = scene();
  EXPECT_EQ(both.views[0].mask, photo("p.tif.mask.png"));
  EXPECT_TRUE(both.views[1].mask.empty());
  expect_block(read_exclusion(both.views[0]), 60, 10, 70, 50);
  SceneOptions none;
  none.masks = false;
  EXPECT_TRUE(scene(none).views[0].mask.empty());
}

TEST_F(Masks, AreFoundInAFolderOfTheirOwn) {
  mask(photo("p.tif.mask.png"), block(0, 0, 1, 1));  // not asked
  SceneOptions options;
  options.masks_dir = folder_.path() / "masks";
  EXPECT_TRUE(contains(input_error([&] { scene(options); }), "masks: is not a folder"));
  std::filesystem::create_directories(*options.masks_dir / "a");
  EXPECT_TRUE(contains(input_error([&] { scene(options); }),
                       "holds no mask of any photo; expected names like a/p.tif.mask.png, a/p.tif.png or a/p.tif, it "
                       "holds no file"));
  folder_.write("masks/a/other.png", "");
  EXPECT_TRUE(contains(input_error([&] { scene(options); }), "or a/p.tif, found a/other.png"));
  mask(*options.masks_dir / "a" / "p.tif.png", block(3, 3, 9, 9));  // COLMAP's spelling
  mask(*options.masks_dir / "q.mask.png", block(4, 4, 9, 9));       // without the sub-folder
  const Scene found = scene(options);
  expect_block(read_exclusion(found.views[0]), 3, 3, 9, 9);
  expect_block(read_exclusion(found.views[1]), 4, 4, 9, 9);
}

TEST_F(Masks, OfAnotherSizeAreRefusedAtOnce) {
  store(photo("q.mask.png"), 35, 25, 1, OIIO::TypeUInt8, Bytes(35 * 25, 255));
  const std::string error = input_error([&] { scene(); });
  EXPECT_TRUE(contains(error, "q.mask.png: is 35 x 25 pixels, its photo q.jpg is 70 x 50"));
}

TEST_F(Masks, BlackIsZeroInEveryColorAndNothingElse) {
  const auto file = photo("p.tif.mask.png");
  // 0/1 masks, red labels, and 1 of 65535 are no black.
  Bytes ones = block(7, 7, 9, 9);
  for (std::uint8_t& sample : ones) sample = sample == 0 ? 0 : 1;
  mask(file, ones);
  expect_block(read_exclusion(scene().views[0]), 7, 7, 9, 9);
  Bytes red = block(7, 7, 9, 9, 3);
  for (std::size_t i = 0; i < red.size(); ++i)
    if (i % 3 != 0) red[i] = 0;
  mask(file, red, 3);
  expect_block(read_exclusion(scene().views[0]), 7, 7, 9, 9);
  std::vector<std::uint16_t> deep(kMaskWidth * kMaskHeight, 1);
  deep[0] = 0;
  store(file, kMaskWidth, kMaskHeight, 1, OIIO::TypeUInt16, deep);
  expect_block(read_exclusion(scene().views[0]), 0, 0, 1, 1);
  // White where opaque, anything where transparent.
  Bytes with_alpha(4 * kMaskWidth * kMaskHeight, 255);
  with_alpha[3] = 0;
  mask(file, with_alpha, 4);
  expect_block(read_exclusion(scene().views[0]), 0, 0, 1, 1);
  mask(file, Bytes(kMaskWidth * kMaskHeight, 255));
  EXPECT_FALSE(read_exclusion(scene().views[0]));
}

// Two blocks, of what JPEG and resampling make of black, and a ramp between black and white.
TEST_F(Masks, OfGreyAreDecidedAtHalf) {
  Bytes soft = block(0, 0, 10, 10);
  for (std::uint8_t& sample : soft) sample = sample == 0 ? 6 : 251;
  for (int x = 20; x < 30; ++x)
    for (int y = 0; y < kMaskHeight; ++y) soft[static_cast<std::size_t>(y * kMaskWidth + x)] = x < 25 ? 120 : 140;
  mask(photo("p.tif.mask.png"), soft);
  const auto expect_decided = [](const std::optional<PhotoExclusion>& found) {
    ASSERT_TRUE(found);
    for (int y = 0; y < kMaskHeight; ++y)
      for (int x = 0; x < kMaskWidth; ++x)
        ASSERT_EQ(found->excludes(x, y), (x < 10 && y < 10) || (x >= 20 && x < 25)) << x << ", " << y;
  };
  const Scene made = scene();
  expect_decided(read_exclusion(made.views[0]));
  EXPECT_TRUE(contains(made.warnings.at(0), "100.0 % of a mask's pixels are grey"));
  EXPECT_FALSE(has_plain_mask(made.views[0]));  // other programs would exclude nothing
  std::filesystem::remove(photo("p.tif.mask.png"));
  mask(photo("p.tif.mask.png"), block(0, 0, 10, 10));
  EXPECT_TRUE(scene().warnings.empty());
  // In a lossy file 1 is no label.
  std::filesystem::remove(photo("p.tif.mask.png"));
  write_image(photo("p.tif.mask.jpg"), {kMaskWidth, kMaskHeight, 1, Bytes(kMaskWidth * kMaskHeight, 3)},
              ImageFormat::jpg, 100);
  expect_block(read_exclusion(scene().views[0]), 0, 0, kMaskWidth, kMaskHeight);
}

TEST_F(Masks, AreFoundUnderThePhotosOwnNameInAnyCase) {
  SceneOptions options;
  options.masks_dir = folder_.path() / "masks";
  mask(*options.masks_dir / "P.TIF", block(3, 3, 9, 9));
  std::filesystem::create_directories(*options.masks_dir / "a");
  write_image(*options.masks_dir / "a" / "q.jpg", {kMaskWidth, kMaskHeight, 1, block(8, 8, 16, 16)}, ImageFormat::jpg,
              100);
  const Scene found = scene(options);
  expect_block(read_exclusion(found.views[0]), 3, 3, 9, 9);
  expect_block(read_exclusion(found.views[1]), 8, 8, 16, 16);
  options.masks_dir = folder_.path() / "images";  // a photo is no mask of its own
  EXPECT_TRUE(contains(input_error([&] { scene(options); }), "holds no mask of any photo"));
}

TEST_F(Masks, OfAnotherSizeAreNamedAllAtOnce) {
  store(photo("p.mask.png"), 35, 25, 1, OIIO::TypeUInt8, Bytes(35 * 25, 255));
  store(photo("q.mask.png"), 35, 25, 1, OIIO::TypeUInt8, Bytes(35 * 25, 255));
  const std::string error = input_error([&] { scene(); });
  EXPECT_TRUE(contains(error, "2 masks cannot be used: "));
  EXPECT_TRUE(contains(error, "p.mask.png: is 35 x 25") && contains(error, "q.mask.png: is 35 x 25"));
}

TEST_F(Masks, AlphaOfAPhotoExcludesAndJoinsItsMask) {
  Bytes rgba(4 * kMaskWidth * kMaskHeight, 200);
  for (int x = 0; x < 10; ++x) rgba[static_cast<std::size_t>(4 * x + 3)] = 0;
  store(photo("p.tif"), kMaskWidth, kMaskHeight, 4, OIIO::TypeUInt8, rgba);
  EXPECT_TRUE(scene().views[0].uses_alpha);
  expect_block(read_exclusion(scene().views[0]), 0, 0, 10, 1);
  mask(photo("p.mask.png"), block(10, 0, 20, 1));
  expect_block(read_exclusion(scene().views[0]), 0, 0, 20, 1);
  SceneOptions none;
  none.masks = false;
  EXPECT_FALSE(read_exclusion(scene(none).views[0]));
}

// Programs write PNG and WebP under such names.
TEST_F(Masks, AlphaIsFoundInAPngThatIsCalledAJpeg) {
  Bytes rgba(4 * kMaskWidth * kMaskHeight, 200);
  for (int x = 0; x < 10; ++x) rgba[static_cast<std::size_t>(4 * x + 3)] = 0;
  store(photo("q.png"), kMaskWidth, kMaskHeight, 4, OIIO::TypeUInt8, rgba);
  EXPECT_FALSE(scene().views[1].uses_alpha);
  std::filesystem::rename(photo("q.png"), photo("q.jpg"));
  ASSERT_TRUE(scene().views[1].uses_alpha);
  expect_block(read_exclusion(scene().views[1]), 0, 0, 10, 1);
}

// At any depth and reduction.
TEST_F(Masks, AlphaComesWithThePhoto) {
  std::vector<std::uint16_t> deep(4 * kMaskWidth * kMaskHeight, 40000);
  for (int x = 0; x < 20; ++x)
    deep[static_cast<std::size_t>(4 * x + 3)] = x < 10 ? 0 : 1;  // which 8 bits can't tell apart
  store(photo("p.tif"), kMaskWidth, kMaskHeight, 4, OIIO::TypeUInt16, deep);
  Bytes rgba(deep.size(), 200);
  for (int x = 0; x < 10; ++x) rgba[static_cast<std::size_t>(4 * x + 3)] = 0;
  const auto with_photo = [&](const Scene& scene) {
    PhotoCache cache(scene);
    const auto exclusion = cache.exclusion(ViewId{0});
    EXPECT_EQ(cache.photo(ViewId{0})->pixels.size(), 3 * pixel_index(0, exclusion->height, exclusion->width));
    EXPECT_EQ(cache.decodes().times, 1u);
    return *exclusion;
  };
  expect_block(with_photo(scene()), 0, 0, 10, 1);
  store(photo("p.tif"), kMaskWidth, kMaskHeight, 4, OIIO::TypeUInt8, rgba);
  expect_block(with_photo(scene()), 0, 0, 10, 1);
  mask(photo("p.mask.png"), block(10, 0, 20, 1));
  expect_block(with_photo(scene()), 0, 0, 20, 1);
  SceneOptions half;
  half.downscale = 2;
  expect_block(with_photo(scene(half)), 0, 0, 10, 1);
}

TEST_F(Masks, TheFourthByteOfABmpIsNone) {
  // 32 bits a pixel, uncompressed: the fourth is reserved, and 0.
  std::string bmp = "BM" + test::bytes_of<std::uint32_t>(54 + 4 * kMaskWidth * kMaskHeight) + std::string(4, '\0') +
                    test::bytes_of<std::uint32_t>(54) + test::bytes_of<std::uint32_t>(40) +
                    test::bytes_of<std::int32_t>(kMaskWidth) + test::bytes_of<std::int32_t>(kMaskHeight) +
                    test::bytes_of<std::uint16_t>(1) + test::bytes_of<std::uint16_t>(32) + std::string(24, '\0');
  for (int i = 0; i < kMaskWidth * kMaskHeight; ++i) bmp += std::string("\x60\x70\x80\0", 4);
  std::ofstream(photo("p.bmp"), std::ios::binary) << bmp;
  folder_.write("sparse/images.txt", "1 1 0 0 0 0 0 0 1 a/p.bmp\n\n");
  ASSERT_EQ(scene().views[0].photo, photo("p.bmp"));
  EXPECT_FALSE(scene().views[0].uses_alpha);
  EXPECT_FALSE(read_exclusion(scene().views[0]));
}

TEST_F(Masks, ReduceWithThePhotoToBlocksWithAnExcludedPixel) {
  mask(photo("p.mask.png"), block(5, 4, 10, 8));
  SceneOptions options;
  options.downscale = 3;
  const Scene reduced = scene(options);
  const auto found = read_exclusion(reduced.views[0]);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->width, 23);
  EXPECT_EQ(found->height, 16);
  expect_block(found, 1, 1, 4, 3);
}

// A photo of a gradient with a block of magenta: masked, no trace of it is left at any reduction.
TEST_F(Masks, ExcludedColorsAreNeverHandedOut) {
  Bytes rgb;
  for (int y = 0; y < kMaskHeight; ++y)
    for (int x = 0; x < kMaskWidth; ++x) {
      const bool marked = x >= 20 && y >= 10 && x < 45 && y < 37;
      for (const int value : {marked ? 255 : 2 * x, marked ? 0 : 100 + y, marked ? 255 : 30})
        rgb.push_back(static_cast<std::uint8_t>(value));
    }
  store(photo("p.tif"), kMaskWidth, kMaskHeight, 3, OIIO::TypeUInt8, rgb);
  mask(photo("p.tif.mask.png"), block(20, 10, 45, 37));
  for (const int factor : {1, 2, 5}) {
    SceneOptions options;
    options.downscale = factor;
    const Scene made = scene(options);
    PhotoCache cache(made, 1 << 20);
    const auto image = cache.photo(ViewId{0});
    for (int y = 0; y < image->height; ++y)
      for (int x = 0; x < image->width; ++x) {
        ASSERT_EQ(image->at(x, y)[2], 30) << x << ", " << y << " of 1/" << factor;
        // From the surroundings: within the photo's own range.
        ASSERT_GE(image->at(x, y)[1], 100);
        ASSERT_LT(image->at(x, y)[1], 150);
      }
    options.masks = false;
    const Scene unmasked = scene(options);
    PhotoCache plain(unmasked, 1 << 20);
    EXPECT_EQ(plain.photo(ViewId{0})->at(30 / factor, 20 / factor)[2], 255);
  }
}

TEST_F(Masks, OfAWholePhotoLeaveItAsItIs) {
  mask(photo("p.tif.mask.png"), Bytes(kMaskWidth * kMaskHeight, 0));
  const Scene made = scene();
  PhotoCache cache(made, 1 << 20);
  EXPECT_EQ(cache.photo(ViewId{0})->pixels, Bytes(3 * kMaskWidth * kMaskHeight, 128));
  expect_block(read_exclusion(made.views[0]), 0, 0, kMaskWidth, kMaskHeight);
}

TEST_F(Masks, ThatCannotBeReadAreNamed) {
  folder_.write("images/a/q.jpg.mask.png", "no png");
  EXPECT_TRUE(contains(input_error([&] { scene(); }), "q.jpg.mask.png: is no image"));
}

}  // namespace
}  // namespace gpvc::io
