// Coverage that comes back as it went in.
#include "app/pipeline/coverage_store.h"

#include <gtest/gtest.h>

#include <random>
#include <utility>

namespace gpvc {
namespace {

void add_entry(std::uint32_t face, int width, int height, const auto& is_seen, visibility::CoverageTable& table) {
  visibility::FaceCoverage entry;
  entry.face = FaceId{face};
  entry.x0 = 3 + 100 * static_cast<std::int32_t>(face);
  entry.y0 = 4000 - static_cast<std::int32_t>(face);
  entry.visible = 7 * face;
  entry.visible_share = 0.1f + 0.125f * static_cast<float>(face);
  entry.width = width;
  entry.height = height;
  entry.first_word = table.words.size();
  const std::size_t bits = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  table.words.resize(entry.first_word + (bits + 63) / 64, 0);
  for (std::size_t bit = 0; bit < bits; ++bit)
    if (is_seen(bit)) table.words[entry.first_word + bit / 64] |= std::uint64_t{1} << (bit % 64);
  table.entries.push_back(entry);
}

TEST(CoverageStore, GivesBackWhatPartialFacesNeed) {
  std::mt19937 random(3);
  pipeline::CoverageStore store;
  std::vector<visibility::CoverageTable> views(3);
  std::uint32_t number = 0;
  for (visibility::CoverageTable& view : views) {
    add_entry(
        0, 0, 0, [](std::size_t) { return true; }, view);  // seen by sub-pixel samples
    add_entry(
        1, 7, 3, [&](std::size_t) { return random() % 2 != 0; }, view);
    add_entry(
        2, 640, 300, [](std::size_t bit) { return bit % 640 > 100 && bit % 640 < 500; }, view);
    add_entry(
        3, 64, 5, [](std::size_t bit) { return bit / 64 % 2 != 0; }, view);
    add_entry(
        4, 1000, 13, [&](std::size_t) { return random() % 50 != 0; }, view);
    for (visibility::FaceCoverage& entry : view.entries) entry.view = ViewId{number};
    store.add(std::make_shared<const pipeline::PackedCoverage>(pipeline::pack(ViewId{number++}, view)));
  }
  const std::vector<labeling::FaceTag> tags{labeling::FaceTag::partial, labeling::FaceTag::partial,
                                            labeling::FaceTag::partial, labeling::FaceTag::seen,
                                            labeling::FaceTag::partial};
  const visibility::CoverageTable kept = store.of_partial_faces(tags);
  ASSERT_EQ(kept.entries.size(), 12u);
  auto next = kept.entries.begin();
  for (const visibility::CoverageTable& view : views)
    for (const visibility::FaceCoverage& entry : view.entries) {
      if (entry.face == FaceId{3}) continue;
      EXPECT_EQ(next->face, entry.face);
      EXPECT_EQ(next->view, entry.view);
      EXPECT_EQ(next->x0, entry.x0);
      EXPECT_EQ(next->y0, entry.y0);
      EXPECT_EQ(next->width, entry.width);
      EXPECT_EQ(next->height, entry.height);
      EXPECT_EQ(next->visible, entry.visible);
      EXPECT_EQ(next->visible_share, entry.visible_share);
      for (int y = 0; y < entry.height; ++y)
        for (int x = 0; x < entry.width; ++x)
          ASSERT_EQ(kept.sees(*next, entry.x0 + x, entry.y0 + y), view.sees(entry, entry.x0 + x, entry.y0 + y));
      ++next;
    }
}

TEST(CoverageStore, TakesLittle) {
  // A quarter circle of 12 megapixels: a tenth of its bits is enough.
  visibility::CoverageTable table;
  add_entry(
      0, 4000, 3000, [](std::size_t bit) { return bit % 4000 * (bit % 4000) + bit / 4000 * (bit / 4000) < 9000000; },
      table);
  EXPECT_LT(pipeline::pack(ViewId{0}, table).bytes.size() * 8, 4000u * 3000u / 10);
  table = {};
  for (std::uint32_t face = 0; face < 1000; ++face)
    add_entry(
        face, 5, 6, [](std::size_t bit) { return bit % 3 == 0; }, table);
  EXPECT_LT(pipeline::pack(ViewId{0}, table).bytes.size(), 1000u * 20);
  // More words than a number of two bytes counts, all alike.
  table = {};
  add_entry(
      0, 16384, 16384, [](std::size_t) { return true; }, table);
  pipeline::CoverageStore store;
  store.add(std::make_shared<const pipeline::PackedCoverage>(pipeline::pack(ViewId{0}, table)));
  EXPECT_EQ(store.of_partial_faces(std::vector<labeling::FaceTag>{labeling::FaceTag::partial}).words, table.words);
}

// Faces whose projections fill the boxes of the entries, for a camera that shows (x, y, 1) at the pixel (x, y).
std::pair<Mesh, View> faces_around(const visibility::CoverageTable& table, std::uint32_t faces) {
  Mesh mesh;
  mesh.faces.resize(faces, {0, 0, 0});
  mesh.positions.push_back({0, 0, 1});
  for (const visibility::FaceCoverage& entry : table.entries) {
    const double x = entry.x0, y = entry.y0;
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (const WorldPoint& p : {WorldPoint{x, y, 1}, {x + entry.width, y, 1}, {x, y + entry.height, 1}})
      mesh.positions.push_back(p);
    mesh.faces[index(entry.face)] = {first, first + 1, first + 2};
  }
  View view;
  view.camera.width = 600;
  view.camera.height = 4100;
  view.camera.fx = view.camera.fy = 1;
  return {std::move(mesh), std::move(view)};
}

TEST(CoverageStore, OnlyWhatMayHaveBeenPackedIsSound) {
  visibility::CoverageTable table;
  std::mt19937 random(5);
  add_entry(
      0, 0, 0, [](std::size_t) { return true; }, table);
  add_entry(
      2, 9, 7, [](std::size_t bit) { return bit % 2 != 0; }, table);
  add_entry(
      5, 90, 70, [&](std::size_t bit) { return bit > 3000 && random() % 9 != 0; }, table);
  const pipeline::PackedCoverage packed = pipeline::pack(ViewId{0}, table);
  const std::pair<Mesh, View> around = faces_around(table, 6);
  const auto is_sound = [&](const pipeline::PackedCoverage& coverage) {
    return pipeline::is_sound(coverage, around.first, around.second);
  };
  EXPECT_TRUE(is_sound(packed));
  EXPECT_TRUE(is_sound({}));
  const auto with = [&](const auto& change) {
    std::pair<Mesh, View> other = around;
    change(other.first, other.second);
    return pipeline::is_sound(packed, other.first, other.second);
  };
  EXPECT_TRUE(with([](Mesh&, View&) {}));
  EXPECT_FALSE(with([](Mesh& m, View&) { m.faces.pop_back(); })) << "a face that the mesh lacks";
  EXPECT_FALSE(with([](Mesh&, View& v) { v.camera.width = 592; })) << "a box that reaches out of the frame";
  EXPECT_FALSE(with([](Mesh&, View& v) { v.camera.height = 4064; }));
  EXPECT_FALSE(with([](Mesh& m, View&) { m.faces[5] = m.faces[2]; })) << "a box that the face does not reach";
  EXPECT_TRUE(with([](Mesh& m, View&) { m.positions[m.faces[5][0]].z = -1; })) << "a face behind the camera";
  pipeline::PackedCoverage cut = packed;
  while (cut.bytes.size() > 1) {
    cut.bytes.pop_back();
    if (!is_sound(cut)) continue;
    pipeline::CoverageStore store;  // ends between two faces
    store.add(std::make_shared<const pipeline::PackedCoverage>(cut));
    EXPECT_LT(store.of_partial_faces(std::vector(6, labeling::FaceTag::partial)).entries.size(), 3u);
  }
  // Whatever passes can be read.
  std::size_t passed = 0;
  for (int i = 0; i < 20000; ++i) {
    pipeline::PackedCoverage changed = packed;
    for (int n = 0; n < 3; ++n) changed.bytes[random() % changed.bytes.size()] = static_cast<std::uint8_t>(random());
    if (!is_sound(changed)) continue;
    ++passed;
    pipeline::CoverageStore store;
    store.add(std::make_shared<const pipeline::PackedCoverage>(changed));
    for (const visibility::FaceCoverage& entry :
         store.of_partial_faces(std::vector(6, labeling::FaceTag::partial)).entries)
      ASSERT_LT(entry.face, FaceId{6});
  }
  EXPECT_GT(passed, 100u);
}

}  // namespace
}  // namespace gpvc
