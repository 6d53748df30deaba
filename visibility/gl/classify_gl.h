// Visibility classification in compute shaders: the twin of the CPU classifier, with the same bits.
//
// For CoverageCorrection::off and ::paper shaders classify. For ::exact they scan (shaders/scan.comp): they find the
// samples of every face, mark the faces that are stored as the owner of all their samples, and list the samples whose
// stored owner is not certainly the nearer one (claims). CpuClassifier decides the rest.
//
// Memory traffic per view with F faces, V vertices and P pixels. On the device: 48 V bytes to project, 12 F for corners,
// about 72 F for vertices (mostly from caches, since neighbours share them), 4 P of item buffer and P / 8 of mask if
// there is one. To the host: F bytes of codes, 24 bytes of counts and 8 bytes per claim, in three reads after one wait.
// For 611,000 faces and 12 megapixels that is 0.11 GB on the device and 1 MB to the host, besides the 48 MB of the item
// buffer itself.
#pragma once

#include <string>
#include <vector>

#include "visibility/classify/classify.h"
#include "visibility/gl/gl_objects.h"
#include "visibility/gl/ivm_gl.h"

namespace gpvc::visibility {

/// Limits of a device. Tests set smaller ones than the device has.
struct GpuLimits {
  std::size_t texels = 0;                           ///< in a buffer texture
  std::size_t storage_bytes = 0;                    ///< in a storage buffer
  int texture_side = 0;                             ///< of a texture, in pixels
  std::size_t first_claims = std::size_t{1} << 16;  ///< initial capacity for claims
  bool staged_reads = false;                        ///< read through a GlReadBuffer
};

/// The limits of the current context.
GpuLimits gpu_limits();

class GpuClassifier {
 public:
  /// Borrows the mesh and the renderer's buffers. Throws GpuError.
  GpuClassifier(const Mesh& mesh, const IvmRenderer& renderer, const ClassifyOptions& options, const GpuLimits& limits);

  /// Empty if the mesh can be classified within the limits, else the reason why not.
  static std::string obstacle(const Mesh& mesh, const GpuLimits& limits);

  /// Reads the IVM that the renderer drew last if it is one tile, else the view's copy. Leaves all faces unsure if the
  /// shaders cannot scan this view exactly: its depths leave the range in which the error bounds hold, or its claims
  /// exceed a storage buffer. Adds the seconds of uploading, of the shaders and of reading back to the statistics.
  ///
  /// For CoverageCorrection::off and ::paper the counts of samples equal the CPU's on fully visible faces only. On other
  /// faces a shader looks at samples, the ends of all rows first, until it has found a visible and a hidden one; the CPU
  /// stops at the first hidden one and does not count its pass for the coverage.
  void scan(const PreparedView& view, const Pose& pose, FaceScan& scan, VisibilityStatistics& statistics);

 private:
  struct Counts;

  void upload_mask(const PhotoMask& mask);
  void upload_tiles(const PreparedView& view);
  void prepare_view(const PreparedView& view, const Pose& pose, VisibilityStatistics& statistics);
  void set_image(const GlProgram& program, const PreparedView& view) const;
  void project(const Pose& pose, const Camera& camera);
  void find_candidates(const PreparedView& view);
  Counts sample_faces(const PreparedView& view);
  Counts contest_faces(const PreparedView& view);
  void dispatch_contest(const PreparedView& view);
  void dispatch_faces(const GlProgram& program, std::size_t first, std::size_t count) const;
  void bind_codes(std::size_t first, std::size_t count) const;
  void read(const GlBuffer& from, std::size_t bytes, void* to);
  Counts read_counts();
  void make_claims(std::size_t capacity);

  const Mesh& mesh_;
  const IvmRenderer& renderer_;
  ClassifyOptions options_;
  GpuLimits limits_;
  GlProgram project_program_, candidates_program_, hivers_program_, scan_program_, large_program_;
  GlTexture positions_texture_, projected_texture_, corners_texture_, tiles_texture_, mask_texture_;
  GlBuffer projected_, candidate_faces_, codes_, counts_, claims_, large_faces_, mask_;
  std::size_t vertices_per_dispatch_ = 0, faces_per_dispatch_ = 0, claim_capacity_ = 0;
  GlReadBuffer staging_;
  std::uint64_t mask_number_ = 0;
  std::size_t mask_words_ = 0;
  int tile_width_ = 0, tile_height_ = 0;    ///< 0: the current view is one tile
  int tiles_width_ = 0, tiles_height_ = 0;  ///< of the image that tiles_texture_ was made for
};

}  // namespace gpvc::visibility
