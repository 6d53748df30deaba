#include "labeling/costs/silhouettes.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace gpvc::labeling {
namespace {

constexpr std::uint8_t kHere = 1;   ///< the pixel touches a step to its left, to its right or below it
constexpr std::uint8_t kBelow = 2;  ///< the step is below the pixel, so that the pixel below touches it, too

/// What a pixel shows.
struct Shown {
  FaceId face;
  const InverseDepth& plane;  ///< of the face, if there is one
  int x, y;
};

/// Decides whether two neighbouring pixels lie across a discontinuity.
class StepTest {
 public:
  StepTest(const Camera& camera, int margin_px)
      : camera_(camera), footprints_(static_cast<float>(margin_px / std::sqrt(camera.fx * camera.fy))) {}

  bool operator()(const Shown& a, const Shown& b) const {
    if (a.face == kNoFace) return in_photo(camera_, {a.x + 0.5, a.y + 0.5});
    if (b.face == kNoFace) return in_photo(camera_, {b.x + 0.5, b.y + 0.5});
    const auto relative = [](int pixel, double centre) { return static_cast<float>(pixel + 0.5 - centre); };
    const float x0 = relative(a.x, camera_.cx), y0 = relative(a.y, camera_.cy);
    const float x1 = relative(b.x, camera_.cx), y1 = relative(b.y, camera_.cy);
    const float gap0 = a.plane.at(x0, y0) - b.plane.at(x0, y0);
    const float gap1 = a.plane.at(x1, y1) - b.plane.at(x1, y1);
    // |1/wa - 1/wb| > margin / (f w_near)  <=>  |wa - wb| > margin / f * w_far
    const float far = std::min(a.plane.at(x0, y0), b.plane.at(x1, y1));
    // Few pairs pass the first test, while the signs of small gaps cannot be predicted.
    return std::min(std::abs(gap0), std::abs(gap1)) > footprints_ * far && (gap0 > 0) == (gap1 > 0);
  }

 private:
  const Camera& camera_;
  float footprints_;
};

/// The planes of the faces in one row; one call of plane_of for each run of equal faces.
void find_planes(const FaceId* row, const std::function<InverseDepth(FaceId)>& plane_of,
                 std::vector<InverseDepth>& planes) {
  for (std::size_t x = 0; x < planes.size(); ++x)
    if (x > 0 && row[x] == row[x - 1])
      planes[x] = planes[x - 1];
    else if (row[x] != kNoFace)
      planes[x] = plane_of(row[x]);
}

std::vector<std::uint8_t> find_steps(const visibility::Ivm& ivm, const StepTest& is_step,
                                     const std::function<InverseDepth(FaceId)>& plane_of) {
  const auto width = static_cast<std::size_t>(ivm.width);
  std::vector<std::uint8_t> steps(width * static_cast<std::size_t>(ivm.height));
  tbb::parallel_for(tbb::blocked_range<int>(0, ivm.height, 64), [&](const tbb::blocked_range<int>& rows) {
    std::vector<InverseDepth> here(width), below(width);
    const auto row_at = [&](int y) { return ivm.faces.data() + static_cast<std::size_t>(y) * width; };
    find_planes(row_at(rows.begin()), plane_of, here);
    for (int y = rows.begin(); y != rows.end(); ++y) {
      const FaceId* row = row_at(y);
      std::uint8_t* out = steps.data() + static_cast<std::size_t>(y) * width;
      const auto shown = [&](int x) { return Shown{row[x], here[static_cast<std::size_t>(x)], x, y}; };
      for (int x = 0; x + 1 < ivm.width; ++x)
        if (row[x] != row[x + 1] && is_step(shown(x), shown(x + 1))) {
          out[x] |= kHere;
          out[x + 1] |= kHere;
        }
      if (y + 1 == ivm.height) continue;
      const FaceId* next = row_at(y + 1);
      find_planes(next, plane_of, below);
      for (int x = 0; x < ivm.width; ++x)
        if (row[x] != next[x] && is_step(shown(x), {next[x], below[static_cast<std::size_t>(x)], x, y + 1}))
          out[x] |= kHere | kBelow;
      std::swap(here, below);
    }
  });
  return steps;
}

/// to |= from & bits. Bytes may alias anything; __restrict lets the compiler vectorize the loop.
void unite(std::uint8_t* __restrict to, const std::uint8_t* __restrict from, std::uint8_t bits, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) to[i] = static_cast<std::uint8_t>(to[i] | (from[i] & bits));
}

