// A picture of the photos that agree least with the others about the mesh.
#pragma once

#include <vector>

#include "app/pipeline/pipeline.h"
#include "io/image.h"

namespace gpvc::evaluate {

/// A view, and the other one that sees most of the faces that it sees.
struct PairOfViews {
  ViewId view{}, other{};
};

/// At most `most` of the views that have been judged, those that agree least first, each with another one.
std::vector<PairOfViews> least_agreeing(const labeling::Candidates& candidates, std::size_t most);

/// A row a pair: what the view's photo shows, and what the other one shows of the mesh from the view's place; grey where
/// it sees no mesh. Where poses, photos and mesh fit, both halves of a row are the same picture. Lens distortion is taken
/// away. Fetches each photo of the pairs twice at most. O(pairs x (faces + pixels)).
Image agreement_picture(const checks::Input& input, const labeling::CostTable& candidates,
                        std::span<const PairOfViews> pairs, io::PhotoSource& photos);

}  // namespace gpvc::evaluate
