#include "app/evaluate/oracle_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "app/results/observer.h"
#include "io/clock.h"

namespace gpvc::evaluate {
namespace {

using visibility::FaceClass;

// Each of both commands has always drawn the views that its own seed gives.
constexpr std::uint32_t kCheckSeed = 2018, kCompareSeed = 1;
constexpr std::size_t kListed = 10;
constexpr const char* kClassNames[] = {"hidden", "partial", "full", "unresolved"};

std::size_t number(FaceClass c) { return static_cast<std::size_t>(c); }
const char* name_of(FaceClass c) { return kClassNames[number(c)]; }

double ratio(std::size_t part, std::size_t whole, double otherwise) {
  return whole == 0 ? otherwise : static_cast<double>(part) / static_cast<double>(whole);
}

/// With unresolved counted as hidden.
std::array<std::array<std::size_t, 3>, 3> without_unresolved(const Confusion& confusion) {
  std::array<std::array<std::size_t, 3>, 3> pairs{};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& row = confusion.pairs[i];
    pairs[i] = {row[0] + row[number(FaceClass::unresolved)], row[1], row[2]};
  }
  return pairs;
}

/// Rows found, columns the oracle's, as oracle.json has it.
std::array<std::array<std::size_t, 3>, 4> found_by_oracle(const Confusion& confusion) {
  std::array<std::array<std::size_t, 3>, 4> pairs{};
  for (std::size_t found = 0; found < 4; ++found)
    for (std::size_t truth = 0; truth < 3; ++truth) pairs[found][truth] = confusion.pairs[truth][found];
  return pairs;
}

bool differs(FaceClass found, FaceClass truth) { return found != truth && found != FaceClass::unresolved; }

PixelPoint centroid_px(const Mesh& mesh, const View& view, std::size_t face) {
  CameraPoint sum;
  for (const std::uint32_t v : mesh.faces[face]) {
    const CameraPoint p = camera_from_world(view.pose, mesh.positions[v]);
    sum = {sum.x + p.x, sum.y + p.y, sum.z + p.z};
  }
  constexpr double kNowhere = std::numeric_limits<double>::quiet_NaN();
  return sum.z > 0 ? pixel_from_camera(view.camera, sum) : PixelPoint{kNowhere, kNowhere};
}

/// The first `count` of the used views in a shuffle that depends on the seed alone, ascending; all if there are fewer.
std::vector<ViewId> draw_views(std::span<const ViewId> used, std::size_t count, std::uint32_t seed) {
  std::vector<ViewId> views(used.begin(), used.end());
  count = std::min(count, views.size());
  // Not std::shuffle, whose result depends on the library; the standard fixes the numbers of mt19937.
  std::mt19937 random(seed);
  for (std::size_t n = 0; n < count; ++n) std::swap(views[n], views[n + random() % (views.size() - n)]);
  views.resize(count);
  std::sort(views.begin(), views.end());
  return views;
}

}  // namespace

void Confusion::add(std::span<const FaceClass> found, const visibility::OracleView& truth) {
  for (std::size_t f = 0; f < found.size(); ++f) {
    if (truth.tied[f] != 0) {
      ++tied;
      tied_differing += differs(found[f], truth.classes[f]) ? 1 : 0;
    } else {
      ++pairs[number(truth.classes[f])][number(found[f])];
    }
  }
}

std::size_t Confusion::disagreements() const {
  std::size_t count = 0;
  for (std::size_t truth = 0; truth < 3; ++truth)
    for (std::size_t found = 0; found < 3; ++found) count += truth == found ? 0 : pairs[truth][found];
  return count;
}

double Confusion::share(FaceClass of) const {
  const auto row = without_unresolved(*this)[number(of)];
  return ratio(row[number(of)], row[0] + row[1] + row[2], 1.0);
}

double Confusion::accuracy() const {
  const auto rows = without_unresolved(*this);
  std::size_t all = 0;
  for (const auto& row : rows) all += row[0] + row[1] + row[2];
  return ratio(rows[0][0] + rows[1][1] + rows[2][2], all, 1.0);
}

double Confusion::false_full() const {
  const std::size_t wrong = pairs[0][2] + pairs[1][2];
  return ratio(wrong, wrong + pairs[2][2], 0.0);
}

double Confusion::missed_full() const { return 1.0 - share(FaceClass::full); }

