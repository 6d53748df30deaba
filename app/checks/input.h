// What a run textures, and whether it can be: the first look at mesh and cameras, before any photo is decoded.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "../../io/scene.h"
#include "../../io/uv_layout.h"
#include "../results/observer.h"

namespace gpvc::checks {

using gpvc::all_views;

/// The mesh to texture and the views to texture it from. Borrows everything. \pre mesh and cameras are in the same coordinates,
/// see prepare()
struct Input {
  const Scene& scene;
  const Mesh& mesh;
  std::span<const ViewId> views;               ///< to texture from, ascending
  std::filesystem::path mesh_file = {"mesh"};  ///< named in errors and warnings
  const io::UvLayout* layout = nullptr;        ///< where the faces lie on pages; null: charts and pages are made
};

/// Throws InputError for an input that no reader gives: see gpvc::validate(). O(n).
void validate(const Input& input);

/// Throws InputError when no view can see the mesh (cameras and mesh in different frames), when it is a few pixels large, or
/// inside out; warns when parts of it are, when its positions are rounded to more than a pixel, and when lenses describe
/// a part of their photos alone. O(faces x at most 64 views).
void check_input(const Input& input, results::Observer& observer);

/// What is known of a mesh beside its positions.
struct MeshOrigin {
  std::filesystem::path file = {"mesh"};
  std::string crs = {};  ///< reference system of its positions; empty: found, if it is not the scene's
};

/// Brings mesh and cameras into the same coordinates (match_frames()), of which it warns; cameras that moved while they were read
/// out learn how far the mesh is (set_nearness()).
void match(Scene& scene, Mesh& mesh, std::span<const ViewId> used, const MeshOrigin& origin,
           results::Observer& observer);

/// match() and check_input(): to be called before anything is textured. Throws InputError, with the ways out.
void prepare(Scene& scene, Mesh& mesh, std::span<const ViewId> used, const MeshOrigin& origin,
             results::Observer& observer);

}  // namespace gpvc::checks
