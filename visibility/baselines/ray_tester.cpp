// RayTracing: a sample is visible unless the first intersection on the ray from the camera lies more than the bias in
// front of it. An intersection farther behind the sample (a ray of floats may slip past the edge of its own face) hides
// nothing.
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>

#include "visibility/baselines/ray_mesh.h"
#include "visibility/classify/front_faces.h"
#include "visibility/classify/view_tester.h"

namespace gpvc::visibility {
namespace {

using Target = RayMesh::Target;

/// The point at a position of the frame and a depth, seen from the camera centre, along the world's axes.
Target target_at(const View& of, double px, double py, double z, bool in_image) {
  const double x = (px - of.camera.cx) / of.camera.fx * z;
  const double y = (py - of.camera.cy) / of.camera.fy * z;
  const auto& r = of.pose.rotation;
  return {r[0] * x + r[3] * y + r[6] * z, r[1] * x + r[4] * y + r[7] * z, r[2] * x + r[5] * y + r[8] * z, in_image,
          false};
}

/// One ray per covered pixel centre (figure 19); faces that cover the same centre share it.
class DenseRays : public ViewTester {
 public:
  DenseRays(const Mesh& mesh, double epsilon, bool subpixel) : rays_(mesh), epsilon_(epsilon), subpixel_(subpixel) {}
  void classify(const PreparedView& view, const View& of, ViewVisibility& result) override;
  std::string note() const override { return "cpu: Embree traces there"; }

 private:
  bool sees(const PreparedView& view, std::int32_t x, std::int32_t y, double inverse_depth) const;

  RayMesh rays_;
  double epsilon_;
  bool subpixel_;
  bool built_ = false;
  FaceBlocks blocks_;
  std::vector<float> depths_;
};

void DenseRays::classify(const PreparedView& view, const View& of, ViewVisibility& result) {
  if (!std::exchange(built_, true)) result.statistics.build_s = rays_.build_s();
  const std::size_t primary = rays_.first_depths(view, of.pose, depths_);
  std::atomic<std::size_t> secondary{0};
  const auto sees_pixel = [&](std::int32_t x, std::int32_t y, double inverse_depth) {
    return sees(view, x, y, inverse_depth);
  };
  blocks_.run_samples(view, subpixel_, result, sees_pixel, [&](FaceId face) {
    secondary.fetch_add(kSubpixelSamples, std::memory_order_relaxed);
    std::array<Target, kSubpixelSamples> targets;
    const SubpixelPositions at = subpixel_positions(view, face);
    for (std::size_t k = 0; k < kSubpixelSamples; ++k)
      targets[k] = target_at(of, at.x[k], at.y[k], at.depth(k), view.in_image(at.x[k], at.y[k]));
    rays_.trace(of.pose, epsilon_, targets);
    return static_cast<std::uint32_t>(
        std::count_if(targets.begin(), targets.end(), [](const Target& t) { return t.visible; }));
  });
  result.statistics.rays = primary + secondary;
}

bool DenseRays::sees(const PreparedView& view, std::int32_t x, std::int32_t y, double inverse_depth) const {
  const double hit = depths_[view.pixel_index(x, y)];
  if (hit * inverse_depth >= 1) return true;
  // The bias is a length along the ray, which exceeds the depth difference; only near misses need the square root.
  if ((hit + epsilon_) * inverse_depth < 1) return false;
  const double nx = (x + 0.5 - view.camera.cx) / view.camera.fx;
  const double ny = (y + 0.5 - view.camera.cy) / view.camera.fy;
  return (hit + epsilon_ / std::sqrt(1 + nx * nx + ny * ny)) * inverse_depth >= 1;
}

/// One ray per vertex, shared by its faces.
class SparseRays : public ViewTester {
 public:
  SparseRays(const Mesh& mesh, double epsilon) : rays_(mesh), epsilon_(epsilon) {}
  void classify(const PreparedView& view, const View& of, ViewVisibility& result) override;
  std::string note() const override { return "cpu: Embree traces there"; }

 private:
  enum class Vertex : std::uint8_t { unused, wanted, visible };
  void want_vertices(const PreparedView& view);
  std::size_t trace_vertices(const PreparedView& view, const View& of);
  bool in_image(const PreparedView& view, const ProjectedVertex& v) const;

