// What painting keeps for another run of the same input: the corrections of seams, and pages as the photos painted them.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "atlas/atlas.h"
#include "atlas/baking/pages.h"
#include "atlas/baking/partial_filler.h"
#include "atlas/leveling/seam_leveling.h"

namespace gpvc::atlas {

/// All functions do nothing where kept.store is null. What is kept counts as none where its values cannot be of this input.
std::optional<AlignmentFit> take_alignment(const KeptPages& kept, const AtlasInput& input);
void keep_alignment(const KeptPages& kept, const AlignmentFit& fit);

std::optional<LevelingResult> take_leveling(const KeptPages& kept, const AtlasInput& input, const ChartSet& set);
/// Keeps the two parts of what take_leveling() returns.
void keep_leveling(const KeptPages& kept, const ColorCorrection& correction, const LevelingStatistics& statistics);

/// True if the page seems to be kept.
bool has_page(const KeptPages& kept, std::uint32_t number);
/// Opens the page with the texels that it had, and adds its charts with texels that no view shows. False if it is not
/// kept: then the page is empty.
bool take_page(const KeptPages& kept, std::uint32_t number, AtlasBuild& build, std::vector<OpenChart>& charts);
/// \param charts those on the page with texels that no view shows, ascending
void keep_page(const KeptPages& kept, std::uint32_t number, const Page& page,
               const std::vector<const OpenChart*>& charts);

}  // namespace gpvc::atlas
