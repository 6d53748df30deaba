// Whether meshes and cameras that a program has in memory are what the libraries take: readers of files give no others.
#pragma once

#include <span>

#include "error.h"
#include "scene.h"

namespace gpvc {

// All throw InputError: one sentence with the index of the first thing that is wrong, and what was expected of it.

/// Faces name vertices that are there. O(faces), TBB.
void validate_faces(const Mesh& mesh);
/// The same; positions are numbers up to io::kMostCoordinate, and what is stated for each vertex or
/// face is as long as there are such. A mesh without faces is one. O(n), TBB.
void validate(const Mesh& mesh);
/// A size of 1 to 2^16 pixels each way, focal lengths from 10^-3 to 10^12 px, the principal point and all terms of the lens
/// numbers, the rotation one.
void validate(const View& view);
/// The mesh, which has faces; the views, which the scene has, ascending, at least one.
void validate(const Scene& scene, const Mesh& mesh, std::span<const ViewId> views);
/// The same with all views.
void validate(const Scene& scene, const Mesh& mesh);

}  // namespace gpvc
