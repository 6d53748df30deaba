// Visibility classification in compute shaders, for CoverageCorrection::off and ::paper: the twin of the CPU
// classifier, with the same bits.
#pragma once

#include <string>
#include <vector>

#include "visibility/face_code.h"
#include "visibility/gl_objects.h"
#include "visibility/ivm_gl.h"
#include "visibility/photo_mask.h"

namespace gpvc {

class GpuClassifier {
 public:
  /// Borrows the mesh and the renderer's buffers. Throws GpuError.
  GpuClassifier(const Mesh& mesh, const IvmRenderer& renderer, const VisibilityOptions& options);

  /// Empty when the mesh can be classified on this device; else the reason why not.
  static std::string obstacle(const Mesh& mesh);

  /// Classifies from the IVM that the renderer drew last, in one tile. `codes`: per face. Adds processed
  /// faces, samples and corrected samples to the statistics. These agree with the CPU's on fully visible
  /// faces alone: of the others a shader looks at samples until one sees the face and one does not, the ends
  /// of all rows first; the CPU stops at the first that does not, and leaves its pass for the coverage out.
  void classify(const Camera& camera, const Pose& pose, const PhotoMask& mask, std::vector<FaceCode>& codes,
                VisibilityStatistics& statistics);

 private:
  void upload_mask(const PhotoMask& mask);
  void find_candidates(const Camera& camera);
  void set_view(const Camera& camera, const Pose& pose);

  const Mesh& mesh_;
  const IvmRenderer& renderer_;
  VisibilityOptions options_;
  GlProgram candidates_program_, hivers_program_;
  GlTexture positions_, corners_, photo_mask_;
  GlBuffer candidate_faces_, codes_, counts_;
  std::uint64_t mask_number_ = 0;
  std::size_t faces_per_dispatch_ = 0;
};

}  // namespace gpvc
