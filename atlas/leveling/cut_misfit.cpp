#include "atlas/leveling/cut_misfit.h"

#include <algorithm>
#include <vector>

#include "atlas/alignment/alignment.h"

namespace gpvc::atlas {

namespace {

/// The value below which a share of them lies. \pre not empty
double quantile(std::vector<double>& values, double share) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::ranges::nth_element(values, at);
  return *at;
}

}  // namespace

CutMisfit cut_misfit(const AtlasInput& input, const CutPlaces& cuts, const PlacePatches& patches) {
  CutMisfit result;
  std::vector<double> misfits, unaligned;
  for (const PlaceComparison& one : patches.compare()) {
    ++result.places;
    if (!one.shift) continue;
    const ComparedPlace& place = cuts.places[one.place];
    const PatchShift& shift = *one.shift;
    const auto [x, y] = shift_by_fields(input, place.on, place.others[one.other]);
    misfits.push_back(misfit(shift.x, shift.y, shift.information));
    result.where.push_back({FaceId{place.on.face}, static_cast<float>(misfits.back())});
    unaligned.push_back(misfit(shift.x + x, shift.y + y, shift.information));
  }
  result.matched = misfits.size();
  if (misfits.empty()) return result;
  result.median_px = quantile(misfits, 0.5);
  result.px_90 = quantile(misfits, 0.9);
  result.unaligned_median_px = quantile(unaligned, 0.5);
  result.unaligned_px_90 = quantile(unaligned, 0.9);
  return result;
}

}  // namespace gpvc::atlas
