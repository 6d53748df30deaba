// What a view sees of a single point or face of a mesh, without drawing the view: the answer of VisibilityStage for one sample,
// or for the samples of one face. Faces that may stand in between are found in a tree of boxes, and the predicates that decide
// are those of the stage, so that classes are the same.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "../io/names.h"
#include "../io/scene.h"
#include "result.h"

namespace gpvc::io {
struct PhotoExclusion;  // photos.h
}

namespace gpvc::visibility {

/// A point of a mesh's surface.
struct SurfacePoint {
  WorldPoint at;
  std::vector<FaceId>
      faces;  ///< on which it lies, the nearest first; several on an edge, or where faces coincide; never empty
  double distance = 0;  ///< from the place that was asked for, in units of the mesh
};

/// Whether a view shows a point, or what keeps it from it: the first of these, from top to bottom, that holds.
enum class Sight : std::uint8_t {
  seen,
  behind,         ///< not in front of the camera
  outside_frame,  ///< projects beside the frame
  outside_photo,  ///< in the frame, where the lens shows nothing of the photo
  masked,         ///< on a pixel that a mask or the photo's alpha excludes
  back,           ///< the face turns its back
  edge_on,        ///< the face is seen from the side, or is degenerate
  hidden,         ///< by another face
};
inline constexpr Named<Sight> kSightNames[] = {{"seen", Sight::seen},
                                               {"behind", Sight::behind},
                                               {"outside-frame", Sight::outside_frame},
                                               {"outside-photo", Sight::outside_photo},
                                               {"masked", Sight::masked},
                                               {"back", Sight::back},
                                               {"edge-on", Sight::edge_on},
                                               {"hidden", Sight::hidden}};

struct PointSight {
  Sight sight = Sight::behind;
  FaceId face = kNoFace;              ///< the one of the point's faces that is looked at
  FaceId hidden_by = kNoFace;         ///< what the view sees there instead, if it is hidden
  std::optional<PixelPoint> frame{};  ///< where the frame has it, also beside it; none: behind the camera
  std::optional<PhotoPoint> photo{};  ///< where the photo has it, in pixels of the view's camera; none: nowhere
};

struct FaceSight {
  FaceClass found = FaceClass::hidden;  ///< never unresolved
  float visible_share = 0;              ///< 1 of a full face, 0 of a hidden one, else as in FaceCoverage
  std::size_t visible = 0;              ///< samples that see it
};

/// The points and faces of one mesh. Thread-safe: nothing changes once it is made.
class PointStage {
 public:
  /// Borrows the mesh. Throws InputError for one that validate_faces() refuses. O(faces log faces), TBB; some 20 bytes a face.
  explicit PointStage(const Mesh& mesh);
  ~PointStage();
  PointStage(PointStage&&) noexcept;

  /// The point of the surface nearest to a place, with all faces that it lies on to the accuracy of doubles. nullopt: the mesh
  /// has no face. About O(log faces).
  std::optional<SurfacePoint> nearest(const WorldPoint& place) const;
  /// The centroid of one face, which alone counts as the face that it lies on: one of equal corners may hide it.
  SurfacePoint middle(FaceId face) const;

  /// Of the point as a sample of its face: it is seen where no other face covers its position in the frame nearer to the
  /// camera. Of several faces that it lies on the first that turns its front counts, and they do not hide each other.
  /// `excluded`: as VisibilityStage::classify() takes it. O(faces between camera and point).
  PointSight look(const SurfacePoint& point, const View& view, const io::PhotoExclusion* excluded) const;

  /// The class that VisibilityStage gives the face with sub-pixel resolution. O(faces between camera and face, times rows of
  /// its projection).
  FaceSight classify(FaceId face, const View& view, const io::PhotoExclusion* excluded) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace gpvc::visibility
