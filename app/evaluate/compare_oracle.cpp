#include "app/evaluate/compare_oracle.h"

#include <algorithm>
#include <random>
#include <utility>

namespace gpvc::evaluate {
namespace {

double ratio(std::size_t part, std::size_t whole, double otherwise) {
  return whole == 0 ? otherwise : static_cast<double>(part) / static_cast<double>(whole);
}

// "Unresolved" is no class of the oracle's; like hidden it offers no texture.
std::size_t class_index(visibility::FaceClass c) {
  return c == visibility::FaceClass::unresolved ? 0 : static_cast<std::size_t>(c);
}

// The first `count` of the used views in a fixed shuffle, ascending.
std::vector<ViewId> drawn(std::span<const ViewId> used, std::size_t count) {
  std::vector<ViewId> views(used.begin(), used.end());
  std::mt19937 chance(1);  // the standard fixes its numbers
  for (std::size_t n = 0; n < std::min(count, views.size()); ++n)
    std::swap(views[n], views[n + chance() % (views.size() - n)]);
  views.resize(std::min(count, views.size()));
  std::sort(views.begin(), views.end());
  return views;
}

}  // namespace

double Agreement::share(visibility::FaceClass of) const {
  const auto& row = pairs[class_index(of)];
  return ratio(row[class_index(of)], row[0] + row[1] + row[2], 1.0);
}

double Agreement::accuracy() const {
  std::size_t all = 0;
  for (const auto& row : pairs) all += row[0] + row[1] + row[2];
  return ratio(pairs[0][0] + pairs[1][1] + pairs[2][2], all, 1.0);
}

double Agreement::false_full() const {
  const std::size_t wrong = pairs[0][2] + pairs[1][2];
  return ratio(wrong, wrong + pairs[2][2], 0.0);
}

double Agreement::missed_full() const { return 1.0 - share(visibility::FaceClass::full); }

Json Agreement::json() const {
  return {{"agreement", accuracy()},
          {"hidden_agreement", share(visibility::FaceClass::hidden)},
          {"partial_agreement", share(visibility::FaceClass::partial)},
          {"full_agreement", share(visibility::FaceClass::full)},
          {"false_full", false_full()},
          {"missed_full", missed_full()},
          {"tied_pairs", tied},
          {"pairs_by_oracle_then_mode", pairs}};
}

OracleViews::OracleViews(const Mesh& mesh, const Scene& scene, std::span<const ViewId> used, std::size_t count,
                         const Progress& progress) {
  const std::vector<ViewId> ids = drawn(used, count);
  for (const ViewId id : ids) {
    progress(views_.size(), ids.size());
    views_.push_back({id, visibility::oracle_visibility(mesh, scene.views[index(id)])});
  }
}

std::size_t OracleViews::tied() const {
  std::size_t sum = 0;
  for (const View& view : views_)
    sum += static_cast<std::size_t>(std::count(view.truth.tied.begin(), view.truth.tied.end(), 1));
  return sum;
}

Json OracleViews::json(const Scene& scene) const {
  Json names = Json::array();
  for (const View& view : views_) names.push_back(scene.views[index(view.id)].name);
  return {{"views", names}, {"tied_pairs", tied()}};
}

void OracleViews::compare(ViewId id, const visibility::ViewVisibility& visible, Agreement& agreement) const {
  const auto same = [id](const View& view) { return view.id == id; };
  const auto found = std::find_if(views_.begin(), views_.end(), same);
  if (found == views_.end()) return;
  const visibility::OracleView& truth = found->truth;
  for (std::size_t face = 0; face < truth.classes.size(); ++face) {
    if (truth.tied[face] != 0)
      ++agreement.tied;
    else
      ++agreement.pairs[class_index(truth.classes[face])][class_index(visible.classes[face])];
  }
}

}  // namespace gpvc::evaluate
