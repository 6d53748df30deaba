// gpvc synth as files: imperfect photos and what is known of them.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "app/cli/options.h"
#include "app/evaluate/truth.h"
#include "io/images.h"
#include "tests/app/synth_files.h"
#include "tests/support/temporary_folder.h"

namespace gpvc {
namespace {

namespace fs = std::filesystem;

using test::synthesize;

cli::SynthOptions small_city(const fs::path& out) { return test::small_city(out, 120); }

TEST(SynthCommand, ImperfectPhotosComeWithCleanOnes) {
  const test::TemporaryFolder folder;
  const fs::path plain = folder.path() / "plain", spoilt = folder.path() / "spoilt";
  synthesize(small_city(plain));
  EXPECT_FALSE(fs::exists(plain / "clean"));
  EXPECT_FALSE(fs::exists(plain / "unmodelled"));
  EXPECT_FALSE(evaluate::read_truth(plain).unmodelled);

  cli::SynthOptions options = small_city(spoilt);
  options.aperture_m = 0.5;
  options.shake_px = 8;
  options.travel_m = 0.2;
  options.visibility_m = 200;
  options.rays = 8;
  options.exposure = true;
  options.unmodelled = {.cars = 3, .people = 4, .fences = true};
  options.reflections = true;
  synthesize(options);
  const evaluate::Truth truth = evaluate::read_truth(spoilt);
  EXPECT_TRUE(truth.unmodelled);
  EXPECT_EQ(truth.all_surfaces, truth.surfaces + 3 * 11 + 4 * 18 + 1);
  const nlohmann::json photos = nlohmann::json::parse(test::read_file(spoilt / "truth.json")).at("photos");
  ASSERT_EQ(photos.size(), 5u);
  std::set<double> shakes;
  for (const auto& [name, photo] : photos.items()) {
    EXPECT_EQ(test::read_file(spoilt / "clean" / name), test::read_file(plain / "images" / name)) << name;
    EXPECT_NE(test::read_file(spoilt / "images" / name), test::read_file(plain / "images" / name)) << name;
    const Image shares = evaluate::read_unmodelled_picture(truth, name, 120, 80);
    EXPECT_EQ(shares.pixels.size(), 120u * 80 * 3);
    const double x = photo.at("shake_px").at(0).get<double>(), y = photo.at("shake_px").at(1).get<double>();
    EXPECT_LE(std::hypot(x, y), 8);
    EXPECT_LE(photo.at("travel_m").get<double>(), 0.2);
    shakes.insert(x);
  }
  EXPECT_EQ(shakes.size(), 5u) << "each photo another way";
}

}  // namespace
}  // namespace gpvc
