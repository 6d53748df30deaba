// What a view of the stage is held against: the oracle's answer for it, face by face and pixel by pixel.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "tests/visibility/visibility_oracle.h"
#include "visibility/result.h"

namespace gpvc::visibility {

/// Faces of each class.
using ClassCounts = std::array<std::size_t, 4>;
inline ClassCounts count_classes(const std::vector<FaceClass>& classes) {
  ClassCounts counts{};
  for (const FaceClass c : classes) ++counts[static_cast<std::size_t>(c)];
  return counts;
}

/// The first pixel of the frame that one of the two gives to the face and the other does not.
inline std::string disputed_pixel(const View& view, std::size_t face, const ViewVisibility& found,
                                  const oracle::Answer& expected) {
  const FaceCoverage* entry = nullptr;
  for (const FaceCoverage& e : found.coverage.entries)
    if (index(e.face) == face) entry = &e;
  for (int y = 0; y < view.camera.height; ++y)
    for (int x = 0; x < view.camera.width; ++x) {
      const bool owns = expected.owners[static_cast<std::size_t>(y) * static_cast<std::size_t>(view.camera.width) +
                                        static_cast<std::size_t>(x)] == face;
      const bool sees = entry != nullptr
                            ? found.coverage.sees(*entry, x, y)
                            : found.classes[face] == FaceClass::full && (owns || found.ivm.at(x, y) == FaceId(face));
      if (owns != sees) return "pixel " + std::to_string(x) + ", " + std::to_string(y);
    }
  return "no pixel centre of the frame";
}

/// How many faces without a tie have another class than the oracle says.
inline std::size_t count_wrong(const ViewVisibility& found, const oracle::Answer& expected) {
  std::size_t wrong = 0;
  for (std::size_t f = 0; f < found.classes.size(); ++f)
    wrong += !expected.tied[f] && found.classes[f] != expected.classes[f];
  return wrong;
}

/// Bits are the oracle's owners; entries are those of the partial faces, in order.
inline void expect_coverage(const View& view, const ViewVisibility& found, const oracle::Answer& expected) {
  std::map<std::uint32_t, std::uint32_t> owned;
  for (const std::uint32_t owner : expected.owners) ++owned[owner];
  std::size_t entry = 0;
  for (std::size_t f = 0; f < found.classes.size(); ++f) {
    if (found.classes[f] != FaceClass::partial) continue;
    ASSERT_LT(entry, found.coverage.entries.size());
    const FaceCoverage& coverage = found.coverage.entries[entry++];
    ASSERT_EQ(index(coverage.face), f);
    EXPECT_EQ(index(coverage.view), 7U);
    EXPECT_GT(coverage.visible_share, 0);
    EXPECT_LE(coverage.visible_share, 1);
    if (expected.tied[f] || coverage.width == 0) continue;
    EXPECT_EQ(coverage.visible, owned[static_cast<std::uint32_t>(f)]) << "face " << f;
    for (int y = coverage.y0 - 1; y <= coverage.y0 + coverage.height; ++y)
      for (int x = coverage.x0 - 1; x <= coverage.x0 + coverage.width; ++x) {
        const bool in_frame = x >= 0 && y >= 0 && x < view.camera.width && y < view.camera.height;
        const bool owns = in_frame && expected.owners[static_cast<std::size_t>(y * view.camera.width + x)] == f;
        ASSERT_EQ(found.coverage.sees(coverage, x, y), owns)
            << "view " << view.name << " face " << f << " pixel " << x << ", " << y;
      }
  }
  EXPECT_EQ(entry, found.coverage.entries.size());
}

/// Every face without a tie has the oracle's class, and every partial face the oracle's coverage; view 7. Returns how
/// many faces are tied.
inline std::size_t expect_answer(const View& view, const ViewVisibility& found, const oracle::Answer& expected) {
  EXPECT_EQ(found.classes.size(), expected.classes.size());
  std::size_t tied = 0;
  for (std::size_t f = 0; f < expected.classes.size(); ++f) {
    if (expected.tied[f]) {
      ++tied;
    } else if (found.classes[f] != expected.classes[f]) {
      ADD_FAILURE() << "view " << view.name << " face " << f << " of " << expected.classes.size() << ": "
                    << static_cast<int>(found.classes[f]) << ", the oracle says "
                    << static_cast<int>(expected.classes[f]) << "; " << disputed_pixel(view, f, found, expected);
    }
  }
  expect_coverage(view, found, expected);
  return tied;
}

/// Classes, coverage and the owners of pixels are the same, bit for bit, whatever drew and classified the view.
inline void expect_same_visibility(const ViewVisibility& found, const ViewVisibility& expected) {
  EXPECT_EQ(found.classes, expected.classes);
  EXPECT_EQ(found.ivm.faces, expected.ivm.faces);
  EXPECT_EQ(found.coverage.words, expected.coverage.words);
  ASSERT_EQ(found.coverage.entries.size(), expected.coverage.entries.size());
  for (std::size_t i = 0; i < expected.coverage.entries.size(); ++i) {
    const FaceCoverage &a = found.coverage.entries[i], &b = expected.coverage.entries[i];
    ASSERT_EQ(std::tie(a.face, a.view, a.x0, a.y0, a.width, a.height, a.visible, a.visible_share, a.first_word),
              std::tie(b.face, b.view, b.x0, b.y0, b.width, b.height, b.visible, b.visible_share, b.first_word))
        << "face " << index(b.face);
  }
  EXPECT_EQ(found.statistics.full, expected.statistics.full);
  EXPECT_EQ(found.statistics.partial, expected.statistics.partial);
}

inline std::size_t expect_oracle(const Mesh& mesh, const View& view, const ViewVisibility& found) {
  return expect_answer(view, found, oracle::classify(mesh, view));
}

}  // namespace gpvc::visibility
