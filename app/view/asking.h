// Questions that a click asks: what is here, which photos show it, and what do they show.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/evaluate/json.h"
#include "app/pipeline/judgement.h"
#include "app/pipeline/run.h"
#include "app/pipeline/undistort.h"
#include "app/query/photos.h"
#include "app/query/places.h"
#include "app/view/pictures.h"

namespace gpvc::view {

/// The scene that a result was textured from. Borrows the run.
struct SceneSide {
  const pipeline::Run* run = nullptr;
  std::shared_ptr<const pipeline::Judgement> judgement{};  ///< null: photos have not been compared
  labeling::CandidateCollector::Allowed allowed{};
};

/// Answers about one scene. Thread-safe.
class Asking {
 public:
  explicit Asking(const SceneSide& scene);

  /// What `gpvc photos` says of the nearest point of the mesh, with its coordinates "at" (scene), "at_file" and "at_srs". \param face
  /// that is shown there: it is looked at first of those that the point lies on. Throws InputError for a place off the mesh.
  evaluate::Json answer(const WorldPoint& place, std::optional<FaceId> face) const;

  /// A square of what a photo shows around a pixel, at its full size, the pixel in its middle; grey beyond the photo. Throws InputError.
  Image cutout(ViewId view, const PhotoPoint& pixel, int size);
  /// The photo without its distortion in frame_of(), at most `edge` pixels. Throws InputError.
  Image undistorted(ViewId view, int edge) const;
  /// The largest part of the view's frame in which the photo leaves nothing blank.
  pipeline::FrameWindow frame_of(ViewId view) const;

  /// The faces that the view sees neither in full nor in part, of those given.
  std::vector<std::uint32_t> unseen(ViewId view, std::span<const std::uint32_t> faces) const;

  const Scene& scene() const { return scene_.run->input.scene; }
  const SceneSide& side() const { return scene_; }
  /// Throws InputError where there is no such view.
  ViewId view(std::size_t number) const;

 private:
  SceneSide scene_;
  query::PhotoFinder finder_;
  query::PlaceFinder places_;
  TakenPhotos taken_;
};

}  // namespace gpvc::view
