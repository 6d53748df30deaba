// Checks that mesh and cameras share a coordinate system and that the mesh is not inside out.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "../../io/scene.h"
#include "framing.h"

namespace gpvc::checks {

using gpvc::box_of;
/// The bounding box of the camera centres.
Box box_of(const Scene& scene);
/// "x LOW .. HIGH, y LOW .. HIGH, z LOW .. HIGH".
std::string box_text(const Box& box);

/// Throws InputError, with both bounding boxes, when no face of the mesh may be framed by any of the views. Tests single
/// faces only where the bounding box of 1024 neighbouring ones reaches into a frame, and stops at the first face found.
void check_frames(const Mesh& mesh, const std::filesystem::path& mesh_file, const Scene& scene,
                  std::span<const ViewId> used);

/// Fraction of faces that some view may frame, over a sample of 100,000; occlusion is ignored.
double framed_share(const Mesh& mesh, const Scene& scene, std::span<const ViewId> used);

/// Per face of a sample, how many views may frame it and stand on its front side, ascending; occlusion is ignored. The
/// sample is of at most 20,000 faces, or fewer where there are many views. O(sampled faces x views).
std::vector<std::size_t> overlap(const Mesh& mesh, const Scene& scene, std::span<const ViewId> used);

/// Views that suffice for a first look: each face of a sample that n of `used` may show, as overlap() counts, may be shown by
/// min(n, times) of these; up to one face in 200 may have fewer. Ascending, chosen greedily. O(sampled faces x views).
std::vector<ViewId> few_views(const Mesh& mesh, const Scene& scene, std::span<const ViewId> used, int times);

/// What a grid of rays from some views hits first.
struct Backs {
  double share = 0;    ///< of the rays that hit a face: on its back (corners clockwise)
  double covered = 0;  ///< of all rays: those that hit a face
};

/// Of at least four of the used views. Occlusion counts, so the far sides of closed meshes do not. Empty when no ray hits a
/// face. O(faces + framed faces x sampled views).
std::optional<Backs> back_share(const Mesh& mesh, const Scene& scene, std::span<const ViewId> used);

/// A warning for a share of a fifth or more, else empty. Throws InputError above nine tenths: the mesh is inside out, the
/// cameras are behind its surface, or it is another scene's.
std::string check_winding(std::optional<Backs> backs, const std::filesystem::path& mesh_file);

/// Lengths, in the scene's units, that a pixel covers at vertices of the mesh, for every view that frames them, ascending.
/// Takes a sample of `most` vertices, or fewer where there are many views. O(sampled vertices x views).
std::vector<double> sampling_distances(const Mesh& mesh, const Scene& scene, std::span<const ViewId> used,
                                       std::size_t most = 20000);

/// A warning when the mesh's positions are float numbers that are rounded to a pixel's length or more, else empty. Throws
/// InputError when the whole mesh is a few pixels large. \param sampling sampling_distances()
std::string check_scale(const Mesh& mesh, std::span<const double> sampling, const std::filesystem::path& mesh_file);

/// A warning where the terms of lenses fold back on themselves inside the photos, so that a tenth of one and more shows
/// nothing: they are another lens's, or wrong. O(views).
std::string check_lenses(const Scene& scene, std::span<const ViewId> used);

}  // namespace gpvc::checks
