// Do mesh and cameras share a frame? The usual mistake is one of them in another coordinate system.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "io/scene.h"

namespace gpvc::pipeline {

struct Box {
  WorldPoint low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
  void add(const WorldPoint& p);
};

Box box_of(const Mesh& mesh);
/// Of the camera centres.
Box box_of(const Scene& scene);
std::string box_text(const Box& box);

/// Whether a face may lie in a view's frame: not all of it beyond one border or behind the camera. Says yes to some
/// faces just outside a corner, never no to one inside.
bool may_be_framed(const View& view, const Mesh& mesh, const Triangle& face);

/// Throws InputError, with both boxes, when no face of the mesh may be framed by any of the views. Looks at single
/// faces only where the box of a run of faces reaches into a frame, and stops at the first face found.
void check_frames(const Mesh& mesh, const std::filesystem::path& mesh_file, const Scene& scene,
                  std::span<const ViewId> used);

/// Share of the faces, of 100,000 spread over the mesh, that some view may frame; occlusion is not looked at.
double framed_share(const Mesh& mesh, const Scene& scene, std::span<const ViewId> used);

/// Share of backs (corners clockwise) among what cameras see first, at a grid of points of at least four of the used
/// views, spread over them; occlusion is looked at, so that the far sides of closed meshes do not count. Empty when no
/// point sees a face. Time grows with faces + those in frame x views looked at.
std::optional<double> back_share(const Mesh& mesh, const Scene& scene, std::span<const ViewId> used);

/// What to warn of a back_share from a fifth, else empty. Throws InputError above nine in ten: the mesh is inside out,
/// or the cameras stand behind it.
std::string check_winding(std::optional<double> backs, const std::filesystem::path& mesh_file);

}  // namespace gpvc::pipeline
