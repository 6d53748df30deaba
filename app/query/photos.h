// Which photos show a point of a mesh, how well, and what keeps the others from it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "../../io/names.h"
#include "../../io/photos.h"
#include "../../labeling/view_choice.h"
#include "../../visibility/points.h"
#include "../checks/input.h"
#include "../pipeline/judgement.h"
#include "sharpness.h"

namespace gpvc::query {

/// Whether a photo really shows a point, or the first reason, from top to bottom, why not. The first eight are geometry, the
/// others are known where all photos have been compared (pipeline::Judgement).
enum class Reason : std::uint8_t {
  shown,
  behind,         ///< the point is not in front of the camera
  outside_frame,  ///< it projects beside the frame
  outside_photo,  ///< the lens shows nothing of the photo there
  masked,         ///< a mask or the photo's alpha excludes the pixel
  back,           ///< the surface turns its back
  edge_on,        ///< the surface is seen from the side
  hidden,         ///< by another face: PhotoOfPoint::hidden_by
  left_out,       ///< the photo agrees with no other, as one with a wrong pose does
  background,     ///< photos show what lies behind in the face's place
  mixed,          ///< the photo shows a mixture with that
  refused,        ///< a rule keeps the photo from the face
  outlier,        ///< the photo shows another colour there than the others: something that moves or is not in the mesh
};
inline constexpr Named<Reason> kReasonNames[] = {{"shown", Reason::shown},
                                                 {"behind", Reason::behind},
                                                 {"outside-frame", Reason::outside_frame},
                                                 {"outside-photo", Reason::outside_photo},
                                                 {"masked", Reason::masked},
                                                 {"back", Reason::back},
                                                 {"edge-on", Reason::edge_on},
                                                 {"hidden", Reason::hidden},
                                                 {"left-out", Reason::left_out},
                                                 {"background", Reason::background},
                                                 {"mixed", Reason::mixed},
                                                 {"refused", Reason::refused},
                                                 {"outlier", Reason::outlier}};
/// The reason in words: "hidden by another face".
const char* words_of(Reason reason);

struct PhotoOfPoint {
  ViewId view{};
  Reason reason = Reason::shown;
  FaceId face = kNoFace;       ///< the face of the point that the view looks at
  FaceId hidden_by = kNoFace;  ///< what the photo shows there instead, if the point is hidden
  /// Where the photo has the point, in pixels of the photo as taken, distorted: from its top-left corner, whose first pixel has its
  /// centre at (0.5, 0.5). Of points beside the frame where they would be; none: nowhere.
  std::optional<PhotoPoint> pixel{};
  Sharpness sharpness{};  ///< of points in front of the camera
  /// How the view sees the whole face, whether or not it has the point, and the share of its samples that see it.
  visibility::FaceClass found = visibility::FaceClass::hidden;
  double visible_share = 0;
  /// The face's cost in the labeling, of candidates; without a judgement by geometry alone (no silhouettes, no outliers).
  std::optional<labeling::CostParts> cost{};
  bool doubtful = false;       ///< an outlier that is a candidate all the same, as all photos of the face are
  bool textures_face = false;  ///< it textures the face in the result that the judgement is of
};

struct PointAnswer {
  visibility::SurfacePoint point;
  std::size_t shown = 0;  ///< how many of the photos show it; these come first
  std::vector<PhotoOfPoint>
      photos;  ///< the used views: candidates by cost, others that show it by size, then the rest in order
};

/// Answers for points of one input. Borrows everything. Thread-safe if the photos are.
class PhotoFinder {
 public:
  /// `judgement`: null where photos have not been compared. `costs`: of a finder without one. Throws InputError. O(faces log
  /// faces), TBB.
  PhotoFinder(const checks::Input& input, io::PhotoSource& photos, const pipeline::Judgement* judgement,
              const labeling::CostOptions& costs = {}, labeling::CandidateCollector::Allowed allowed = {});

  /// The point nearest to a place in the scene's coordinates; nullopt for a mesh without faces.
  std::optional<visibility::SurfacePoint> nearest(const WorldPoint& place) const { return stage_.nearest(place); }
  /// A face's centroid. \pre the face is one of the mesh
  visibility::SurfacePoint middle(FaceId face) const { return stage_.middle(face); }
  /// O(views + faces between the cameras and the point), TBB over views. Masks are read of the views that they may take something from.
  PointAnswer photos_of(const visibility::SurfacePoint& point) const;

 private:
  PhotoOfPoint look(const visibility::SurfacePoint& point, ViewId view, labeling::FaceRecord& record) const;
  std::optional<labeling::FaceRecord> record_of(const PhotoOfPoint& photo, const labeling::FaceRecord& geometric) const;
  void choose(FaceId face, std::span<PhotoOfPoint> photos, std::span<const labeling::FaceRecord> geometric) const;

  checks::Input input_;
  io::PhotoSource& photos_;
  const pipeline::Judgement* judgement_;
  labeling::CostOptions costs_;
  labeling::CandidateCollector::Allowed allowed_;
  visibility::PointStage stage_;
};

/// A square of `size` pixels of the photo as taken around a pixel, smaller at its borders, and where the pixel is in it.
struct Cutout {
  Image image;
  PhotoPoint pixel;
};
/// \param photo as its file has it, 3 channels
Cutout cut_out(const Image& photo, const PhotoPoint& pixel, int size);

}  // namespace gpvc::query
