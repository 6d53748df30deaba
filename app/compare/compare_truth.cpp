#include "app/compare/compare_truth.h"

#include <cmath>

#include "app/evaluate/truth.h"
#include "app/evaluate/truth_origin.h"

namespace gpvc::compare {
namespace {

// The paired difference of two models' areas, in shares of `whole`, with its standard error.
cli::Json difference(const std::vector<float>& a, const std::vector<float>& b, double whole) {
  if (a.empty() || b.empty() || whole <= 0) return nullptr;
  double sum = 0, squares = 0;
  for (std::size_t f = 0; f < a.size(); ++f) {
    const double d = static_cast<double>(a[f]) - static_cast<double>(b[f]);
    sum += d;
    squares += d * d;
  }
  return {{"ahead", sum / whole}, {"noise", std::sqrt(squares) / whole}};
}

}  // namespace

struct TruthComparison::State {
  State(const std::filesystem::path& dir, const pipeline::Input& in, io::PhotoSource& photos, const Progress& progress)
      : input(in), truth(evaluate::read_truth(dir)), scorer({truth, in.mesh, in.scene, in.views, photos}, progress) {}
  const pipeline::Input input;
  evaluate::Truth truth;
  evaluate::TruthScorer scorer;
  struct Areas {  // per face; empty where origins are not known
    std::vector<float> right, faithful;
  };
  std::vector<Areas> areas;  // per model scored
  double seen_area = 0, hidden_area = 0;
  std::vector<evaluate::WrongPoint> wrong;
};

TruthComparison::TruthComparison(const std::filesystem::path& dir, const pipeline::Input& input,
                                 io::PhotoSource& photos, const Progress& progress)
    : state_(std::make_unique<State>(dir, input, photos, progress)) {}
TruthComparison::~TruthComparison() = default;

cli::Json TruthComparison::score(const io::TexturedModel& model, std::span<const Image> pages, const WorldPoint& offset,
                                 const atlas::TextureOrigins* origins, const Progress& progress) {
  state_->areas.emplace_back();  // also for a model whose scoring fails
  const evaluate::MatchedModel matched = evaluate::match_model(state_->input.mesh, model, pages, offset);
  const evaluate::TruthScore score = state_->scorer.score(matched, progress);
  cli::Json json = {{"all", evaluate::shares_json(score.all)},
                    {"full", evaluate::shares_json(score.full)},
                    {"partial", evaluate::shares_json(score.partial)},
                    {"samples", score.samples},
                    {"unmatched_faces", matched.unmatched_faces}};
  state_->wrong.clear();
  if (origins == nullptr) return json;
  evaluate::OriginScore by_pixel = state_->scorer.score(
      [&](std::uint32_t face, double b, double c) { return std::optional(origins->at(FaceId{face}, b, c)); });
  json["origin"] = {{"all", evaluate::shares_json(by_pixel.all)},
                    {"full", evaluate::shares_json(by_pixel.full)},
                    {"partial", evaluate::shares_json(by_pixel.partial)},
                    {"none", evaluate::shares_json(by_pixel.none)},
                    {"wrong_points", by_pixel.wrong.size()}};
  state_->areas.back() = {std::move(by_pixel.right_area), std::move(by_pixel.faithful_area)};
  state_->seen_area = by_pixel.all.seen_area;
  state_->hidden_area = by_pixel.all.hidden_area;
  state_->wrong = std::move(by_pixel.wrong);
  return json;
}

cli::Json TruthComparison::ahead(std::size_t model, std::size_t of) const {
  const State::Areas &a = state_->areas[model], &b = state_->areas[of];
  const cli::Json right = difference(a.right, b.right, state_->seen_area);
  if (right.is_null()) return nullptr;
  return {{"right", right}, {"faithful", difference(a.faithful, b.faithful, state_->seen_area + state_->hidden_area)}};
}

cli::Json TruthComparison::wrong_points() const {
  cli::Json points = cli::Json::array();
  for (const evaluate::WrongPoint& p : state_->wrong)
    points.push_back({{"face", p.face},
                      {"photo", state_->input.scene.views[index(p.view)].name},
                      {"x", p.at.x},
                      {"y", p.at.y},
                      {"shows", p.surface}});
  return points;
}

}  // namespace gpvc::compare
