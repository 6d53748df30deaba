#include "app/compare_truth.h"

#include <cmath>

#include "app/truth.h"

namespace gpvc {
namespace {

Json shares_json(const TruthShares& s) {
  return {{"seen_area", s.seen_area}, {"textured", s.textured}, {"wrong", s.wrong},
          {"strange", s.strange},     {"untold", s.untold},     {"right", s.textured * (1 - s.wrong)}};
}

Json origin_json(const OriginShares& s) {
  return {{"seen_area", s.seen_area}, {"photo", s.photo}, {"right", s.right},
          {"wrong", s.wrong},         {"edge", s.edge},   {"filled", 1 - s.photo}};
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
  std::vector<std::vector<float>> right_areas;  // per model scored; empty where origins are not known
  double seen_area = 0;
  std::vector<WrongPoint> wrong;
};

TruthComparison::TruthComparison(const std::filesystem::path& dir, const SceneInputData& input,
                                 PhotoCache& photos)
    : state_(std::make_unique<State>(dir, input, photos)) {}
TruthComparison::~TruthComparison() = default;

Json TruthComparison::score(const TexturedModel& model, std::span<const Image> pages,
                            const WorldPoint& offset, const TextureOrigins* origins,
                            const Progress& progress) {
  state_->right_areas.emplace_back();  // models count from the first, scored or failed
  const MatchedModel matched = match_model(state_->input.mesh, model, pages, offset);
  const TruthScore score = state_->scorer.score(matched, progress);
  Json json = {{"all", shares_json(score.all)},
               {"full", shares_json(score.full)},
               {"partial", shares_json(score.partial)},
               {"samples", score.samples},
               {"strangers", matched.strangers}};
  state_->wrong.clear();
  if (origins == nullptr) return json;
  OriginScore by_pixel = state_->scorer.score(
      [&](std::uint32_t face, double b, double c) { return std::optional(origins->at(FaceId{face}, b, c)); });
  json["origin"] = {{"all", origin_json(by_pixel.all)},
                    {"full", origin_json(by_pixel.full)},
                    {"partial", origin_json(by_pixel.partial)},
                    {"wrong_points", by_pixel.wrong.size()}};
  state_->right_areas.back() = std::move(by_pixel.right_area);
  state_->seen_area = by_pixel.all.seen_area;
  state_->wrong = std::move(by_pixel.wrong);
  return json;
}

Json TruthComparison::ahead(std::size_t model, std::size_t of) const {
  const std::vector<float>&a = state_->right_areas[model], &b = state_->right_areas[of];
  if (a.empty() || b.empty() || state_->seen_area <= 0) return nullptr;
  double sum = 0, squares = 0;
  for (std::size_t f = 0; f < a.size(); ++f) {
    const double d = static_cast<double>(a[f]) - static_cast<double>(b[f]);
    sum += d;
    squares += d * d;
  }
  return {{"ahead", sum / state_->seen_area}, {"noise", std::sqrt(squares) / state_->seen_area}};
}

Json TruthComparison::wrong_points() const {
  Json points = Json::array();
  for (const WrongPoint& p : state_->wrong)
    points.push_back({{"face", p.face},
                      {"photo", state_->input.scene.views[index(p.view)].name},
                      {"x", p.at.x},
                      {"y", p.at.y},
                      {"shows", p.surface}});
  return points;
}

}  // namespace gpvc
