#include "io/photos.h"
#include "io/scene_files.h"
#include "tests/support/errors.h"
#include "tests/support/scene_folder.h"
#include "tests/support/zip_archive.h"

namespace gpvc::io {
namespace {

using test::contains;
using test::input_error;

// A COLMAP text model of pinhole cameras, 40 x 30.
class Photos {
 public:
  explicit Photos(const std::vector<std::string>& names, int width = 40, int height = 30) {
    folder.write("model/cameras.txt",
                 "1 PINHOLE " + std::to_string(width) + " " + std::to_string(height) + " 50 51 21 14\n");
    std::string images;
    for (std::size_t i = 0; i < names.size(); ++i)
      images += std::to_string(i) + " 1 0 0 0 " + std::to_string(i) + " 0 0 1 " + names[i] + "\n\n";
    folder.write("model/images.txt", images);
  }
  void photo(const std::string& name, int width = 40, int height = 30) const {
    test::write_photo(folder.path() / "photos" / name, width, height);
  }
  Scene read(bool allow_missing = false) const {
    return read_scene(folder.path() / "model",
                      {.images_dir = folder.path() / "photos", .allow_missing_photos = allow_missing});
  }
  std::string found(std::size_t view) const {
    return read().views[view].photo.lexically_relative(folder.path() / "photos").string();
  }
  test::TemporaryFolder folder;
};

/// Reads with photos needed by these views alone.
Scene read_for(const Photos& files, const std::vector<std::string>& needed, bool allow_missing = false) {
  SceneOptions options{.images_dir = files.folder.path() / "photos", .allow_missing_photos = allow_missing};
  options.needed = [&](std::span<const View> views) {
    std::vector<bool> flags;
    for (const View& view : views) flags.push_back(std::find(needed.begin(), needed.end(), view.name) != needed.end());
    return flags;
  };
  return read_scene(files.folder.path() / "model", options);
}

TEST(PhotoFiles, PrefersTheLongestCommonTail) {
  const Photos files({"flight one/north/a b.jpg", "flight one/süd/ä.jpg"});
  files.photo("2024/north/a b.jpg");
  files.photo("2024/south/a b.jpg");
  files.photo("a b.jpg");
  files.photo("deep/er/süd/ä.jpg");
  EXPECT_EQ(files.found(0), "2024/north/a b.jpg");
  EXPECT_EQ(files.found(1), "deep/er/süd/ä.jpg");
  files.photo("flight one/north/a b.jpg");
  EXPECT_EQ(files.found(0), "flight one/north/a b.jpg");
}

TEST(PhotoFiles, ListsAmbiguousMatches) {
  const Photos files({"old/a.jpg"});
  files.photo("x/a.jpg");
  files.photo("y/a.jpg");
  EXPECT_TRUE(contains(input_error([&] { files.read(); }), "the photo 'old/a.jpg' could be any of 2 files in " +
                                                               (files.folder.path() / "photos").string() +
                                                               ": x/a.jpg, y/a.jpg"));
  files.photo("old/a.jpg");
  EXPECT_EQ(files.found(0), "old/a.jpg");
}

TEST(PhotoFiles, PrefersALongerTailToABareNameAtTheTop) {
  // Card folders repeat their names; cutting off what two paths share must not hide which flight they are of.
  const Photos files({"C:/project/flight2/DJI_1.png", "C:/project/flight2/DJI_2.png"});
  files.photo("DJI_1.png");
  files.photo("flight1/DJI_2.png");
  files.photo("flight2/DJI_1.png");
  files.photo("flight2/DJI_2.png");
  EXPECT_EQ(files.read().views[0].name, "DJI_1.png");
  EXPECT_EQ(files.found(0), "flight2/DJI_1.png");
  EXPECT_EQ(files.found(1), "flight2/DJI_2.png");
  const Photos bare({"E:/other/DJI_1.png", "E:/other/DJI_2.png"});
  bare.photo("DJI_1.png");
  bare.photo("old/DJI_1.png");
  bare.photo("DJI_2.png");
  EXPECT_EQ(bare.found(0), "DJI_1.png");
}

TEST(PhotoFiles, TellsDrivesApartWhereFoldersDoNot) {
  const Photos files({"D:/card/1.png", "E:/card/1.png"});
  files.photo("D/card/1.png");
  files.photo("E/card/1.png");
  const Scene scene = files.read();
  EXPECT_EQ(scene.views[0].name, "D/card/1.png");
  EXPECT_EQ(scene.views[1].name, "E/card/1.png");
}

TEST(PhotoFiles, PrefersPhotosToTheRawFilesBesideThem) {
  const Photos files({"DJI_1", "DJI_2", "DJI_3"});
  files.photo("DJI_1.jpg");
  files.folder.write("photos/DJI_1.DNG", "raw");
  files.photo("DJI_2.png");
  files.photo("DJI_3.pgm");
  EXPECT_EQ(files.found(0), "DJI_1.jpg");
  EXPECT_EQ(files.found(2), "DJI_3.pgm");
  files.photo("DJI_1.tif");
  EXPECT_TRUE(contains(input_error([&] { files.read(); }), "could be any of 2 files"));
}

TEST(PhotoFiles, AsksOnlyForNeededPhotos) {
  const Photos files({"a.jpg", "b.jpg", "missing.jpg", "narrow.jpg", "torn.jpg", "x/twice.jpg"});
  files.photo("a.jpg");
  files.photo("b.jpg");
  files.photo("narrow.jpg", 20, 30);
  files.folder.write("photos/torn.jpg", "no jpeg");
  files.photo("y/twice.jpg");
  files.photo("z/twice.jpg");
  const Scene scene = read_for(files, {"a.jpg", "b.jpg"});
  ASSERT_EQ(scene.views.size(), 6);
  for (std::size_t v = 0; v < 6; ++v) EXPECT_EQ(scene.views[v].photo.empty(), v >= 2) << v;
  const char* const expected[] = {"1 of 6 photos are not in", "of another shape", "torn.jpg", "could be any of 2"};
  for (std::size_t v = 2; v < 6; ++v) {
    const std::string error = input_error([&] { read_for(files, {"a.jpg", scene.views[v].name}); });
    EXPECT_TRUE(contains(error, expected[v - 2]));
  }
}

TEST(PhotoFiles, RefusesOnePhotoForTwoViews) {
  const Photos files({"one/a.jpg", "two/a.jpg"});
  files.photo("a.jpg");
  EXPECT_TRUE(
      contains(input_error([&] { files.read(); }), "the images 'one/a.jpg' and 'two/a.jpg' are the same photo"));
}

// The photo of b is missing, and a's has the same file name.
TEST(PhotoFiles, NeverTakesAnotherViewsPhotoForAMissingOne) {
  const Photos files({"a/img.jpg", "b/img.jpg", "c/other.jpg"});
  files.photo("a/img.jpg");
  for (const std::vector<std::string>& needed :
       std::vector<std::vector<std::string>>{{"b/img.jpg"}, {"a/img.jpg", "b/img.jpg"}})
    EXPECT_TRUE(contains(input_error([&] { read_for(files, needed); }), "1 of 3 photos are not in"));
  EXPECT_TRUE(contains(input_error([&] { read_for(files, {"b/img.jpg"}); }), "photos: b/img.jpg"));
  const Scene listed = read_for(files, {"b/img.jpg"}, true);
  EXPECT_FALSE(listed.views[0].photo.empty());
  EXPECT_TRUE(listed.views[1].photo.empty());
  // Views of which nothing is on disk can be left out.
  const Scene scene = read_for(files, {"a/img.jpg"});
  EXPECT_FALSE(scene.views[0].photo.empty());
  EXPECT_TRUE(scene.views[1].photo.empty());
  EXPECT_TRUE(scene.warnings.empty());
}

TEST(PhotoFiles, GivesASharedFileToTheViewThatItFitsBest) {
  const Photos letters({"A.JPG", "a.jpg"});
  letters.photo("a.jpg");
  EXPECT_TRUE(contains(input_error([&] { letters.read(); }), "photos: A.JPG"));
  const Photos kinds({"x/a", "x/a.png"});
  kinds.photo("deep/x/a.png");
  EXPECT_TRUE(contains(input_error([&] { kinds.read(); }), "photos: x/a"));
  const Photos tails({"flight 1/x/a.png", "flight 2/x/a.png"});
  tails.photo("project/flight 2/x/a.png");
  EXPECT_TRUE(contains(input_error([&] { read_for(tails, {"flight 1/x/a.png"}); }), "flight 1/x/a.png"));
  EXPECT_FALSE(read_for(tails, {"flight 2/x/a.png"}).views[1].photo.empty());
}

TEST(PhotoFiles, SaysWhichViewGetsAPhotoThatFitsOneLeftOutAsWell) {
  const Photos files({"one/a.jpg", "two/a.jpg"});
  files.photo("a.jpg");
  const Scene scene = read_for(files, {"two/a.jpg"});
  EXPECT_TRUE(scene.views[0].photo.empty());
  EXPECT_FALSE(scene.views[1].photo.empty());
  EXPECT_EQ(scene.warnings, std::vector{"1 photos could as well be those of views left out: " +
                                        (files.folder.path() / "photos/a.jpg").string() +
                                        " is taken for 'two/a.jpg', not for 'one/a.jpg'"});
}

TEST(PhotoFiles, FollowsLinksToFolders) {
  namespace fs = std::filesystem;
  const Photos files({"north/a.jpg", "south/a.jpg", "b.jpg", "old/c.jpg"});
  const test::TemporaryFolder card;
  for (const char* name : {"1/a.jpg", "2/a.jpg", "2/deep/b.jpg"}) test::write_photo(card.path() / name, 40, 30);
  files.photo("2024/c.jpg");
  const fs::path photos = files.folder.path() / "photos";
  fs::create_directory_symlink(card.path() / "1", photos / "2024" / "north");
  fs::create_directory_symlink(card.path() / "2", photos / "2024" / "south");
  EXPECT_EQ(files.found(0), "2024/south/deep/b.jpg");
  EXPECT_EQ(files.found(1), "2024/north/a.jpg");
  EXPECT_EQ(files.found(2), "2024/c.jpg");
  EXPECT_EQ(files.found(3), "2024/south/a.jpg");
  // Under several names, back to where they lie, to each other and to nothing; a photo counts once.
  fs::create_directory_symlink(photos / "2024", photos / "all");
  fs::create_directory_symlink(card.path() / "1", photos / "card");
  fs::create_directory_symlink(".", photos / "here");
  fs::create_directory_symlink("..", photos / "2024" / "up");
  fs::create_directory_symlink("/", photos / "2024" / "root");
  fs::create_directory_symlink(card.path() / "2", card.path() / "1" / "other");
  fs::create_directory_symlink(card.path() / "1", card.path() / "2" / "other");
  fs::create_directory_symlink(photos, card.path() / "2" / "back");
  fs::create_directory_symlink("nowhere", photos / "broken");
  const Scene scene = files.read();
  const fs::path expected[] = {card.path() / "2/deep/b.jpg", card.path() / "1/a.jpg", photos / "2024/c.jpg",
                               card.path() / "2/a.jpg"};
  for (std::size_t v = 0; v < 4; ++v)
    EXPECT_TRUE(fs::equivalent(scene.views[v].photo, expected[v])) << scene.views[v].photo;
}

TEST(PhotoFiles, KnowsOnePhotoForTwoViewsBehindALink) {
  const Photos files({"one/a.jpg", "two/a.jpg"});
  files.photo("x/one/a.jpg");
  std::filesystem::create_directory_symlink("one", files.folder.path() / "photos/x/two");
  EXPECT_TRUE(contains(input_error([&] { files.read(); }), "are the same photo"));
}

TEST(PhotoFiles, FallsBackToOtherCaseAndForNamesWithoutExtensionToAny) {
  const Photos files({"A.JPG", "b", "c.jpg"});
  files.photo("a.jpg");
  files.photo("B.tif");
  files.photo("c.png");
  const std::string error = input_error([&] { files.read(); });
  EXPECT_TRUE(contains(error, "1 of 3 photos are not in"));
  EXPECT_TRUE(contains(error, ": c.jpg"));  // a photo of another kind is another photo
  files.photo("c.jpg");
  EXPECT_EQ(files.found(0), "a.jpg");
  EXPECT_EQ(files.found(1), "B.tif");
  files.photo("A.JPG");
  EXPECT_EQ(files.found(0), "A.JPG");
}

TEST(PhotoFiles, LooksBesideTheSceneThatALinkLeadsTo) {
  const Photos files({"a.jpg"});
  test::write_photo(files.folder.path() / "model" / ".." / "images" / "a.jpg", 40, 30);
  const test::TemporaryFolder elsewhere;
  std::filesystem::create_directory_symlink(files.folder.path() / "model", elsewhere.path() / "link");
  const Scene scene = read_scene(elsewhere.path() / "link", {});
  EXPECT_TRUE(std::filesystem::equivalent(scene.views[0].photo, files.folder.path() / "images" / "a.jpg"));
}

TEST(PhotoFiles, LeavesMissingPhotosEmptyWhenAsked) {
  const Photos files({"a.jpg", "b.jpg"});
  files.photo("b.jpg");
  const Scene scene = files.read(true);
  ASSERT_EQ(scene.views.size(), 2);
  EXPECT_TRUE(scene.views[0].photo.empty());
  EXPECT_FALSE(scene.views[1].photo.empty());
  // Without a folder for photos at all.
  const auto model = files.folder.path() / "model";
  EXPECT_TRUE(contains(input_error([&] { read_scene(model, {}); }), "folder of the photos was not found"));
  EXPECT_TRUE(read_scene(model, {.allow_missing_photos = true}).views[1].photo.empty());
}

TEST(PhotoFiles, ScalesCamerasToPhotosOfTheSameShape) {
  const Photos files({"a.jpg"}, 4000, 2250);
  files.photo("a.jpg", 1333, 750);  // a third, rounded
  const Scene scene = files.read();
  const Camera& camera = scene.views[0].camera;
  EXPECT_EQ(camera.width, 1333);
  EXPECT_EQ(camera.height, 750);
  EXPECT_DOUBLE_EQ(camera.fx, 50 * 1333 / 4000.0);
  EXPECT_DOUBLE_EQ(camera.fy, 51 * 750 / 2250.0);
  EXPECT_DOUBLE_EQ(camera.cx, 21 * 1333 / 4000.0);
  EXPECT_TRUE(contains(scene.warnings.at(0), "a.jpg is 1333 x 750 pixels"));
  EXPECT_TRUE(contains(scene.warnings.at(0), "calibrated for 4000 x 2250"));
}

TEST(PhotoFiles, RefusesPhotosOfAnotherShape) {
  const Photos files({"a.jpg"}, 4000, 2250);
  files.photo("a.jpg", 1333, 748);
  EXPECT_TRUE(contains(input_error([&] { files.read(); }), "1 of 1 photos are of another shape"));
  files.photo("a.jpg", 750, 1333);
  EXPECT_TRUE(contains(input_error([&] { files.read(); }), "1 of 1 photos have been turned by a quarter: a.jpg"));
}

/// Two of each kind of bad photos beside a good one; a name that was mangled.
class AllKindsOfPhotos : public Photos {
 public:
  AllKindsOfPhotos()
      : Photos({"IMG~1.jpg", "cut1.jpg", "cut2.jpg", "good.jpg", "gone.jpg", "odd1.jpg", "odd2.jpg", "torn1.jpg",
                "torn2.jpg", "turned1.jpg", "turned2.jpg", "x/twice.jpg"}) {
    const auto path = [&](const std::string& name) { return folder.path() / "photos" / name; };
    for (const char* name : {"IMG 1.jpg", "good.jpg", "cut1.jpg", "cut2.jpg", "y/twice.jpg", "z/twice.jpg"})
      photo(name);
    for (const char* number : {"1", "2"}) {
      std::filesystem::resize_file(path(std::string("cut") + number + ".jpg"), 60);
      photo(std::string("odd") + number + ".jpg", 20, 30);
      photo(std::string("turned") + number + ".jpg", 30, 40);
      folder.write(std::string("photos/torn") + number + ".jpg", "no jpeg");
    }
  }
};

TEST(PhotoFiles, NamesAllBadPhotosInOneErrorWithWaysOut) {
  const AllKindsOfPhotos files;
  const std::optional<Error> error = test::caught([&] { files.read(); });
  ASSERT_TRUE(error);
  const std::string said = error->what();
  for (const char* part :
       {"2 of 12 photos are not in", ": IMG~1.jpg (there is IMG 1.jpg), gone.jpg; ",
        "1 of 12 photos could be any of several files: x/twice.jpg (", "2 of 12 photos cannot be read: torn1.jpg (",
        "torn2.jpg (", "2 of 12 photos end too early: cut1.jpg (", "cut2.jpg (",
        "2 of 12 photos have been turned by a quarter: turned1.jpg (is 30 x 40 pixels", "turned2.jpg (",
        "2 of 12 photos are of another shape than their cameras: odd1.jpg (is 20 x 30 pixels", "odd2.jpg ("})
    EXPECT_TRUE(contains(said, part)) << part << "\n" << said;
  EXPECT_FALSE(contains(said, "good.jpg"));
  EXPECT_EQ(error->cures(), (std::vector{Cure::skip_bad_photos, Cure::photos_folder}));
}

// The photos lie in no folder that is usual.
TEST(PhotoFiles, SaysWhereThePhotosMayBe) {
  const Photos files({"near 1.jpg", "near 2.jpg"});
  const auto error = [&] { return test::caught([&] { read_scene(files.folder.path() / "model", {}); }).value(); };
  for (const char* name : {"near 1.jpg", "near 2.jpg"}) files.photo(name);
  std::filesystem::rename(files.folder.path() / "photos", files.folder.path() / "100 MEDIA");
  std::string said = error().what();
  EXPECT_TRUE(contains(said, "the folder of the photos was not found; looked for ")) << said;
  EXPECT_TRUE(said.ends_with("100 MEDIA/near 1.jpg")) << said;
  EXPECT_EQ(error().cures(), std::vector{Cure::photos_folder});
  std::filesystem::create_directory(files.folder.path() / "images");
  said = error().what();
  EXPECT_TRUE(contains(said, "2 of 2 photos are not in ")) << said;
  EXPECT_TRUE(contains(said, "100 MEDIA/near 1.jpg), near 2.jpg")) << said;
  std::filesystem::copy(files.folder.path() / "100 MEDIA", files.folder.path() / "small");
  said = error().what();
  EXPECT_FALSE(contains(said, "there is")) << said;  // either may be meant
}

TEST(PhotoFiles, GoesOnWithoutBadPhotosIfItMay) {
  const AllKindsOfPhotos files;
  SceneOptions options{.images_dir = files.folder.path() / "photos", .skip_bad_photos = true};
  const auto read = [&] { return read_scene(files.folder.path() / "model", options); };
  const Scene scene = read();
  ASSERT_EQ(scene.views.size(), 12);
  EXPECT_EQ(scene.bad_photos.size(), 11);
  for (const View& view : scene.views) EXPECT_EQ(view.photo.empty(), view.name != "good.jpg") << view.name;
  EXPECT_TRUE(contains(scene.warnings.at(0), "left out: 2 of 12 photos are not in"));
  std::filesystem::remove(files.folder.path() / "photos" / "good.jpg");
  const std::optional<Error> error = test::caught(read);
  ASSERT_TRUE(error);
  EXPECT_EQ(error->cures(), std::vector{Cure::photos_folder});
}

// Damage behind the headers shows only in decoding.
TEST(PhotoFiles, DecodesPhotosToFindTheDamagedOnesToLeaveOut) {
  const Photos files({"a.jpg", "b.jpg"});
  files.photo("a.jpg");
  files.photo("b.jpg");
  std::string bytes = test::read_file(files.folder.path() / "photos" / "b.jpg");  // a PNG
  bytes[bytes.find("IDAT") + 30] ^= 0x55;
  files.folder.write("photos/b.jpg", bytes);
  EXPECT_EQ(files.read().bad_photos.size(), 0);
  const SceneOptions options{.images_dir = files.folder.path() / "photos", .skip_bad_photos = true};
  const Scene scene = read_scene(files.folder.path() / "model", options);
  ASSERT_EQ(scene.bad_photos.size(), 1);
  EXPECT_EQ(scene.bad_photos[0].view, "b.jpg");
  EXPECT_EQ(scene.bad_photos[0].problem, BadPhoto::Problem::damaged);
}

// What was found when the scene was read is found again where a photo is decoded.
TEST(PhotoFiles, AreCheckedAgainWhereTheyAreDecoded) {
  const Photos files({"a.jpg", "b.jpg"});
  files.photo("a.jpg");
  files.photo("b.jpg");
  const Scene scene = read_scene(files.folder.path() / "model",
                                 {.images_dir = files.folder.path() / "photos", .skip_bad_photos = true});
  EXPECT_EQ(scene.bad_photos.size(), 0);
  std::string bytes = test::read_file(files.folder.path() / "photos" / "b.jpg");  // a PNG
  bytes[bytes.find("IDAT") + 30] ^= 0x55;
  files.folder.write("photos/b.jpg", bytes);
  files.photo("a.jpg", 20, 15);
  PhotoCache cache(scene);
  EXPECT_TRUE(contains(input_error([&] { cache.photo(ViewId{1}); }), "b.jpg: cannot be decoded whole"));
  EXPECT_TRUE(contains(input_error([&] { cache.photo(ViewId{0}); }),
                       "a.jpg: is 20 x 15 pixels, which does not fit its camera any more"));
}

TEST(PhotoFiles, AreReplacedByTheirTextureLayers) {
  const Photos files({"a.jpg", "b.jpg", "c.jpg", "d.jpg"});
  for (const char* name : {"a.jpg", "b.jpg", "c.jpg", "d.jpg", ".texture/a.jpg", ".texture/b.PNG", "c.jpg.texture.png",
                           ".geometry/d.jpg", ".mask/a.png", "b.jpg.mask.jpg"})
    files.photo(name);
  const Scene scene = files.read();
  const auto path = [&](const char* name) { return files.folder.path() / "photos" / name; };
  EXPECT_EQ(scene.views[0].photo, path(".texture/a.jpg"));
  EXPECT_EQ(scene.views[1].photo, path(".texture/b.PNG"));
  EXPECT_EQ(scene.views[2].photo, path("c.jpg.texture.png"));
  EXPECT_EQ(scene.views[3].photo, path("d.jpg"));
  EXPECT_EQ(scene.views[0].mask, path(".mask/a.png"));
  EXPECT_EQ(scene.views[1].mask, path("b.jpg.mask.jpg"));
  EXPECT_TRUE(contains(scene.warnings.at(0), "3 photos are replaced by their texture layers of RealityCapture"));
}

TEST(PhotoFiles, MakesNamesFitToNameOutputs) {
  const Photos files({"/home/a/one/x.jpg", "/home/a/two/x.jpg"});
  files.photo("one/x.jpg");
  files.photo("two/x.jpg");
  const Scene scene = files.read();
  EXPECT_EQ(scene.views[0].name, "one/x.jpg");
  EXPECT_EQ(scene.views[1].name, "two/x.jpg");
  const Photos outside({"../../etc/x.jpg", "../y.jpg"});
  outside.photo("x.jpg");
  outside.photo("y.jpg");
  for (const View& view : outside.read().views) {
    EXPECT_EQ(view.name.find(".."), std::string::npos);
    EXPECT_NE(view.name.front(), '/');
  }
}

TEST(PhotoFiles, TakesAccentsInOnePieceOrTwo) {
  const Photos files({"fl\u00FCgel.jpg", "A\u030Angstro\u0308m.jpg"});
  files.photo("flu\u0308gel.jpg");
  files.photo("\u00C5ngstr\u00F6m.jpg");
  // Views are ordered by name.
  EXPECT_EQ(files.found(0), "\u00C5ngstr\u00F6m.jpg");
  EXPECT_EQ(files.found(1), "flu\u0308gel.jpg");
}

TEST(PhotoFiles, TakesARepeatedExtensionButNoMask) {
  const Photos files({"a.jpg"});
  files.photo("a.jpg.png");  // as COLMAP names masks
  EXPECT_TRUE(contains(input_error([&] { files.read(); }), ": a.jpg"));
  files.photo("a.jpg.jpg");
  EXPECT_EQ(files.found(0), "a.jpg.jpg");
}

TEST(SceneFormats, SaysWhatIsMissingOrToBeExported) {
  const test::TemporaryFolder folder;
  const auto error = [&](const std::string& name) {
    return input_error([&] { read_scene(folder.path() / name, {}); });
  };
  folder.write("half/sparse/0/cameras.bin", "x");
  EXPECT_TRUE(contains(error("half"), "holds a COLMAP model without images.bin in "));
  EXPECT_TRUE(error("half").ends_with("copy the model whole, or let COLMAP export it again (File > Export model)"));
  folder.write("project.psx", "<document version=\"1.2.0\" path=\"{projectname}.files/project.zip\"/>");
  EXPECT_TRUE(error("project.psx").ends_with("export its cameras as XML (File > Export > Export Cameras)"));
  const std::pair<const char*, const char*> others[] = {
      {"p.psz", "is a Metashape project; export its cameras as XML"},
      {"p.rsproj", "is a RealityScan project; export its cameras as .xmp files beside the photos"},
      {"p.rcproj", "is a RealityScan project; export its cameras as .xmp files beside the photos"},
      {"p.ccm", "is a ContextCapture project; export its block as BlocksExchange XML"},
      {"p.mg", "is a Meshroom project; give cameras.sfm"},
      {"database.db", "is COLMAP's database, which has no poses; give the project's folder"}};
  for (const auto& [name, advice] : others) {
    folder.write(name, "<?xml version=\"1.0\"?><Project/>");
    EXPECT_TRUE(contains(error(name), advice)) << error(name);
  }
  folder.write("pointer/cameras.xml", "version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12345\n");
  for (const char* name : {"pointer", "pointer/cameras.xml"})
    EXPECT_TRUE(
        error(name).ends_with("pointer/cameras.xml: is a pointer that Git LFS left instead of the file: fetch "
                              "it by 'git lfs pull'"))
        << error(name);
  folder.write("all.zip", std::string("PK\3\4", 4) + "...");
  EXPECT_TRUE(contains(error("all.zip"), "all.zip: cannot be read as a zip archive, or ends too early"));
  folder.write("model.zip", test::zipped({{"sparse/0/cameras.bin", "x"}}));
  EXPECT_TRUE(error("model.zip").ends_with("is a zip archive of which nothing is read as it is; unpack it"));
  folder.write("stored.zip", std::string("PK\3\4", 4) + "<?xml version='1.0'?><document><chunk/></document>");
  EXPECT_TRUE(contains(error("stored.zip"), "cannot be read as a zip archive"));
}

TEST(StatedPhotoName, NamesAFile) {
  for (const char* name : {"a.jpg", "images/a", ".hidden", "C:/a.jpg", "../a..", "\303\204 b.jpg"})
    EXPECT_EQ(stated_photo_name("scene", "line 1", name), name);
  for (const char* name : {"", "/", "images/", "images/.", "..", "C:", "C:/"})
    EXPECT_EQ(input_error([&] { stated_photo_name("scene", "line 1", name); }),
              "scene: line 1: expected the name of a photo, found '" + std::string(name) + "'");
}

TEST(SceneFormats, RefusesAFolderOfTwo) {
  const Photos files({"a.jpg"});
  files.photo("a.jpg");
  files.folder.write("model/a.cam", "0 0 0 1 0 0 0 1 0 0 0 1\n1\n");
  const std::string error = input_error([&] { files.read(); });
  EXPECT_TRUE(contains(error, "holds both a mvs-texturing scene"));
  EXPECT_TRUE(contains(error, "and a COLMAP scene"));
  EXPECT_NO_THROW(read_scene(files.folder.path() / "model/images.txt", {.images_dir = files.folder.path() / "photos"}));
}

TEST(SceneFormats, ARefusalIsALineThatNamesThemAll) {
  const test::TemporaryFolder folder;
  const std::string error = input_error([&] { read_scene(folder.path(), {}); });
  EXPECT_GE(scene_formats().size(), 6);
  for (const SceneFormat* format : scene_formats()) EXPECT_TRUE(contains(error, format->name));
  constexpr std::size_t kLine = 320;
  EXPECT_LE(error.size(), kLine + folder.path().string().size()) << error;
}

TEST(SceneFormats, ThoseOfAFilesExtensionSayWhatTheyExpect) {
  const test::TemporaryFolder folder;
  const std::string error = input_error([&] { read_scene(folder.write("a.xml", "<kml/>"), {}); });
  for (const SceneFormat* format : scene_formats()) {
    if (!contains(format->expects, ".xml")) continue;
    EXPECT_TRUE(contains(error, format->expects));
  }
}

}  // namespace
}  // namespace gpvc::io
