// Small scenes of rectangles and painted photos, and what a view sees of them by definition: for tests of statistics
// and costs.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <vector>

#include "io/image.h"
#include "io/scene.h"
#include "labeling/costs/silhouettes.h"
#include "visibility/result.h"

namespace gpvc::test {

inline constexpr int kWidth = 64, kHeight = 48;

/// 64 x 48 pixels, f = 64 px, looking along +z from `x` to the right of the origin: at z = 8 a pixel is 1/8 wide.
inline View view_from(double x) {
  View view;
  view.camera = {kWidth, kHeight, 64, 64, 32, 24, {}};
  view.pose.centre = {x, 0, 0};
  return view;
}

/// Adds the rectangle as cells of two triangles each, facing a camera that looks along +z.
inline void add_rectangle(Mesh& mesh, double x0, double y0, double x1, double y1, double z, int cells) {
  const auto base = static_cast<std::uint32_t>(mesh.positions.size());
  const auto stride = static_cast<std::uint32_t>(cells + 1);
  for (int j = 0; j <= cells; ++j)
    for (int i = 0; i <= cells; ++i)
      mesh.positions.push_back({x0 + (x1 - x0) * i / cells, y0 + (y1 - y0) * j / cells, z});
  for (std::uint32_t j = 0; j + 1 < stride; ++j)
    for (std::uint32_t i = 0; i + 1 < stride; ++i) {
      const std::uint32_t a = base + j * stride + i, b = a + 1, c = a + stride, d = c + 1;
      mesh.faces.push_back({a, c, b});
      mesh.faces.push_back({b, c, d});
    }
}

/// Visibility by definition: every pixel centre against every triangle.
inline visibility::ViewVisibility look(const Mesh& mesh, const View& view, ViewId id = {}) {
  visibility::ViewVisibility result;
  result.ivm = {kWidth, kHeight, std::vector<FaceId>(kWidth * kHeight, kNoFace)};
  std::vector<double> nearest(kWidth * kHeight, 1e300);
  std::vector<std::uint32_t> samples(mesh.faces.size()), seen(mesh.faces.size());
  PixelPoint p[3];
  CameraPoint c[3];
  const auto load = [&](std::uint32_t face) {
    for (std::size_t i = 0; i < 3; ++i) {
      c[i] = camera_from_world(view.pose, mesh.positions[mesh.faces[face][i]]);
      p[i] = pixel_from_camera(view.camera, c[i]);
    }
  };
  const auto depth_at = [&](double px, double py) -> double {
    double inverse = 0, area = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const PixelPoint &a = p[(i + 1) % 3], &b = p[(i + 2) % 3];
      const double edge = (b.x - a.x) * (py - a.y) - (b.y - a.y) * (px - a.x);
      if (edge >= 0) return 0;  // counter-clockwise from outside is clockwise with y down
      inverse += edge / c[i].z;
      area += edge;
    }
    return area / inverse;
  };
  // Samples lie on the unbounded grid; 40 pixels beyond the image is unbounded enough for these scenes.
  for (std::uint32_t face = 0; face < mesh.faces.size(); ++face) {
    load(face);
    for (int y = -40; y < kHeight + 40; ++y)
      for (int x = -40; x < kWidth + 40; ++x) {
        const double depth = depth_at(x + 0.5, y + 0.5);
        if (depth == 0) continue;
        ++samples[face];
        if (x < 0 || y < 0 || x >= kWidth || y >= kHeight) continue;
        const auto pixel = static_cast<std::size_t>(y * kWidth + x);
        if (depth < nearest[pixel]) {
          nearest[pixel] = depth;
          result.ivm.faces[pixel] = FaceId{face};
        }
      }
  }
  for (const FaceId face : result.ivm.faces)
    if (face != kNoFace) ++seen[index(face)];
  for (std::uint32_t face = 0; face < mesh.faces.size(); ++face) {
    const bool full = samples[face] > 0 && seen[face] == samples[face];
    result.classes.push_back(full             ? visibility::FaceClass::full
                             : seen[face] > 0 ? visibility::FaceClass::partial
                                              : visibility::FaceClass::hidden);
    if (result.classes.back() != visibility::FaceClass::partial) continue;
    visibility::FaceCoverage entry;
    entry.face = FaceId{face};
    entry.view = id;
    entry.visible = seen[face];
    entry.visible_share = static_cast<float>(seen[face]) / static_cast<float>(samples[face]);
    result.coverage.entries.push_back(entry);
  }
  return result;
}

/// One byte a pixel, 1 in the strip along depth discontinuities.
inline std::vector<std::uint8_t> strip_of(const labeling::Silhouettes& silhouettes,
                                          const labeling::StripRows::FindFaces& find_faces) {
  std::vector<std::uint8_t> result;
  labeling::StripRows rows;
  for (const auto& [begin, end] : {std::pair{0, 1}, {1, 20}, {20, kHeight}}) {
    rows.start(silhouettes, begin, end, find_faces);
    while (rows.next())
      for (std::size_t x = 0; x < std::size_t{kWidth}; ++x)
        result.push_back(static_cast<std::uint8_t>(rows.strip()[x / 64] >> (x % 64) & 1));
  }
  return result;
}

/// The strip that the stage would find in this view.
inline std::vector<std::uint8_t> margin_of(const Mesh& mesh, const View& view, int margin_px) {
  const visibility::ViewVisibility seen = look(mesh, view);
  return strip_of({view.camera, seen.ivm, margin_px}, [&](const auto& faces, const auto& found) {
    for (std::size_t i = 0; i < faces.size(); ++i)
      if (faces[i] != kNoFace)
        found[i].plane =
            labeling::inverse_depth(view.camera, labeling::camera_corners(mesh, index(faces[i]), view.pose));
  });
}

using Color = std::array<int, 3>;

inline Image paint(const std::function<Color(int, int)>& color) {
  Image image{kWidth, kHeight, 3, std::vector<std::uint8_t>(kWidth * kHeight * 3)};
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      for (std::size_t c = 0; c < 3; ++c) image.at(x, y)[c] = static_cast<std::uint8_t>(color(x, y)[c]);
  return image;
}

inline Image grey(int level) {
  return paint([=](int, int) { return Color{level, level, level}; });
}

}  // namespace gpvc::test
