// One tile of the initial visibility map, drawn on the CPU so that owners are certain to within float rounding, not to
// within the step of a depth buffer.
//
// A face whose runs of pixels are certain (QuickFace) is drawn at 1 / z, in floats. With D its largest 1 / z, and its
// smallest no less than D / 2:
//
//     what is drawn is off by less than                         kNear D     (see draw_rows())
//     what another face has stored, s, is off by less than      kFar s      because that face's D is at most 2 s
//
// If one exceeds the other by more than both errors together, its face is nearer in real arithmetic, and so is every
// face that replaces it later. If neither does, the greater value is kept, and the face that loses is noted as a doubt:
// if it is the right owner, it beats the stored one exactly. So the owner of a pixel is the nearest face, or among the
// doubts.
//
// All other faces (crossing the camera plane, beyond QuickLimits, too deep, slivers) are drawn last, by rounded depths,
// and the caller must contest them in full. A certain face that one of them replaces is a doubt as well.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "visibility/classify/exact_owner.h"
#include "visibility/raster/prepared_view.h"

namespace gpvc::visibility {

/// Facts about a face once it was drawn.
enum FaceMark : std::uint8_t {
  kMarkSampled = 1,  ///< it covers a pixel centre
  kMarkLost = 2,     ///< some sample is stored as another face's
  kMarkStored = 4,   ///< some sample is stored as its own
  kMarkFront = 8,    ///< it faces the camera
  kMarkInside = 16,  ///< all of it certainly lies in the frame
  kMarkUnsure = 32,  ///< none of these is certain, nor which faces it hides
};

/// Per face.
struct DrawnFaces {
  std::vector<std::uint8_t> marks;     ///< of FaceMark
  std::vector<std::uint32_t> samples;  ///< pixel centres that it covers

  void start(std::size_t faces) {
    marks.resize(faces);
    samples.resize(faces);
  }
};

/// Scratch of one thread.
class IvmTile {
 public:
  static constexpr int kShift = 7;
  static constexpr std::int32_t kSide = 1 << kShift;

  /// Clears the doubts, the rough pixels and the counts.
  void start_view();
  /// Draws `faces` and `unlisted`, which are disjoint, into the pixels of the box, at most kSide a side, of a row-major
  /// item buffer as wide as the view; kNoFace outside the photo. Adds the marks and samples of the faces to `drawn`,
  /// atomically where they reach beyond the box. Deterministic for a given order of faces.
  void draw(const PreparedView& view, const PixelBox& box, std::span<const FaceId> faces,
            std::span<const FaceId> unlisted, std::span<FaceId> ivm, DrawnFaces& drawn);

  /// Over all tiles of the view: faces that may beat the stored owner of a pixel.
  std::span<const Claim> doubts() const { return doubts_; }
  /// Over all tiles of the view: pixels that may be stored for a face that does not cover their centre.
  std::span<const std::uint32_t> rough_pixels() const { return rough_pixels_; }
  /// Over all tiles of the view: samples of a face that another one hides.
  std::size_t hidden_samples() const { return hidden_samples_; }

 private:
  /// A face of the tile.
  struct Entry {
    std::uint32_t samples = 0;
    std::uint8_t marks = 0;  ///< without kMarkLost and kMarkStored
    bool shared = false;     ///< the face may reach into other tiles
  };
  /// A sample whose depth is too close to the stored one for floats to decide.
  struct Close {
    std::uint32_t at;
    float value;
  };
  /// The tile as draw_rows() writes it: row-major, kSide pixels a row and eight more at the end; faces by number, from
  /// 1.
  struct Target {
    float* depths;          ///< 1 / z, 0 where nothing is
    std::uint32_t* owners;  ///< 0: none
    std::uint8_t* lost;     ///< by number
    std::vector<Close>* close;
  };
  /// A face to be drawn.
  struct FaceSetup {
    std::size_t first;  ///< pixel of the box's corner
    PixelBox box;       ///< around the face in the tile
    RowCrossings edges;
    InverseDepth plane;
    double largest;  ///< 1 / z of a vertex
    std::uint32_t number;
  };
  /// What drawing a face found.
  struct FaceTally {
    std::uint32_t samples = 0;
    std::uint32_t hidden = 0;  ///< certain samples that hide others or are hidden
  };
  /// What all runs of a face share.
  struct RunSetup {
    EightIds number;
    float per_x, near;
  };

  void start(std::span<const FaceId> faces, std::span<const FaceId> unlisted);
  void draw_face(const PreparedView& view, std::uint32_t number);
  bool draw_certain(const PreparedView& view, const FaceBounds& bounds, std::uint32_t number);
  void draw_unsure(const PreparedView& view, std::uint32_t number);
  static bool draw_rows(const FaceSetup& face, const Target& target, FaceTally& tally);
  static void fill_run(const RunSetup& run, const Target& target, std::size_t first, float value, std::int32_t length,
                       EightInts& behind, std::uint32_t& hidden);
  void resolve_close(std::uint32_t number);
  std::size_t pixel(std::int32_t x, std::int32_t y) const {
    return static_cast<std::size_t>(y - box_.y0) * kSide + static_cast<std::size_t>(x - box_.x0);
  }
  bool beats_stored(std::size_t at, float value, std::uint32_t number) const;
  void replace(std::size_t at, float value, std::uint32_t number);
  /// The number of a pixel of the tile in the view.
  std::uint32_t pixel_of_view(std::size_t at) const;
  void add_doubt(std::size_t at, std::uint32_t number);
  void clear_outside_photo(const PreparedView& view, std::size_t first_doubt);
  void store(const PreparedView& view, std::span<FaceId> ivm);
  void add_to(DrawnFaces& drawn) const;

  PixelBox box_;
  std::uint32_t view_width_ = 0;
  std::vector<float> depths_;
  std::vector<std::uint32_t> owners_;
  std::vector<FaceId> faces_;                ///< by number
  std::vector<Entry> entries_;               ///< by number
  std::vector<std::uint8_t> lost_, stored_;  ///< by number
  std::vector<std::uint32_t> unsure_;        ///< numbers
  std::vector<Span> spans_;                  ///< of the current face
  std::vector<Close> close_;                 ///< of the current face
  std::vector<Claim> doubts_;
  std::vector<std::uint32_t> rough_pixels_;
  std::size_t hidden_samples_ = 0;
};

}  // namespace gpvc::visibility
