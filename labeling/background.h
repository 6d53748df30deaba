// Finds what photos show beside the object: sky behind a roof, the backdrop of a turntable, the black that undistortion or
// cutting out leaves. A mesh that bulges over its silhouettes, or a pose that is off, would get it as its texture.
#pragma once

#include <memory>

#include "../io/image.h"
#include "../io/scene.h"
#include "../visibility/exclude.h"
#include "../visibility/result.h"

namespace gpvc::io {
struct PhotoExclusion;  // photos.h
}

namespace gpvc::labeling {

/// Looks at one view after another and reuses its memory.
///
/// Background is uniform, up to noise and slow changes. It is recognized in the pixels of the photo that show no face, where such
/// areas take a hundredth of the photo at least, as
/// - sky, if the rays to it rise above the horizon,
/// - a backdrop, if it surrounds the object: it takes four fifths of the frame's edge,
/// - cut out, if it is near-black.
/// A mesh may as well end on water or snow, which is neither, and is left alone. Background is followed over the mesh's
/// silhouette as long as the photo goes on without a step, sky up to a fifth of the frame's diagonal and a backdrop up to a tenth.
/// Where it goes on beyond that, the surface has the background's colour, and none of it is background: a black car before black.
///
/// Black borders are near-black pixels that rows and columns of the photo meet from its edge on, up to a fifth of its size, where
/// such pixels take a fifth of the edge. Photos with a lens distortion have none.
class BackgroundFinder {
 public:
  BackgroundFinder();
  ~BackgroundFinder();
  /// True if pixels that show a face show background. \param excluded pixels of the photo that count for nothing; may be null
  /// \param up of the world, of length 1; some degrees do not matter. O(pixels), TBB.
  bool find(const View& view, const Image& photo, const io::PhotoExclusion* excluded, const visibility::Ivm& ivm,
            const WorldPoint& up);
  /// What the last find() has found.
  const visibility::ExcludedPixels& found() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace gpvc::labeling
