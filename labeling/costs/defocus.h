// Finds where photos are out of focus, or were moved, and counts their pixels there as what they show.
#pragma once

#include "labeling/costs/cells.h"
#include "labeling/costs/face_records.h"

namespace gpvc::labeling {

/// Lowers the quality of records where other photos show the same surface with finer detail.
///
/// In regions of kDefocusRegionCells cells, views are compared in pairs of those whose brightness correlates from cell to cell: both
/// show the same things, however sharply. Each is measured by its brightness steps from pixel to pixel, and of these
/// two may be smaller for another reason than blur: haze and glare lower coarse contrast as well, and of a smooth surface a photo
/// from nearby shows more pixels with smaller steps. A view counts as less sharp only by what neither explains. What it
/// lacks against the sharpest such view is averaged over the regions around, as focus changes little from one to the next.
///
/// Sharp photos differ as well, by angle, light and noise. So a factor of e in the steps' squares, or six standard deviations of what
/// regions side by side differ by where that is more, counts as nothing, twice as much (in logarithms) in full.
///
/// The rest lowers the quality, an area in pixels, to that of a sharp photo with as small steps: in pictures whose power falls with
/// the square of the frequency, as photos' does, the squared steps of pixels with a point spread of variance s^2 grow with
/// log(1 + 1 / (4 s^2)). A sharp photo has s = 1/2 pixel, and pixels 2 s wide hold as much as one whose steps' squares are a
/// share r of the sharp one's if 1 / (4 s^2) = 2^r - 1.
///
/// `cells`: made of the records before find_outliers(). O(records + cells * views of a cell^2), TBB; the result does not depend on
/// the number of threads.
void discount_blurred(RecordsByView& by_view, const Cells& cells);

inline constexpr float kDefocusRegionCells = 64;

}  // namespace gpvc::labeling
