#include "atlas/leveling/overlap_ratios.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "atlas/charts/charts.h"
#include "atlas/leveling/finished_texture.h"
#include "atlas/leveling/seam_leveling.h"
#include "io/vector.h"

namespace gpvc::atlas {

namespace {

/// A few hundred ratios tell a photo's gain to a few thousandths, as photos differ by a tenth at single places.
std::size_t most_sights(std::size_t views) { return std::max<std::size_t>(8000, 200 * views); }

}  // namespace

OverlapRatios::OverlapRatios(const AtlasInput& input) : input_(&input) {
  const auto is_taken = [&](std::uint32_t face) {
    return has_view(input, face) && input.tags[face] == labeling::FaceTag::seen && !is_finished(input, face) &&
           (input.border.empty() || input.border[face] == 0) && input.candidates.views_of(face).size() > 1;
  };
  std::size_t all = 0;
  for (std::uint32_t face = 0; face < input.candidates.faces(); ++face)
    if (is_taken(face)) all += input.candidates.views_of(face).size();
  // The list of all faces' candidates is cut into parts, and a face at each cut is taken.
  constexpr std::size_t kOfAFace = 8;  // candidates, about
  const std::size_t most = most_sights(input.scene.views.size());
  const auto part_of = [&](std::size_t candidate) { return candidate * most / all / kOfAFace; };
  std::size_t before = 0;
  for (std::uint32_t face = 0; face < input.candidates.faces(); ++face) {
    if (!is_taken(face)) continue;
    const auto views = input.candidates.views_of(face);
    const std::size_t after = before + views.size();
    if (all <= most || part_of(before) != part_of(after))
      for (const std::uint32_t view : views) sights_.push_back({face, view, false, {}, {}});
    before = after;
  }
  of_view_ = group_items<std::uint32_t>(input.scene.views.size(), [&](const auto& add) {
    for (std::uint32_t i = 0; i < sights_.size(); ++i) add(sights_[i].view, i);
  });
}

void OverlapRatios::take(ViewId id, const CoarsePhoto& photo) {
  const View& view = input_->scene.views[index(id)];
  const auto mine = std::as_const(of_view_)[index(id)];
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, mine.size(), 256), [&](const auto& some) {
    for (std::size_t i = some.begin(); i < some.end(); ++i) {
      Sight& sight = sights_[mine[i]];
      const auto p = pixel_from_world(view, middle_of(input_->mesh, sight.face));
      const auto q = p ? photo_from_pixel(view.camera, *p) : std::nullopt;
      if (!q || q->x < 0 || q->y < 0 || q->x > view.camera.width || q->y > view.camera.height) continue;
      sight.is_shown = true;
      sight.color = photo.at(*q);
      sight.frame = *p;
    }
  });
}

std::vector<ColorRatio> OverlapRatios::ratios(double weight) const {
  std::vector<ColorRatio> ratios;
  const auto add = [&](const Sight& a, const Sight& b) {
    ColorRatio ratio;
    const std::array sights{&a, &b};
    for (std::size_t s = 0; s < 2; ++s) {
      ratio.views[s] = sights[s]->view;
      ratio.at[s] = {sights[s]->frame.x, sights[s]->frame.y};
      ratio.logs[s] = logs_of(sights[s]->color);
    }
    ratio.weight = 1;
    ratios.push_back(ratio);
  };
  std::vector<const Sight*> of_face;
  for (auto begin = sights_.begin(); begin != sights_.end();) {
    const auto end = std::find_if(begin, sights_.end(), [&](const Sight& each) { return each.face != begin->face; });
    of_face.clear();
    for (; begin != end; ++begin)
      if (begin->is_shown && has_logs(begin->color)) of_face.push_back(&*begin);
    const std::size_t count = of_face.size();
    if (count < 2) continue;
    for (std::size_t i = 0; i < count; ++i) {
      if (i + 1 < count || count > 2) add(*of_face[i], *of_face[(i + 1) % count]);
      if (count > 3 && (count % 2 == 1 || i < count / 2)) add(*of_face[i], *of_face[(i + count / 2) % count]);
    }
  }
  for (ColorRatio& ratio : ratios) ratio.weight = weight / static_cast<double>(ratios.size());
  return ratios;
}

}  // namespace gpvc::atlas
