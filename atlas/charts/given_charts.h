// Charts where the input says where its faces lie on pages.
//
// A layout that another program has made knows nothing of photos: an island of it shows several of them. A chart is what one
// photo shows of an island, so a page holds charts side by side whose borders are those of labels, and texels belong to the
// nearest chart (texel_owners()).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "atlas/charts/charts.h"

namespace gpvc::atlas {

/// Where a face's corners lie on its page, in texels; all in one point without a page.
TexelTriangle page_corners(const io::UvLayout& layout, std::size_t face);

/// True for faces that get texels: they have texture coordinates, between which there is an area.
bool takes_texels(const io::UvLayout& layout, std::size_t face);

/// True if two faces that share an edge lie beside each other there, on the same page.
bool continues(const Mesh& mesh, const io::UvLayout& layout, std::uint32_t face, std::uint32_t other);

/// Plain, partial and unseen charts of faces that continue each other and have one label, cut as by cut_ragged(); then, as
/// border, the faces that take no texels. Charts are ordered by kind and then by the first face of their piece.
/// \pre the input has a layout. O(faces log faces)
ChartSet make_given_charts(const AtlasInput& input, const FaceNeighbours& neighbours);

}  // namespace gpvc::atlas