  RayMesh rays_;
  double epsilon_;
  bool built_ = false;
  FaceBlocks blocks_;
  std::vector<std::uint8_t> front_;  ///< per face: 1 if it faces the camera and may reach the frame
  std::vector<Vertex> vertices_;
};

void SparseRays::classify(const PreparedView& view, const View& of, ViewVisibility& result) {
  if (!std::exchange(built_, true)) result.statistics.build_s = rays_.build_s();
  want_vertices(view);
  const std::size_t traced = trace_vertices(view, of);
  blocks_.run(view, result, [&](FaceId face, FaceBlock& block) {
    if (front_[index(face)] == 0) return FaceClass::hidden;
    ++block.counts.processed_faces;
    const Triangle& t = view.mesh.faces[index(face)];
    const auto visible = static_cast<std::uint32_t>(
        std::count_if(t.begin(), t.end(), [&](std::uint32_t v) { return vertices_[v] == Vertex::visible; }));
    if (visible == 0) return FaceClass::hidden;
    if (visible == 3) return FaceClass::full;
    // Only vertices were tested: a share, and no pixels.
    add_share(view, face, visible, 3, block.coverage);
    return FaceClass::partial;
  });
  result.statistics.samples = result.statistics.rays = traced;
}

void SparseRays::want_vertices(const PreparedView& view) {
  front_.assign(view.mesh.faces.size(), 0);
  vertices_.assign(view.mesh.positions.size(), Vertex::unused);
  tbb::parallel_for(std::size_t{0}, front_.size(), [&](std::size_t f) {
    const FaceId face{static_cast<std::uint32_t>(f)};
    if (outside(view.bounds(face), view.camera.width, view.camera.height)) return;
    const RasterFace raster = view.raster(face);
    if (raster.facing != Facing::front || misses_frame(view.camera, raster.vertex)) return;
    front_[f] = 1;
    for (const std::uint32_t v : view.mesh.faces[f])
      std::atomic_ref(vertices_[v]).store(Vertex::wanted, std::memory_order_relaxed);
  });
}

bool SparseRays::in_image(const PreparedView& view, const ProjectedVertex& v) const {
  const double w = view.camera.width, h = view.camera.height;
  if (!(v.z > 0 && v.u >= 0 && v.v >= 0 && v.u <= w * v.z && v.v <= h * v.z)) return false;
  return view.mask.contains(PixelPoint{v.u / v.z, v.v / v.z});
}

std::size_t SparseRays::trace_vertices(const PreparedView& view, const View& of) {
  constexpr std::size_t kAtOnce = 16;
  std::atomic<std::size_t> traced{0};
  const auto trace_block = [&](std::size_t first, std::size_t last) {
    std::array<Target, kAtOnce> targets;
    std::array<std::size_t, kAtOnce> numbers{};
    std::size_t count = 0;
    const auto flush = [&] {
      rays_.trace(of.pose, epsilon_, std::span(targets).first(count));
      for (std::size_t i = 0; i < count; ++i)
        if (targets[i].visible) vertices_[numbers[i]] = Vertex::visible;
      traced.fetch_add(count, std::memory_order_relaxed);
      count = 0;
    };
    for (std::size_t v = first; v < last; ++v) {
      if (vertices_[v] != Vertex::wanted || !in_image(view, view.projected.vertices[v])) continue;
      numbers[count] = v;
      targets[count++] = rays_.target(view.mesh.positions[v], of.pose);
      if (count == kAtOnce) flush();
    }
    if (count > 0) flush();
  };
  constexpr std::size_t kBlock = 1024;  // fixed, so that the packets do not depend on the number of threads
  const std::size_t vertices = vertices_.size();
  tbb::parallel_for(std::size_t{0}, (vertices + kBlock - 1) / kBlock,
                    [&](std::size_t block) { trace_block(block * kBlock, std::min((block + 1) * kBlock, vertices)); });
  return traced;
}

}  // namespace

std::unique_ptr<ViewTester> make_tester(const RayTracing& method, const TesterInput& input) {
  if (method.sampling == RaySampling::sparse) return std::make_unique<SparseRays>(input.source.mesh(), method.epsilon);
  return std::make_unique<DenseRays>(input.source.mesh(), method.epsilon, input.subpixel);
}

}  // namespace gpvc::visibility
