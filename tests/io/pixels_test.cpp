#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "io/image.h"

namespace gpvc {
namespace {

using Bytes = std::vector<std::uint8_t>;

TEST(Pixels, BorrowedBytesAreReadWhereTheyLieUntilTheyAreChanged) {
  const auto lent = std::make_shared<Bytes>(Bytes{1, 2, 3});
  Pixels pixels = Pixels::borrowed(*lent, lent);
  EXPECT_TRUE(pixels.is_borrowed());
  EXPECT_EQ(std::as_const(pixels).data(), lent->data());
  const Pixels shared = pixels;
  EXPECT_EQ(shared.data(), lent->data());

  pixels[1] = 7;
  EXPECT_EQ(*lent, (Bytes{1, 2, 3})) << "the lender's bytes";
  EXPECT_EQ(pixels, (Pixels{1, 7, 3}));
  EXPECT_FALSE(pixels.is_borrowed());
  EXPECT_EQ(shared, (Pixels{1, 2, 3})) << "another borrower's view of them";
}

TEST(Pixels, BorrowersKeepTheLenderAlive) {
  auto lent = std::make_shared<Bytes>(Bytes{1, 2, 3});
  const std::weak_ptr<Bytes> watched = lent;
  Pixels pixels = Pixels::borrowed(*lent, lent);
  lent.reset();
  EXPECT_FALSE(watched.expired());
  Pixels moved = std::move(pixels);
  EXPECT_FALSE(watched.expired());
  EXPECT_EQ(moved.release(), (Bytes{1, 2, 3}));
  EXPECT_TRUE(watched.expired());
  EXPECT_TRUE(moved.empty());
}

TEST(Pixels, AreChangedAsAVectorIs) {
  const auto lent = std::make_shared<Bytes>(Bytes{1, 2});
  const auto changed = [&](const auto& change) {
    Pixels pixels = Pixels::borrowed(*lent, lent);
    change(pixels);
    EXPECT_EQ(*lent, (Bytes{1, 2}));
    return pixels;
  };
  EXPECT_EQ(changed([](Pixels& p) { p.push_back(3); }), (Pixels{1, 2, 3}));
  EXPECT_EQ(changed([](Pixels& p) { p.resize(3, 9); }), (Pixels{1, 2, 9}));
  EXPECT_EQ(changed([](Pixels& p) { p.assign(2, 5); }), (Pixels{5, 5}));
  EXPECT_EQ(changed([](Pixels& p) { p.insert(p.begin(), 2, 8); }), (Pixels{8, 8, 1, 2}));
  EXPECT_EQ(changed([](Pixels& p) { p.insert(p.end(), {4, 5}); }), (Pixels{1, 2, 4, 5}));
  EXPECT_EQ(changed([](Pixels& p) { p = Pixels{6}; }), (Pixels{6}));
}

}  // namespace
}  // namespace gpvc
