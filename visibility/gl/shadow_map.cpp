// ShadowMap: the depth of every sample is compared with the nearest depth drawn at its pixel.
#include <algorithm>

#include "visibility/classify/front_faces.h"
#include "visibility/classify/view_tester.h"

namespace gpvc::visibility {
namespace {

class ShadowMapTester : public ViewTester {
 public:
  ShadowMapTester(const ViewSource& source, double epsilon, bool subpixel)
      : source_(source), epsilon_(epsilon), subpixel_(subpixel) {}
  void classify(const ClassifyView& view, const View& of, ViewVisibility& result) override;
  std::string note() const override { return "cpu: shadow maps are compared there"; }

 private:
  FaceClass classify_face(const ClassifyView& view, FaceBlock& block) const;
  FaceClass classify_subpixel(const ClassifyView& view, FaceBlock& block) const;
  /// True if the point of the surface at 1 / z = `inverse_depth` is visible through pixel (x, y).
  bool sees(const ClassifyView& view, std::int32_t x, std::int32_t y, double inverse_depth) const {
    const double stored = depths_[static_cast<std::size_t>(y) * static_cast<std::size_t>(view.camera.width) +
                                  static_cast<std::size_t>(x)];
    return nearness_ * inverse_depth + offset_ <= farness_ * stored + epsilon_;
  }

  const ViewSource& source_;
  double epsilon_;
  bool subpixel_;
  FaceBlocks blocks_;
  std::span<const float> depths_;
  /// Window depth grows with distance under SPC and shrinks under APC: farness_ is 1 or -1, and farness_ times the
  /// depth of a point is nearness_ / z + offset_.
  double farness_ = 1, nearness_ = 0, offset_ = 0;
};

void ShadowMapTester::classify(const ClassifyView& view, const View&, ViewVisibility& result) {
  depths_ = source_.depths();
  const DepthMapping& mapping = source_.renderer().mapping();
  farness_ = mapping.projection == Projection::spc ? 1 : -1;
  nearness_ = farness_ * mapping.window.per_inverse_z;
  offset_ = farness_ * mapping.window.at_infinity;
  blocks_.run(view, result, [&](FaceId face, FaceBlock& block) {
    if (!find_front_face(view, face, block.front)) return FaceClass::hidden;
    if (block.front.spans.empty() && !subpixel_) return FaceClass::unresolved;
    ++block.counts.processed_faces;
    return block.front.spans.empty() ? classify_subpixel(view, block) : classify_face(view, block);
  });
}

FaceClass ShadowMapTester::classify_face(const ClassifyView& view, FaceBlock& block) const {
  const Span& top = block.front.spans.front();
  const InverseDepth depth = inverse_depth_from(block.front.raster, top.x0 + 0.5, top.y + 0.5);
  const auto sees_bare = [&](std::int32_t x, std::int32_t y) { return sees(view, x, y, depth.at(x + 0.5, y + 0.5)); };
  if (view.mask.whole()) return block.sample(view, sees_bare);
  return block.sample(view,
                      [&](std::int32_t x, std::int32_t y) { return view.mask.contains(x, y) && sees_bare(x, y); });
}

FaceClass ShadowMapTester::classify_subpixel(const ClassifyView& view, FaceBlock& block) const {
  std::uint32_t visible = 0;
  const SubpixelPositions at = subpixel_positions(view, block.front.face);
  block.counts.samples += kSubpixelSamples;
  for (std::size_t k = 0; k < kSubpixelSamples; ++k) {
    if (!view.in_image(at.x[k], at.y[k])) continue;
    const int x = std::min(static_cast<int>(at.x[k]), view.camera.width - 1);
    const int y = std::min(static_cast<int>(at.y[k]), view.camera.height - 1);
    visible += sees(view, x, y, 1 / at.depth(k));
  }
  return block.cover_subpixel(view, block.front.face, block.front.inside, visible);
}

}  // namespace

std::unique_ptr<ViewTester> make_shadow_map_tester(const ViewSource& source, double epsilon, bool subpixel) {
  return std::make_unique<ShadowMapTester>(source, epsilon, subpixel);
}

}  // namespace gpvc::visibility
