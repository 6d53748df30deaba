#include "labeling/costs/view_statistics.h"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

#include "labeling/costs/photo_lookup.h"
#include "labeling/costs/silhouettes.h"

namespace gpvc::labeling {
namespace {

// --- gradient

constexpr int kGradientUnit = 8;

/// Rec. 601 luma in grey levels, with the first and the last pixel repeated.
void luma_row(const Image& photo, int y, std::vector<std::int16_t>& out) {
  const auto width = static_cast<std::size_t>(photo.width);
  const std::uint8_t* in = photo.at(0, std::clamp(y, 0, photo.height - 1));
  for (std::size_t x = 0; x < width; ++x)
    out[x + 1] = static_cast<std::int16_t>((77 * in[3 * x] + 150 * in[3 * x + 1] + 29 * in[3 * x + 2] + 128) >> 8);
  out[0] = out[1];
  out[width + 1] = out[width];
}

void gradient_row(const std::int16_t* above, const std::int16_t* here, const std::int16_t* below, std::uint16_t* out,
                  std::size_t width) {
  for (std::size_t x = 0; x < width; ++x) {
    const int dx = above[x + 2] - above[x] + 2 * (here[x + 2] - here[x]) + below[x + 2] - below[x];
    const int dy = below[x] - above[x] + 2 * (below[x + 1] - above[x + 1]) + below[x + 2] - above[x + 2];
    out[x] = static_cast<std::uint16_t>(static_cast<int>(std::sqrt(static_cast<float>(dx * dx + dy * dy)) + 0.5f));
  }
}

/// Per pixel, row-major: gradient magnitude of luma in 1/kGradientUnit grey levels a pixel, rounded (Sobel's kernel, whose
/// weights sum to 8; the outermost pixels are repeated beyond the border). O(pixels), TBB inside.
std::vector<std::uint16_t> gradient_magnitude(const Image& photo) {
  const auto width = static_cast<std::size_t>(photo.width);
  std::vector<std::uint16_t> gradient(width * static_cast<std::size_t>(photo.height));
  tbb::parallel_for(tbb::blocked_range<int>(0, photo.height, 32), [&](const tbb::blocked_range<int>& rows) {
    std::array<std::vector<std::int16_t>, 3> luma;
    for (auto& row : luma) row.resize(width + 2);
    const auto slot = [](int y) { return static_cast<std::size_t>(y + 3) % 3; };
    luma_row(photo, rows.begin() - 1, luma[slot(rows.begin() - 1)]);
    luma_row(photo, rows.begin(), luma[slot(rows.begin())]);
    for (int y = rows.begin(); y != rows.end(); ++y) {
      luma_row(photo, y + 1, luma[slot(y + 1)]);
      gradient_row(luma[slot(y - 1)].data(), luma[slot(y)].data(), luma[slot(y + 1)].data(),
                   gradient.data() + static_cast<std::size_t>(y) * width, width);
    }
  });
  return gradient;
}

// --- statistics

constexpr std::uint32_t kNoSlot = 0xFFFFFFFFu;

/// Sums over pixels of a face.
struct PixelSums {
  std::uint64_t pixels = 0, margin = 0, gradient = 0;
  std::array<std::uint64_t, 3> color{};

  PixelSums& operator+=(const PixelSums& other) {
    pixels += other.pixels;
    margin += other.margin;
    gradient += other.gradient;
    for (std::size_t c = 0; c < 3; ++c) color[c] += other.color[c];
    return *this;
  }

