// Brings mesh and cameras into the same coordinates where their files have different ones.
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "../../io/error.h"
#include "../../io/scene.h"

namespace gpvc::checks {

/// Does nothing where the mesh fits the cameras as they are (check_frames() and check_scale() accept it) and none of the
/// scene's other frames, or of read_parser_frames(), fits clearly better: by the share of the mesh that is framed, nine tenths at least of all views
/// together, less what is seen from behind. A
/// mesh of glTF, whose y is up, is turned where it fits clearly better with z up. The cameras are taken to such a frame;
/// where they fit in none and not as they are, the mesh is taken from where its metadata.xml says that it lies, or from
/// a reference system that its positions may be in (the scene's reference, the UTM zone of geocentric cameras), to the
/// scene's coordinates. Models are still written with the mesh's own positions. With `mesh_crs` the mesh is taken from
/// that system, whatever fits. Remarks what was assumed. Throws InputError where
/// mesh_crs cannot be used, as PROJ does not know it or the scene has no reference system, and for a metadata.xml that
/// is needed and broken.
Remark match_frames(Scene& scene, Mesh& mesh, std::span<const ViewId> used, const std::filesystem::path& mesh_file,
                    const std::string& mesh_crs = {});

/// True if check_frames() and check_scale() accept some of the mesh's faces as they are.
bool fits_cameras(const Scene& scene, const Mesh& mesh, std::span<const ViewId> used);

/// What a user can do about a mesh that fits cameras of this scene in no known way; empty: nothing beyond what
/// check_input() says.
Remark ways_out(const Scene& scene);

}  // namespace gpvc::checks
