#include "app/compare_truth.h"

#include "app/truth.h"

namespace gpvc {
namespace {

Json shares_json(const TruthShares& s) {
  return {{"seen_area", s.seen_area}, {"textured", s.textured}, {"wrong", s.wrong},
          {"strange", s.strange},     {"untold", s.untold},     {"right", s.textured * (1 - s.wrong)}};
}

}  // namespace

struct TruthComparison::State {
  State(const std::filesystem::path& dir, const SceneInputData& in, PhotoCache& photos)
      : input(in),
        truth(read_truth(dir)),
        best(best_classes(in.mesh, in.scene, in.used)),
        scorer(truth, in.mesh, best, in.scene, in.used, photos) {}
  const SceneInputData& input;
  Truth truth;
  std::vector<FaceClass> best;
  TruthScorer scorer;
};

TruthComparison::TruthComparison(const std::filesystem::path& dir, const SceneInputData& input,
                                 PhotoCache& photos)
    : state_(std::make_unique<State>(dir, input, photos)) {}
TruthComparison::~TruthComparison() = default;

Json TruthComparison::score(const TexturedModel& model, std::span<const Image> pages,
                            const WorldPoint& offset, const Progress& progress) const {
  const MatchedModel matched = match_model(state_->input.mesh, model, pages, offset);
  const TruthScore score = state_->scorer.score(matched, progress);
  return {{"all", shares_json(score.all)},
          {"full", shares_json(score.full)},
          {"partial", shares_json(score.partial)},
          {"samples", score.samples},
          {"strangers", matched.strangers}};
}

}  // namespace gpvc
