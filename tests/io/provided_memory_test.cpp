#include "io/provided_memory.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

namespace gpvc {
namespace {

TEST(ProvidedMemory, LargeVectorIsFilledToItsEnds) {
  // Parts that threads provide, and some bytes of one more.
  const std::size_t size = (std::size_t{80} << 20) + 12345;
  const std::vector<std::uint8_t> bytes = filled(size, std::uint8_t{7});
  EXPECT_EQ(bytes.size(), size);
  EXPECT_TRUE(std::ranges::all_of(bytes, [](std::uint8_t b) { return b == 7; }));
  EXPECT_TRUE(filled(0, 1.0).empty());
}

TEST(ProvidedMemory, ProvidedBlockKeepsItsContents) {
  std::vector<std::uint8_t> bytes(std::size_t{70} << 20, 5);
  provide_pages(bytes.data() + 1, bytes.size() - 2);
  EXPECT_TRUE(std::ranges::all_of(bytes, [](std::uint8_t b) { return b == 5; }));
}

}  // namespace
}  // namespace gpvc
