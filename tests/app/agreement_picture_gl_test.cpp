// The picture of photos beside what others show of the mesh from their places.
#include "app/evaluate/agreement_picture.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/app/photographed_city.h"

namespace gpvc {
namespace {

using test::City;

// Mean difference of the two halves, where the right one shows the mesh; negative where it never does.
double difference_of_halves(const Image& picture) {
  double sum = 0;
  std::size_t count = 0;
  const int half = (picture.width + 8) / 2;
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x + half < picture.width; ++x) {
      const std::uint8_t *left = picture.at(x, y), *right = picture.at(x + half, y);
      if (right[0] == right[1] && right[1] == right[2] && (right[0] == 128 || right[0] == 255)) continue;
      for (std::size_t i = 0; i < 3; ++i) sum += std::abs(int{left[i]} - int{right[i]});
      count += 3;
    }
  return count == 0 ? -1 : sum / static_cast<double>(count);
}

TEST(AgreementPicture, HalvesAreAlikeWhereAllFits) {
  const City city(50000, 720);
  pipeline::Settings settings;
  settings.costs.keep_odd_views = settings.allow_misfit = true;
  results::Observer silent;
  const auto picture_of = [&](std::vector<io::Picture> pictures) {
    io::PictureSource photos(city.scene, std::move(pictures));
    const checks::Input input{city.scene, city.mesh, city.views};
    const pipeline::Seen seen = pipeline::see({input, settings, photos, silent});
    const auto pairs = evaluate::least_agreeing(seen.candidates, 3);
    EXPECT_EQ(pairs.size(), 3u);
    for (const auto& [view, other] : pairs) EXPECT_NE(view, other);
    return evaluate::agreement_picture(input, seen.candidates.table, pairs, photos);
  };
  const double right = difference_of_halves(picture_of(city.pictures));
  EXPECT_GT(right, 0);
  EXPECT_LT(right, 12) << "grey levels";
  std::vector<io::Picture> swapped = city.pictures;
  std::swap(swapped[0].image, swapped[5].image);
  EXPECT_GT(difference_of_halves(picture_of(std::move(swapped))), 2 * right);
}

}  // namespace
}  // namespace gpvc
