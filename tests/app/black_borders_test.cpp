#include "app/checks/black_borders.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <vector>

namespace gpvc::checks {
namespace {

constexpr int kWidth = 100, kHeight = 80;

/// Grey, with nearly black pixels where `black` says so.
template <class Where>
Image photo(const Where& black) {
  Image image{kWidth, kHeight, 3, {}};
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      image.pixels.insert(image.pixels.end(), 3, static_cast<std::uint8_t>(black(x, y) ? (x + y) % 9 : 90));
  return image;
}

TEST(BlackBorders, AreWhatIsReachedFromTheEdge) {
  EXPECT_EQ(black_border_share(photo([](int, int) { return false; })), 0);
  EXPECT_EQ(black_border_share(photo([](int, int) { return true; })), 1);
  // A frame of 5 pixels; a hole in the middle is none of it.
  const auto frame = [](int x, int y) { return x < 5 || y < 5 || x >= kWidth - 5 || y >= kHeight - 5; };
  const double share = 1 - 90.0 * 70 / (kWidth * kHeight);
  EXPECT_DOUBLE_EQ(black_border_share(photo(frame)), share);
  EXPECT_DOUBLE_EQ(
      black_border_share(photo([&](int x, int y) { return frame(x, y) || (x > 40 && x < 60 && y > 30 && y < 50); })),
      share);
  // A disc on black.
  const auto beyond = [](int x, int y) { return (x - 50) * (x - 50) + (y - 40) * (y - 40) > 900; };
  EXPECT_NEAR(black_border_share(photo(beyond)), 1 - 2827.0 / (kWidth * kHeight), 0.01);
}

TEST(BlackBorders, AreToldWhereHalfOfThePhotosHaveThem) {
  const Image plain = photo([](int, int) { return false; }), bordered = photo([](int x, int) { return x < 10; });
  BlackBorders few;
  for (const Image* each : {&plain, &plain, &bordered}) few.add({}, *each);
  EXPECT_EQ(few.remark().text, "");
  BlackBorders many;
  for (const Image* each : {&bordered, &plain, &bordered}) many.add({}, *each);
  const Remark remark = many.remark();
  EXPECT_NE(remark.text.find("2 of 3 photos are black along their borders, on 10.0 %"), std::string::npos)
      << remark.text;
  EXPECT_EQ(remark.cures, std::vector{Cure::mask_photos});
  Camera fisheye;
  fisheye.distortion.max_angle = 1.5;  // black lies around its circle
  BlackBorders circles;
  circles.add(fisheye, bordered);
  EXPECT_EQ(circles.remark().text, "");
}

}  // namespace
}  // namespace gpvc::checks