Json Confusion::agreement_json() const {
  return {{"agreement", accuracy()},
          {"hidden_agreement", share(FaceClass::hidden)},
          {"partial_agreement", share(FaceClass::partial)},
          {"full_agreement", share(FaceClass::full)},
          {"false_full", false_full()},
          {"missed_full", missed_full()},
          {"tied_pairs", tied},
          {"pairs_by_oracle_then_mode", without_unresolved(*this)}};
}

std::map<ViewId, visibility::OracleView> oracle_views(const Mesh& mesh, const Scene& scene,
                                                      std::span<const ViewId> used, std::size_t count,
                                                      const Progress& progress) {
  const std::vector<ViewId> drawn = draw_views(used, count, kCompareSeed);
  std::map<ViewId, visibility::OracleView> views;
  for (const ViewId id : drawn) {
    progress(views.size(), drawn.size());
    views.emplace(id, visibility::oracle_visibility(mesh, scene.views[index(id)]));
  }
  return views;
}

OracleCheck::OracleCheck(std::span<const ViewId> used, std::size_t count)
    : drawn_(draw_views(used, count, kCheckSeed)) {}

void OracleCheck::compare(const Mesh& mesh, const Scene& scene, ViewId id, std::span<const FaceClass> classes) {
  if (!std::binary_search(drawn_.begin(), drawn_.end(), id)) return;
  const View& view = scene.views[index(id)];
  const auto start = Clock::now();
  const visibility::OracleView truth = visibility::oracle_visibility(mesh, view);
  const double seconds = seconds_since(start);
  Confusion confusion;
  confusion.add(classes, truth);
  for (std::size_t f = 0; f < classes.size() && first_.size() < kListed; ++f) {
    if (truth.tied[f] != 0 || !differs(classes[f], truth.classes[f])) continue;
    const PixelPoint at = centroid_px(mesh, view, f);
    first_.push_back({view.name, f, classes[f], truth.classes[f], at.x, at.y});
  }
  views_.push_back({{"name", view.name},
                    {"tied", confusion.tied},
                    {"disagreements", confusion.disagreements()},
                    {"confusion", found_by_oracle(confusion)},
                    {"samples", truth.samples},
                    {"oracle_s", seconds}});
  confusion_.add(classes, truth);
  faces_ += classes.size();
  samples_ += truth.samples;
  seconds_ += seconds;
}

std::string OracleCheck::report() const {
  std::string text = fmt::format(
      "oracle: {} views (seed {}), {} faces and views, {} samples, {:.2f} s\n"
      "{:22} {:>12} {:>12} {:>12}\n",
      views_.size(), kCheckSeed, results::readable_count(faces_), results::readable_count(samples_), seconds_,
      "found \\ oracle", kClassNames[0], kClassNames[1], kClassNames[2]);
  const auto rows = found_by_oracle(confusion_);
  const auto& unresolved = rows[number(FaceClass::unresolved)];
  const bool any_unresolved = unresolved[0] + unresolved[1] + unresolved[2] > 0;
  for (std::size_t i = 0; i < (any_unresolved ? 4U : 3U); ++i)
    text += fmt::format("{:22} {:>12} {:>12} {:>12}\n", kClassNames[i], rows[i][0], rows[i][1], rows[i][2]);
  text += fmt::format("{} disagreements; {} tied apart, {} of them classed otherwise", disagreements(), confusion_.tied,
                      confusion_.tied_differing);
  for (const Disagreement& d : first_)
    text += fmt::format("\n  {} face {}: {} for {}, centroid at ({:.2f}, {:.2f}) px", d.view, d.face, name_of(d.found),
                        name_of(d.truth), d.x, d.y);
  if (disagreements() > first_.size()) text += fmt::format("\n  and {} more", disagreements() - first_.size());
  return text;
}

Json OracleCheck::json() const {
  Json first = Json::array();
  for (const Disagreement& d : first_)
    first.push_back({{"view", d.view},
                     {"face", d.face},
                     {"found", name_of(d.found)},
                     {"oracle", name_of(d.truth)},
                     {"centroid_px", std::isfinite(d.x) ? Json::array({d.x, d.y}) : Json(nullptr)}});
  return {{"seed", kCheckSeed},
          {"classes", {kClassNames[0], kClassNames[1], kClassNames[2], kClassNames[3]}},
          {"confusion", found_by_oracle(confusion_)},
          {"rows", "found"},
          {"columns", "oracle"},
          {"faces", faces_},
          {"tied", confusion_.tied},
          {"tied_differing", confusion_.tied_differing},
          {"disagreements", disagreements()},
          {"first_disagreements", first},
          {"samples", samples_},
          {"oracle_s", seconds_},
          {"views", views_}};
}

}  // namespace gpvc::evaluate
