// NoTest: every front face in the image counts as visible.
#include "visibility/classify/front_faces.h"
#include "visibility/classify/view_tester.h"

namespace gpvc::visibility {
namespace {

class NoTestTester : public ViewTester {
 public:
  explicit NoTestTester(bool subpixel) : subpixel_(subpixel) {}
  void classify(const PreparedView& view, const View& of, ViewVisibility& result) override;
  std::string note() const override { return "cpu: there is nothing to test"; }

 private:
  bool subpixel_;
  FaceBlocks blocks_;
};

void NoTestTester::classify(const PreparedView& view, const View&, ViewVisibility& result) {
  blocks_.run(view, result, [&](FaceId face, FaceBlock& block) {
    if (!find_samples(view, face, SpanSearch::exact, block.front)) return FaceClass::hidden;
    if (block.front.spans.empty()) {
      if (!subpixel_) return FaceClass::unresolved;
      const SubpixelPositions at = subpixel_positions(view, face);
      std::uint32_t in_image = 0;
      for (std::size_t k = 0; k < kSubpixelSamples; ++k) in_image += view.in_image(at.x[k], at.y[k]);
      return block.cover_subpixel(view, face, block.front.inside, in_image);
    }
    if (block.front.inside && view.mask.whole()) return FaceClass::full;
    return block.cover(view, [&](std::int32_t x, std::int32_t y) { return view.mask.contains(x, y); });
  });
}

}  // namespace

std::unique_ptr<ViewTester> make_tester(const NoTest&, const TesterInput& input) {
  return std::make_unique<NoTestTester>(input.subpixel);
}

}  // namespace gpvc::visibility
