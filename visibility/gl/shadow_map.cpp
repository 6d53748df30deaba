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
  void classify(const PreparedView& view, const View& of, ViewVisibility& result) override;
  std::string note() const override { return "cpu: shadow maps are compared there"; }

 private:
  const ViewSource& source_;
  double epsilon_;
  bool subpixel_;
  FaceBlocks blocks_;
};

void ShadowMapTester::classify(const PreparedView& view, const View&, ViewVisibility& result) {
  // Window depth grows with distance under SPC and shrinks under APC: farness times the depth of a point is nearness / z
  // + offset.
  const DepthMapping& mapping = source_.renderer()->mapping();
  const double farness = mapping.projection == Projection::spc ? 1 : -1;
  const double nearness = farness * mapping.window.per_inverse_z, offset = farness * mapping.window.at_infinity;
  const std::span<const float> depths = source_.depths();
  const auto sees = [&](std::int32_t x, std::int32_t y, double inverse_depth) {
    const double stored = depths[view.pixel_index(x, y)];
    return nearness * inverse_depth + offset <= farness * stored + epsilon_;
  };
  blocks_.run_samples(view, subpixel_, result, sees, [&](FaceId face) {
    std::uint32_t visible = 0;
    const SubpixelPositions at = subpixel_positions(view, face);
    for (std::size_t k = 0; k < kSubpixelSamples; ++k) {
      if (!view.in_image(at.x[k], at.y[k])) continue;
      visible += sees(std::min(static_cast<int>(at.x[k]), view.camera.width - 1),
                      std::min(static_cast<int>(at.y[k]), view.camera.height - 1), 1 / at.depth(k));
    }
    return visible;
  });
}

}  // namespace

std::unique_ptr<ViewTester> make_tester(const ShadowMap& method, const TesterInput& input) {
  return std::make_unique<ShadowMapTester>(input.source, method.epsilon, input.subpixel);
}

}  // namespace gpvc::visibility
