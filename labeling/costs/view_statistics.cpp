#include "labeling/costs/view_statistics.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>

#include "labeling/costs/photo_gradient.h"
#include "labeling/costs/photo_lookup.h"
#include "labeling/costs/silhouettes.h"

namespace gpvc::labeling {
namespace {

constexpr std::uint32_t kNoSlot = 0xFFFFFFFFu;

/// Sums over a face's pixels; plain while a run of pixels is added up, atomic where runs meet.
struct PixelSums {
  std::uint64_t pixels = 0, margin = 0, gradient = 0;
  std::array<std::uint64_t, 3> color{};

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

/// The projection of a face, as far as costs need it.
struct FaceShape {
  InverseDepth plane;
  float area_px = 0;    ///< of the projection, unclipped by the image; 0 when a vertex lies far from that
  float cos_angle = 0;  ///< between normal and line of sight to the centroid
  float x = 0, y = 0;   ///< of the projected centroid
};

CameraPoint minus(const CameraPoint& a, const CameraPoint& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
double length(const CameraPoint& a) { return std::sqrt(a.x * a.x + a.y * a.y + a.z * a.z); }

class ViewPass {
 public:
  ViewPass(const Mesh& mesh, const View& view, const Image& photo, const visibility::ViewVisibility& visibility,
           const CostOptions& options)
      : mesh_(mesh), view_(view), photo_(photo), visibility_(visibility), options_(options), lookup_(view.camera) {}

  std::vector<FaceRecord> run() {
    list_faces();
    tbb::parallel_for(std::size_t{0}, faces_.size(), [&](std::size_t slot) { shapes_[slot] = shape(faces_[slot]); });
    if (options_.margin_px > 0)
      margin_ = silhouette_margin(view_.camera, visibility_.ivm, options_.margin_px, [this](FaceId face) {
        const std::uint32_t slot = slot_of_face_[index(face)];
        if (slot != kNoSlot) return shapes_[slot].plane;
        CameraPoint corners[3];
        load(static_cast<std::uint32_t>(face), corners);
        return inverse_depth(view_.camera, corners);
      });
    if (options_.term != DataTerm::area) gradient_ = gradient_magnitude(photo_);
    const int rows = visibility_.ivm.height;
    tbb::parallel_for(tbb::blocked_range<int>(0, rows, 16), [&](const tbb::blocked_range<int>& range) {
      for (int y = range.begin(); y != range.end(); ++y) add_row(y);
    });
    return records();
  }

 private:
  /// Gives every full or partial face a slot, in face order.
  void list_faces() {
    const auto& classes = visibility_.classes;
    slot_of_face_.assign(classes.size(), kNoSlot);
    for (std::uint32_t face = 0; face < classes.size(); ++face)
      if (classes[face] == visibility::FaceClass::full || classes[face] == visibility::FaceClass::partial) {
        slot_of_face_[face] = static_cast<std::uint32_t>(faces_.size());
        faces_.push_back(face);
      }
    sums_.resize(faces_.size());
    shapes_.resize(faces_.size());
  }

  void load(std::uint32_t face, CameraPoint (&corners)[3]) const {
    for (std::size_t i = 0; i < 3; ++i)
      corners[i] = camera_from_world(view_.pose, mesh_.positions[mesh_.faces[face][i]]);
  }

  /// Within what FaceCoverage::visible_share is a share of. Beyond, the projection of a face that ends close to the
  /// camera plane is of any size.
  bool is_near(const PixelPoint& p) const {
    const double w = view_.camera.width, h = view_.camera.height;
    return p.x >= -w && p.x <= 2 * w && p.y >= -h && p.y <= 2 * h;
  }

  FaceShape shape(std::uint32_t face) const {
    CameraPoint p[3];
    load(face, p);
    FaceShape result;
    result.plane = inverse_depth(view_.camera, p);
    const CameraPoint centroid{(p[0].x + p[1].x + p[2].x) / 3, (p[0].y + p[1].y + p[2].y) / 3,
                               (p[0].z + p[1].z + p[2].z) / 3};
    const CameraPoint u = minus(p[1], p[0]), v = minus(p[2], p[0]);
    const CameraPoint n{u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x};
    const double norm = length(n) * length(centroid);
    if (norm > 0)
      result.cos_angle = static_cast<float>(std::abs(n.x * centroid.x + n.y * centroid.y + n.z * centroid.z) / norm);
    if (centroid.z > 0) {
      const PixelPoint pixel = pixel_from_camera(view_.camera, centroid);
      result.x = static_cast<float>(pixel.x);
      result.y = static_cast<float>(pixel.y);
    }
    if (p[0].z > 0 && p[1].z > 0 && p[2].z > 0) {
      const PixelPoint a = pixel_from_camera(view_.camera, p[0]), b = pixel_from_camera(view_.camera, p[1]),
                       c = pixel_from_camera(view_.camera, p[2]);
      if (is_near(a) && is_near(b) && is_near(c))
        result.area_px = static_cast<float>(std::abs((b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y)) / 2);
    }
    return result;
  }

  void add_pixel(std::size_t frame_pixel, std::size_t photo_pixel, PixelSums& sums) const {
    ++sums.pixels;
    if (!margin_.empty()) sums.margin += margin_[frame_pixel];
    if (!gradient_.empty()) sums.gradient += gradient_[photo_pixel];
    const std::uint8_t* rgb = photo_.pixels.data() + 3 * photo_pixel;
    for (std::size_t c = 0; c < 3; ++c) sums.color[c] += rgb[c];
  }

  /// Adds a row, run by run: neighbours mostly show the same face, and only a run's end touches shared memory.
  void add_row(int y) {
    const PhotoLookup::Row row = lookup_.row(y);
    const int width = visibility_.ivm.width;
    const std::size_t first = static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
    const FaceId* faces = visibility_.ivm.faces.data() + first;
    for (int x = 0; x < width;) {
      const FaceId face = faces[x];
      const std::uint32_t slot = face == kNoFace ? kNoSlot : slot_of_face_[index(face)];
      PixelSums run;
      for (; x < width && faces[x] == face; ++x) {
        if (slot == kNoSlot) continue;
        if (const auto photo_pixel = row.pixel(x)) add_pixel(first + static_cast<std::size_t>(x), *photo_pixel, run);
      }
      if (run.pixels > 0) run.add_to(sums_[slot]);
    }
  }

  /// For a face that owns no pixel: the one its centroid lies in.
  void add_centroid(const FaceShape& face_shape, PixelSums& sums) const {
    const visibility::Ivm& ivm = visibility_.ivm;
    const int x = std::clamp(static_cast<int>(face_shape.x), 0, ivm.width - 1);
    const int y = std::clamp(static_cast<int>(face_shape.y), 0, ivm.height - 1);
    const std::size_t pixel =
        static_cast<std::size_t>(y) * static_cast<std::size_t>(ivm.width) + static_cast<std::size_t>(x);
    if (const auto photo_pixel = lookup_.pixel(x, y)) add_pixel(pixel, *photo_pixel, sums);
  }

  FaceRecord record(std::size_t slot, double visible_share) const {
    PixelSums sums = sums_[slot];
    const FaceShape& face_shape = shapes_[slot];
    if (sums.pixels == 0) add_centroid(face_shape, sums);
    FaceRecord result;
    result.face = faces_[slot];
    result.visible = visible_share >= 1 ? kWholeShare : std::min<Share16>(share16(visible_share), kWholeShare - 1);
    if (sums.pixels == 0) return result;
    const auto pixels = static_cast<double>(sums.pixels);
    double quality = face_shape.area_px > 0 ? static_cast<double>(face_shape.area_px) * visible_share : pixels;
    if (options_.term != DataTerm::area) quality *= static_cast<double>(sums.gradient) / (kGradientUnit * pixels);
    if (options_.term == DataTerm::gmi_angle)
      quality *= static_cast<double>(face_shape.cos_angle) * static_cast<double>(face_shape.cos_angle);
    result.quality = static_cast<float>(quality);
    result.margin = share16(static_cast<double>(sums.margin) / pixels);
    for (std::size_t c = 0; c < 3; ++c)
      result.color[c] = static_cast<std::uint16_t>((sums.color[c] * 256 + sums.pixels / 2) / sums.pixels);
    return result;
  }

  std::vector<FaceRecord> records() const {
    // Both lists are in face order.
    std::vector<float> visible(faces_.size(), 1.0f);
    const auto& entries = visibility_.coverage.entries;
    std::size_t entry = 0;
    for (std::size_t slot = 0; slot < faces_.size(); ++slot) {
      if (visibility_.classes[faces_[slot]] == visibility::FaceClass::full) continue;
      while (entry < entries.size() && index(entries[entry].face) < faces_[slot]) ++entry;
      const bool found = entry < entries.size() && index(entries[entry].face) == faces_[slot];
      visible[slot] = found ? std::min(entries[entry].visible_share, kPartialShareAtMost) : 0.5f;
    }
    std::vector<FaceRecord> result(faces_.size());
    tbb::parallel_for(std::size_t{0}, faces_.size(),
                      [&](std::size_t slot) { result[slot] = record(slot, static_cast<double>(visible[slot])); });
    return result;
  }

  /// Partial though every in-image sample sees it: a vertex lies outside the image.
  static constexpr float kPartialShareAtMost = 65534.0f / 65535.0f;

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
                                        const visibility::ViewVisibility& visibility, const CostOptions& options) {
  return ViewPass(mesh, view, photo, visibility, options).run();
}

}  // namespace gpvc::labeling