  /// Adds to a sum that several threads add to.
  void add_to(PixelSums& total) const {
    const auto add = [](std::uint64_t& to, std::uint64_t value) {
      std::atomic_ref<std::uint64_t>(to).fetch_add(value, std::memory_order_relaxed);
    };
    add(total.pixels, pixels);
    if (margin != 0) add(total.margin, margin);
    add(total.gradient, gradient);
    for (std::size_t c = 0; c < 3; ++c) add(total.color[c], color[c]);
  }
};

/// The sums over a block of rows, which one thread collects, so that threads share memory once a face and block.
class BlockSums {
 public:
  void start(std::size_t slots) {
    place_.resize(slots, kNoSlot);
    sums_.clear();
    slots_.clear();
  }
  PixelSums& sums_of(std::uint32_t slot) {
    if (place_[slot] == kNoSlot) {
      place_[slot] = static_cast<std::uint32_t>(sums_.size());
      slots_.push_back(slot);
      sums_.emplace_back();
    }
    return sums_[place_[slot]];
  }
  /// Adds everything to the totals.
  void add_to(std::vector<PixelSums>& totals) {
    for (std::size_t i = 0; i < slots_.size(); ++i) {
      if (sums_[i].pixels > 0) sums_[i].add_to(totals[slots_[i]]);
      place_[slots_[i]] = kNoSlot;
    }
  }

  std::vector<std::uint32_t> photo_pixels;  ///< of the current row

 private:
  std::vector<std::uint32_t> place_;  ///< per slot, its place in sums_
  std::vector<std::uint32_t> slots_;
  std::vector<PixelSums> sums_;
};

double length(const CameraPoint& a) { return std::sqrt(a.x * a.x + a.y * a.y + a.z * a.z); }

/// What costs need of a face's projection.
struct FaceShape {
  InverseDepth plane;
  float area_px = 0;    ///< of the projection, unclipped by the image; 0 if a vertex lies far outside the image
  float cos_angle = 0;  ///< between normal and line of sight to the centroid
  float x = 0, y = 0;   ///< of the projected centroid
};

/// True within the region that FaceCoverage::visible_share refers to. The projection of a face that ends close to the
/// camera plane grows without bound beyond it.
bool is_near(const Camera& camera, const PixelPoint& p) {
  const double w = camera.width, h = camera.height;
  return p.x >= -w && p.x <= 2 * w && p.y >= -h && p.y <= 2 * h;
}

/// Area of the projection in pixels; 0 unless all corners lie in front of the camera and near the image.
double projected_area(const Camera& camera, const CameraTriangle& p) {
  std::array<PixelPoint, 3> q;
  for (std::size_t i = 0; i < 3; ++i) {
    if (!(p[i].z > 0)) return 0;
    q[i] = pixel_from_camera(camera, p[i]);
    if (!is_near(camera, q[i])) return 0;
  }
  const auto& [a, b, c] = q;
  return std::abs((b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y)) / 2;
}

FaceShape shape_of(const Camera& camera, const CameraTriangle& p) {
  FaceShape result;
  result.plane = inverse_depth(camera, p);
  result.area_px = static_cast<float>(projected_area(camera, p));
  const CameraPoint centroid{(p[0].x + p[1].x + p[2].x) / 3, (p[0].y + p[1].y + p[2].y) / 3,
                             (p[0].z + p[1].z + p[2].z) / 3};
  const CameraPoint n = area_normal(p);
  const double norm = length(n) * length(centroid);
  if (norm > 0)
    result.cos_angle = static_cast<float>(std::abs(n.x * centroid.x + n.y * centroid.y + n.z * centroid.z) / norm);
  if (centroid.z > 0) {
    const PixelPoint pixel = pixel_from_camera(camera, centroid);
    result.x = static_cast<float>(pixel.x);
    result.y = static_cast<float>(pixel.y);
  }
  return result;
}

/// The data term: how good the view is for a face. Another term belongs here, in DataTerm and in kDataTermNames.
double quality_of(DataTerm term, const FaceShape& shape, double visible_share, const PixelSums& sums) {
  const auto pixels = static_cast<double>(sums.pixels);
  double quality = shape.area_px > 0 ? static_cast<double>(shape.area_px) * visible_share : pixels;
  if (term != DataTerm::area) quality *= static_cast<double>(sums.gradient) / (kGradientUnit * pixels);
  if (term == DataTerm::gmi_angle)
    quality *= static_cast<double>(shape.cos_angle) * static_cast<double>(shape.cos_angle);
  return quality;
}

/// One view's pass over its IVM.
class ViewPass {
 public:
  ViewPass(const Mesh& mesh, const View& view, const Image& photo, const visibility::ViewVisibility& visibility,
           const CostOptions& options)
      : mesh_(mesh), view_(view), photo_(photo), visibility_(visibility), options_(options), lookup_(view.camera) {}

