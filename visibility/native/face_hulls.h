// Boxes around runs of faces, to leave those beside a frame out together.
#pragma once

#include <cstdint>
#include <vector>

#include "io/scene.h"

namespace gpvc::visibility {

class FaceHulls {
 public:
  FaceHulls() = default;
  /// One box around each kFacesPerRectangle consecutive faces. O(faces), TBB.
  explicit FaceHulls(const Mesh& mesh);
  /// Sets, for each box, 1 if all that is in it lies beside the frame or behind the camera: then outside() holds for each of its
  /// faces. O(boxes).
  void find_beside(const Camera& camera, const Pose& pose, std::vector<std::uint8_t>& beside) const;

 private:
  struct Box {
    WorldPoint middle, half;
  };
  std::vector<Box> boxes_;
};

}  // namespace gpvc::visibility
