// Places that are asked for, brought to the mesh, and points of the mesh in the coordinates that people know.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/query/photos.h"

namespace gpvc::query {

struct Place {
  WorldPoint at;
  bool has_height = true;  ///< else the highest surface there is meant
  std::string
      srs{};  ///< reference system of the coordinates; empty: those of the mesh's file, or of the scene's system
  std::string name{};  ///< in errors and answers: "point 2"
};

/// Finds places on the mesh of an input. Borrows it and the finder.
class PlaceFinder {
 public:
  PlaceFinder(const checks::Input& input, const PhotoFinder& finder);

  /// The point of the mesh nearest to a place. Throws InputError for a place that is no number, that is farther from the mesh than
  /// limit(), or whose system cannot be brought to the scene's. O(log faces); without a height O(faces).
  visibility::SurfacePoint find(const Place& place) const;
  /// A fiftieth of the diagonal of the mesh's bounding box, in units of the scene.
  double limit() const { return limit_; }

  /// The point in the coordinates of the mesh's file.
  WorldPoint in_file(const visibility::SurfacePoint& point) const;
  /// The point in the scene's reference system; nullopt where that is unknown.
  std::optional<WorldPoint> in_system(const visibility::SurfacePoint& point) const;

 private:
  std::optional<visibility::SurfacePoint> nearest_in_file(const WorldPoint& place) const;
  std::optional<visibility::SurfacePoint> highest(const WorldPoint& place) const;
  [[noreturn]] void fail(const Place& place, const std::string& reason) const;

  checks::Input input_;
  const PhotoFinder& finder_;
  double limit_ = 0;
  Mesh as_in_file_;  ///< empty where the file has the scene's coordinates
  std::optional<visibility::PointStage> file_stage_;
};

/// The system that PROJ takes points of the scene, with its offset, from and to: that of the scene, where that is east, north and
/// up from a place a projection around it that is the same within a centimetre for ten kilometres. Empty: unknown.
std::string system_of(const Scene& scene);

}  // namespace gpvc::query