  std::vector<FaceRecord> run(std::span<const std::uint8_t> wanted) {
    list_faces(wanted);
    tbb::parallel_for(std::size_t{0}, faces_.size(),
                      [&](std::size_t slot) { shapes_[slot] = shape_of(view_.camera, corners(faces_[slot])); });
    if (options_.margin_px > 0)
      margin_ = silhouette_margin(view_.camera, visibility_.ivm, options_.margin_px, [this](FaceId face) {
        const std::uint32_t slot = slot_of_face_[index(face)];
        return slot != kNoSlot ? shapes_[slot].plane : inverse_depth(view_.camera, corners(index(face)));
      });
    if (options_.term != DataTerm::area) gradient_ = gradient_magnitude(photo_);
    tbb::enumerable_thread_specific<BlockSums> blocks;
    const int rows = visibility_.ivm.height;
    tbb::parallel_for(tbb::blocked_range<int>(0, rows, 64), [&](const tbb::blocked_range<int>& range) {
      BlockSums& block = blocks.local();
      block.start(faces_.size());
      for (int y = range.begin(); y != range.end(); ++y) add_row(y, block);
      block.add_to(sums_);
    });
    const std::vector<float> visible = visible_shares();
    std::vector<FaceRecord> records(faces_.size());
    tbb::parallel_for(std::size_t{0}, faces_.size(),
                      [&](std::size_t slot) { records[slot] = record(slot, static_cast<double>(visible[slot])); });
    return records;
  }

 private:
  /// Gives every wanted face that is full or partial a slot, in face order.
  void list_faces(std::span<const std::uint8_t> wanted) {
    const auto& classes = visibility_.classes;
    slot_of_face_.assign(classes.size(), kNoSlot);
    for (std::uint32_t face = 0; face < classes.size(); ++face)
      if ((classes[face] == visibility::FaceClass::full || classes[face] == visibility::FaceClass::partial) &&
          (wanted.empty() || wanted[face] != 0)) {
        slot_of_face_[face] = static_cast<std::uint32_t>(faces_.size());
        faces_.push_back(face);
      }
    sums_.resize(faces_.size());
    shapes_.resize(faces_.size());
  }

  CameraTriangle corners(std::size_t face) const { return camera_corners(mesh_, face, view_.pose); }

  void add_pixel(std::size_t frame_pixel, std::size_t photo_pixel, PixelSums& sums) const {
    ++sums.pixels;
    if (!margin_.empty()) sums.margin += margin_[frame_pixel];
    if (!gradient_.empty()) sums.gradient += gradient_[photo_pixel];
    const std::uint8_t* rgb = photo_.pixels.data() + 3 * photo_pixel;
    for (std::size_t c = 0; c < 3; ++c) sums.color[c] += rgb[c];
  }

  /// Adds a row run by run: neighbouring pixels mostly show the same face.
  void add_row(int y, BlockSums& block) const {
    lookup_.find_row(y, block.photo_pixels);
    const int width = visibility_.ivm.width;
    const std::size_t first = static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
    const FaceId* faces = visibility_.ivm.faces.data() + first;
    for (int x = 0; x < width;) {
      const FaceId face = faces[x];
      const std::uint32_t slot = face == kNoFace ? kNoSlot : slot_of_face_[index(face)];
      if (slot == kNoSlot) {
        while (x < width && faces[x] == face) ++x;
        continue;
      }
      PixelSums run;
      for (; x < width && faces[x] == face; ++x) {
        const auto at = static_cast<std::size_t>(x);
        if (block.photo_pixels[at] != PhotoLookup::kNoPixel) add_pixel(first + at, block.photo_pixels[at], run);
      }
      block.sums_of(slot) += run;
    }
  }