/// row[i] becomes the union of row[i] to row[i + length - 1]; the last length - 1 elements are padding. `copy` is work
/// space.
void unite_runs(std::vector<std::uint8_t>& row, std::vector<std::uint8_t>& copy, std::size_t length) {
  for (std::size_t done = 1; done < length;) {
    const std::size_t step = std::min(done, length - done);
    copy = row;
    unite(row.data(), copy.data() + step, 0xFF, row.size() - step);
    done += step;
  }
}

}  // namespace

CameraTriangle camera_corners(const Mesh& mesh, std::size_t face, const Pose& pose) {
  CameraTriangle corners;
  for (std::size_t i = 0; i < 3; ++i) corners[i] = camera_from_world(pose, mesh.positions[mesh.faces[face][i]]);
  return corners;
}

CameraPoint area_normal(const CameraTriangle& corners) {
  const auto& [a, b, c] = corners;
  const double ux = b.x - a.x, uy = b.y - a.y, uz = b.z - a.z;
  const double vx = c.x - a.x, vy = c.y - a.y, vz = c.z - a.z;
  return {uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx};
}

InverseDepth inverse_depth(const Camera& camera, const CameraTriangle& corners) {
  const CameraPoint n = area_normal(corners);
  const CameraPoint& a = corners[0];
  const double offset = n.x * a.x + n.y * a.y + n.z * a.z;  // n . X = offset, X = z (u, v, 1)
  if (offset == 0) return {};
  return {static_cast<float>(n.x / (offset * camera.fx)), static_cast<float>(n.y / (offset * camera.fy)),
          static_cast<float>(n.z / offset)};
}

std::vector<std::uint8_t> silhouette_margin(const Camera& camera, const visibility::Ivm& ivm, int margin_px,
                                            const std::function<InverseDepth(FaceId)>& plane_of) {
  const auto width = static_cast<std::size_t>(ivm.width);
  const std::vector<std::uint8_t> steps = find_steps(ivm, StepTest(camera, margin_px), plane_of);
  std::vector<std::uint8_t> margin(steps.size());
  const int reach = margin_px - 1;  // pixels that touch the step are within one pixel of it
  tbb::parallel_for(tbb::blocked_range<int>(0, ivm.height, 16), [&](const tbb::blocked_range<int>& rows) {
    // Grows by a square: first over rows, then along the row. Padding spares the inner loops their ends.
    const auto pad = static_cast<std::size_t>(reach);
    std::vector<std::uint8_t> united(width + 2 * pad), work;
    for (int y = rows.begin(); y != rows.end(); ++y) {
      std::fill(united.begin(), united.end(), std::uint8_t{0});
      for (int other = std::max(0, y - margin_px); other <= std::min(ivm.height - 1, y + reach); ++other) {
        const std::uint8_t* in = steps.data() + static_cast<std::size_t>(other) * width;
        const std::uint8_t bits = other == y - margin_px ? kBelow : kHere | kBelow;
        unite(united.data() + pad, in, bits, width);
      }
      unite_runs(united, work, 2 * pad + 1);
      std::uint8_t* out = margin.data() + static_cast<std::size_t>(y) * width;
      std::transform(united.begin(), united.begin() + static_cast<std::ptrdiff_t>(width), out,
                     [](std::uint8_t any) { return static_cast<std::uint8_t>(any != 0); });
    }
  });
  return margin;
}

}  // namespace gpvc::labeling
