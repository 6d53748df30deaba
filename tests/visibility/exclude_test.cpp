#include "visibility/exclude.h"

#include <gtest/gtest.h>

#include <functional>

#include "io/photos.h"
#include "visibility/visibility.h"

namespace gpvc::visibility {
namespace {

constexpr int kColumns = 64, kRows = 48;

// Looks along +z; at z = 8 a pixel is 1/8 wide.
View straight() {
  View view;
  view.camera = {kColumns, kRows, 64, 64, 32, 24, {}};
  return view;
}

// Adds a square of two triangles, the first of which has the corner (x, y), around pixels of the view above.
void add_square(Mesh& mesh, double x, double y, double edge, double z) {
  const auto base = static_cast<std::uint32_t>(mesh.positions.size());
  const auto at = [&](double px, double py) { mesh.positions.push_back({(px - 32) * z / 64, (py - 24) * z / 64, z}); };
  at(x, y);
  at(x + edge, y);
  at(x, y + edge);
  at(x + edge, y + edge);
  mesh.faces.push_back({base, base + 2, base + 1});
  mesh.faces.push_back({base + 1, base + 2, base + 3});
}

ViewVisibility look(const Mesh& mesh) {
  VisibilityOptions options;
  std::get<Gpvc>(options.method).drawing = Drawing::native;
  return VisibilityStage(mesh, options).classify(straight(), ViewId{7}, nullptr);
}

PixelSet pixels(const std::function<bool(int, int)>& contains) {
  PixelSet set(kColumns, kRows);
  for (int y = 0; y < kRows; ++y)
    for (int x = 0; x < kColumns; ++x)
      if (contains(x, y)) set.add(x, y);
  return set;
}

std::size_t seen_pixels(const ViewVisibility& seen, FaceId face) {
  for (const FaceCoverage& entry : seen.coverage.entries) {
    if (entry.face != face) continue;
    std::size_t count = 0;
    for (int y = 0; y < kRows; ++y)
      for (int x = 0; x < kColumns; ++x) count += seen.coverage.sees(entry, x, y) ? 1 : 0;
    EXPECT_EQ(entry.visible, count);
    EXPECT_EQ(entry.view, ViewId{7});
    return count;
  }
  return 0;
}

// What excluding pixels afterwards leaves is what a mask leaves that has excluded them before.
TEST(Exclude, GivesWhatAMaskGives) {
  Mesh mesh;
  add_square(mesh, 8, 8, 12, 8);
  add_square(mesh, 14, 12, 24, 10);  // partly behind the first
  add_square(mesh, 50, 30, 0.3, 8);  // smaller than a pixel
  const auto excluded = [](int x, int y) { return x >= 16 && x < 22 && y > 10; };
  ViewVisibility seen = look(mesh);
  ASSERT_EQ(seen.classes[2], FaceClass::partial);
  ASSERT_EQ(seen.classes[4], FaceClass::full);
  const PixelSet set = pixels(excluded);
  EXPECT_GT(exclude(mesh, straight(), ViewId{7}, {set, PixelSet(kColumns, kRows), PixelSet(kColumns, kRows)}, seen),
            50u);

  io::PhotoExclusion mask{kColumns, kRows, 1, std::vector<std::uint64_t>(kRows, 0)};
  for (int y = 0; y < kRows; ++y)
    for (int x = 0; x < kColumns; ++x)
      if (excluded(x, y)) mask.words[static_cast<std::size_t>(y)] |= std::uint64_t{1} << x;
  VisibilityOptions options;
  std::get<Gpvc>(options.method).drawing = Drawing::native;
  const ViewVisibility masked = VisibilityStage(mesh, options).classify(straight(), ViewId{7}, &mask);
  EXPECT_EQ(seen.ivm.faces, masked.ivm.faces);
  EXPECT_EQ(seen.classes, masked.classes);
  EXPECT_EQ(seen.statistics.full, masked.statistics.full);
  EXPECT_EQ(seen.statistics.partial, masked.statistics.partial);
  ASSERT_EQ(seen.coverage.entries.size(), masked.coverage.entries.size());
  for (std::uint32_t f = 0; f < mesh.faces.size(); ++f)
    EXPECT_EQ(seen_pixels(seen, FaceId{f}), seen_pixels(masked, FaceId{f})) << f;
  for (std::size_t n = 0; n < seen.coverage.entries.size(); ++n)
    EXPECT_NEAR(seen.coverage.entries[n].visible_share, masked.coverage.entries[n].visible_share, 0.02) << n;
}

TEST(Exclude, TellsBackgroundFromWhatIsHidden) {
  Mesh mesh;
  add_square(mesh, 8, 8, 10, 8);        // all of it background
  add_square(mesh, 24, 8, 10, 8);       // all of it excluded, little of it background
  add_square(mesh, 40.3, 8.3, 0.1, 8);  // smaller than a pixel, in background
  add_square(mesh, 50, 8, 10, 8);       // nothing of it excluded
  add_square(mesh, 24, 20, 10, 8);      // all of it excluded, most of it mixed with background
  ViewVisibility seen = look(mesh);
  for (std::uint32_t f = 0; f < 10; ++f) ASSERT_EQ(seen.classes[f], FaceClass::full) << f;
  const PixelSet all = pixels([](int x, int) { return x < 45; });
  const PixelSet background = pixels([](int x, int y) { return (x < 45 && x > 35) || x < 20 || (x < 45 && y < 10); });
  const PixelSet mixed = pixels([](int x, int y) { return x > 20 && x <= 35 && y >= 18; });
  exclude(mesh, straight(), ViewId{7}, {all, background, mixed}, seen);
  for (const std::uint32_t f : {0u, 1u, 4u, 5u}) EXPECT_EQ(seen.classes[f], FaceClass::background) << f;
  EXPECT_EQ(seen.classes[3], FaceClass::hidden);
  for (const std::uint32_t f : {8u, 9u}) EXPECT_EQ(seen.classes[f], FaceClass::mixed) << f;
  for (const std::uint32_t f : {6u, 7u}) EXPECT_EQ(seen.classes[f], FaceClass::full) << f;
  EXPECT_TRUE(seen.coverage.entries.empty());
  EXPECT_EQ(seen.statistics.full, 2u);
}

}  // namespace
}  // namespace gpvc::visibility