  /// For a face that owns no pixel: the pixel that its centroid lies in, or the nearest one.
  void add_centroid(const FaceShape& shape, PixelSums& sums) const {
    const visibility::Ivm& ivm = visibility_.ivm;
    // Close to the camera plane, projections exceed the range of int.
    const auto pixel = [](float at, int size) {
      return static_cast<int>(std::clamp(at, 0.0F, static_cast<float>(size - 1)));
    };
    const int x = pixel(shape.x, ivm.width), y = pixel(shape.y, ivm.height);
    if (const auto photo_pixel = lookup_.pixel(x, y)) add_pixel(pixel_index(x, y, ivm.width), *photo_pixel, sums);
  }

  FaceRecord record(std::size_t slot, double visible_share) const {
    PixelSums sums = sums_[slot];
    const FaceShape& face_shape = shapes_[slot];
    if (sums.pixels == 0) add_centroid(face_shape, sums);
    FaceRecord result;
    result.face = faces_[slot];
    result.visible = visible_share >= 1 ? kWholeShare : std::min<Share16>(share16(visible_share), kWholeShare - 1);
    if (sums.pixels == 0) return result;
    result.quality = static_cast<float>(quality_of(options_.term, face_shape, visible_share, sums));
    result.margin = share16(static_cast<double>(sums.margin) / static_cast<double>(sums.pixels));
    for (std::size_t c = 0; c < 3; ++c)
      result.color[c] = static_cast<std::uint16_t>((sums.color[c] * 256 + sums.pixels / 2) / sums.pixels);
    return result;
  }

  /// The visible share of every listed face. Both lists are in face order.
  std::vector<float> visible_shares() const {
    std::vector<float> visible(faces_.size(), 1.0f);
    const auto& entries = visibility_.coverage.entries;
    std::size_t entry = 0;
    for (std::size_t slot = 0; slot < faces_.size(); ++slot) {
      if (visibility_.classes[faces_[slot]] == visibility::FaceClass::full) continue;
      while (entry < entries.size() && index(entries[entry].face) < faces_[slot]) ++entry;
      const bool found = entry < entries.size() && index(entries[entry].face) == faces_[slot];
      visible[slot] = found ? std::min(entries[entry].visible_share, kMaxPartialShare) : 0.5f;
    }
    return visible;
  }

  /// A face is partial although every in-image sample sees it if a vertex lies outside the image.
  static constexpr float kMaxPartialShare = 65534.0f / 65535.0f;

  const Mesh& mesh_;
  const View& view_;
  const Image& photo_;
  const visibility::ViewVisibility& visibility_;
  const CostOptions& options_;
  PhotoLookup lookup_;
  std::vector<std::uint32_t> slot_of_face_, faces_;
  std::vector<PixelSums> sums_;
  std::vector<FaceShape> shapes_;
  std::vector<std::uint8_t> margin_;
  std::vector<std::uint16_t> gradient_;
};

}  // namespace

Share16 share16(double share) { return static_cast<Share16>(std::lround(std::clamp(share, 0.0, 1.0) * kWholeShare)); }

std::vector<FaceRecord> view_statistics(const Mesh& mesh, const View& view, const Image& photo,
                                        const visibility::ViewVisibility& visibility, const CostOptions& options,
                                        std::span<const std::uint8_t> wanted) {
  return ViewPass(mesh, view, photo, visibility, options).run(wanted);
}

}  // namespace gpvc::labeling
