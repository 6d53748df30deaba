#include "app/checks/fit_verdict.h"

#include <algorithm>
#include <cmath>

namespace gpvc::checks {
namespace {

void add(const SurfaceCounts& c, double sign, SurfaceCounts& sum) {
  sum.places += sign * c.places;
  sum.found += sign * c.found;
  sum.on_mesh += sign * c.on_mesh;
  sum.off_mesh += sign * c.off_mesh;
}

double share_on_mesh(const SurfaceCounts& counts) {
  const double on = std::max(0.0, counts.on_mesh), off = std::max(0.0, counts.off_mesh);
  return on + off > 0 ? on / (on + off) : 0;
}

}  // namespace

void add(const FitGroups& groups, FitGroups& sums) {
  for (std::size_t i = 0; i < kFitGroups; ++i) add(groups[i], 1, sums[i]);
}

bool are_counts(const FitGroups& groups) {
  constexpr double kMost = 4294967296;  // 2^32: points have 32-bit numbers
  return std::ranges::all_of(groups, [](const SurfaceCounts& c) {
    return c.on_mesh >= 0 && c.off_mesh >= 0 && c.on_mesh + c.off_mesh == c.found && c.found <= c.places &&
           c.places <= kMost && std::ranges::all_of(std::array{c.on_mesh, c.off_mesh, c.places}, [](double count) {
             return count == std::floor(count);
           });
  });
}

MeshFit judge(const FitGroups& groups) {
  // Photos also agree off a right mesh, on what it lacks: trees, cars, dormers. They also agree on parts of a wrong one: a
  // city that is moved sideways, scaled about the ground or mirrored keeps its level ground. So neither end is sharp: a
  // mesh seems elsewhere where most surfaces lie off it, and is doubtful from a fifth on. Right scenes have 3 % at most
  // (three from photos, three synthetic ones), a city that is moved by 5 m, scaled by 1.05 or turned by 10 degrees 38 % and
  // more. But few views far apart show a right mesh's own errors in pixels: a quarter of the views of a table-top scene have
  // 79 %. So nothing is refused for its share alone.
  constexpr double kLeastShare = 0.5, kGoodShare = 0.8;
  // A share of one half of so many places has a standard error of 0.035.
  constexpr double kLeastPlaces = 200;
  // Of the places with a surface; chance alone finds one in twenty.
  constexpr double kLeastFound = 0.1;
  constexpr double kErrors = 3;
  SurfaceCounts all;
  for (const SurfaceCounts& group : groups) add(group, 1, all);
  MeshFit fit{static_cast<std::size_t>(all.places), static_cast<std::size_t>(all.found), share_on_mesh(all), 0};
  // Jackknife.
  double sum2 = 0;
  for (const SurfaceCounts& group : groups) {
    SurfaceCounts rest = all;
    add(group, -1, rest);
    sum2 += std::pow(share_on_mesh(rest) - fit.share, 2);
  }
  fit.error = std::sqrt(sum2 * (kFitGroups - 1) / kFitGroups);
  const double at_most = fit.share + kErrors * fit.error;
  using enum MeshFit::Verdict;
  if (all.places < kLeastPlaces || all.on_mesh + all.off_mesh < kLeastFound * all.places)
    fit.verdict = unknown;  // too little texture, or photos too different: leaves in the wind, few and far apart
  else if (at_most < kLeastShare)
    fit.verdict = elsewhere;
  else
    fit.verdict = at_most < kGoodShare ? doubtful : fits;
  return fit;
}

}  // namespace gpvc::checks
