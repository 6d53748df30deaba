// Lazy-projection coverage correction (algorithm 1), one sample at a time: the IVM is never written.
#pragma once

#include "visibility/raster/prepared_view.h"

namespace gpvc::visibility {

/// True when pixel (x, y), which `face` covers and whose stored owner is another face, belongs to `face` after all.
/// Only pixels crossed by one of its edges are corrected:
///   figure 11a: the stored owner does not cover the centre (or nothing is stored);
///   figure 11b: it does, but the face is nearer there, by their planes at the centre; the lower index on a tie.
/// \pre (x, y) is in the image.
inline bool lpcc_restores(const PreparedView& view, FaceId face, const RasterFace& raster, std::int32_t x,
                          std::int32_t y) {
  const double px = x + 0.5, py = y + 0.5;
  const EdgeValues values = edge_values(raster, px, py);
  if (!crossed_by_edge(raster, values)) return false;
  const FaceId stored = view.owner(x, y);
  if (stored == kNoFace) return true;
  const RasterFace other = view.raster(stored);
  if (other.facing == Facing::edge_on) return true;
  const EdgeValues other_values = edge_values(other, px, py);
  if (!covers(other, other_values)) return true;
  const double order = compare_depth(plane_depth(raster, values), plane_depth(other, other_values));
  return order < 0 || (order == 0 && face < stored);
}

}  // namespace gpvc::visibility
