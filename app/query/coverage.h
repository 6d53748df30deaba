// How well photos cover a mesh, and where they do not: what to fly again.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "app/pipeline/judgement.h"
#include "app/pipeline/run.h"
#include "io/names.h"
#include "visibility/device.h"

namespace gpvc::query {

/// Per face, of the photos that see at least half of it: their number, and the best of what they offer at its centroid, of
/// different photos perhaps. Infinite where there is none.
struct FaceCoverage {
  std::vector<std::uint32_t> photos;
  std::vector<float> gsd;    ///< least ground sampling distance, as in Sharpness
  std::vector<float> angle;  ///< least angle between line of sight and normal, degrees
};

/// Counts what photos see of each face. With a judgement nothing is drawn, and views whose photo shows background there, or
/// something else than the others, do not count, nor those that were left out. The views of a panorama are one photo. Draws a view
/// after the other, as `gpvc visibility` does. \param device that drew the views, where one did. Throws GpuError, and what
/// photos and observer throw. O(views x (faces + pixels)).
FaceCoverage cover_faces(const pipeline::Run& run, const pipeline::Judgement* judgement = nullptr,
                         std::optional<visibility::DeviceInfo>* device = nullptr);

/// What a face lacks: the first that holds, from top to bottom.
enum class Lack : std::uint8_t {
  nothing,
  unseen,   ///< no photo sees it
  few,      ///< fewer photos than wanted
  coarse,   ///< all photos are coarser than wanted
  grazing,  ///< all photos look at it more steeply than wanted
};
inline constexpr Named<Lack> kLackNames[] = {{"nothing", Lack::nothing},
                                             {"unseen", Lack::unseen},
                                             {"few", Lack::few},
                                             {"coarse", Lack::coarse},
                                             {"grazing", Lack::grazing}};

struct Wanted {
  std::uint32_t photos = 2;  ///< at least
  double gsd = 0;            ///< at most; 0: twice the median over the surface that photos see
  double angle = 70;         ///< at most, degrees
};

/// What is wanted with numbers in the place of those that are to be found.
Wanted resolved(const Wanted& wanted, const Mesh& mesh, const FaceCoverage& coverage);

/// \pre resolved(wanted)
std::vector<Lack> lacks_of(const FaceCoverage& coverage, const Wanted& wanted);

/// Neighbouring faces that lack the same.
struct Area {
  Lack lack{};
  std::vector<FaceId> faces;  ///< ascending
  double surface = 0;         ///< area, in squared units of the scene
  WorldPoint middle;          ///< mean over the surface
  WorldPoint normal;          ///< mean over the surface, of length 1; 0 where faces look everywhere
  std::uint32_t least_photos = 0, most_photos = 0;
  double gsd = 0, angle = 0;  ///< the best of any face; infinite: no photo
};

/// All of them, the largest first. Faces are neighbours if they share an edge. O(faces log faces).
std::vector<Area> areas_of(const Mesh& mesh, const FaceCoverage& coverage, const std::vector<Lack>& lacks);

}  // namespace gpvc::query
