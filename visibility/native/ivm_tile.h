// One tile of the initial visibility map, drawn on the CPU with certainty instead of a depth buffer's step.
//
// A face whose runs of pixels are certain (QuickFace) is drawn at 1 / z, in floats. With D its largest 1 / z, and its
// smallest no less than D / 2, what is drawn is off by less than kNear D (draw_rows() says why); what another face has
// stored at s by less than kFar s, because that one's D is at most 2 s. Whoever is ahead by more than both together is
// nearer in real arithmetic, and so is whoever replaces it in turn. Where neither is, the greater value is kept, and
// the face that loses is noted as a doubt: if it is the right owner, it beats the stored one exactly. So the owner of a
// pixel is the nearest face, or among the doubts.
//
// All other faces (crossing the camera plane, beyond QuickLimits, deeper than that, slivers) are drawn last, by rounded
// depths, and are left to the caller to contest in full; a certain face that one of them replaces is a doubt, too.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "visibility/classify/classify.h"
#include "visibility/classify/exact_owner.h"

namespace gpvc::visibility {

/// What is known of a face once it was drawn.
enum FaceMark : std::uint8_t {
  kMarkSampled = 1,  ///< it covers a pixel centre
  kMarkLost = 2,     ///< some sample is not stored as its own
  kMarkStored = 4,   ///< some sample is
  kMarkFront = 8,    ///< it faces the camera
  kMarkInside = 16,  ///< all of it lies in the frame
  kMarkUnsure = 32,  ///< none of these is certain, nor whom it hides
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

  /// Forgets the doubts.
  void start_view();
  /// Draws `faces` and `vast`, different ones, into the pixels of the box, at most kSide a side, of a row-major item
  /// buffer as wide as the view; kNoFace outside the photo. Adds to what is known of the faces, atomically where they
  /// reach beyond the box. The same for the same order of faces.
  void draw(const ClassifyView& view, const QuickLimits& limits, const PixelBox& box, std::span<const FaceId> faces,
            std::span<const FaceId> vast, std::span<FaceId> ivm, DrawnFaces& drawn);

  /// Of all tiles of the view: faces that may beat the stored owner of a pixel.
  std::span<const Claim> doubts() const { return doubts_; }
  /// Of all tiles of the view: samples of a face that another one hides.
  std::size_t hidden_samples() const { return hidden_samples_; }

 private:
  /// What is known of a face of the tile.
  struct Entry {
    std::uint32_t samples = 0;
    std::uint8_t marks = 0;  ///< but for kMarkLost and kMarkStored
    bool shared = false;     ///< other tiles may hold some of it
  };
  /// A sample that floats cannot tell from what is stored.
  struct Close {
    std::uint32_t at;
    float value;
  };
  /// What drawing a face takes, and what comes of it.
  struct Drawing {
    // Pixels of the tile, row-major, kSide a row and eight more at the end; faces by number, from 1 on.
    float* depths;          ///< 1 / z, 0 where nothing is
    std::uint32_t* owners;  ///< 0: none
    std::uint8_t* lost;     ///< by number
    std::size_t first;      ///< of the box, in the tile
    PixelBox box;           ///< around the face in the tile
    RowCrossings edges;
    QuickDepth plane;
    double largest;  ///< 1 / z
    std::uint32_t number;
    std::vector<Close>* close;
    std::uint32_t samples = 0;
    std::uint32_t hidden = 0;  ///< samples that hide others or are hidden, of those that are certain
  };

  void start(std::span<const FaceId> faces, std::span<const FaceId> vast);
  void draw_face(const ClassifyView& view, const QuickLimits& limits, std::uint32_t number);
  bool draw_certain(const ClassifyView& view, const QuickLimits& limits, const FaceBounds& bounds,
                    std::uint32_t number);
  void draw_unsure(const ClassifyView& view, std::uint32_t number);
  static bool draw_rows(Drawing& face);
  void settle_close(std::uint32_t number);
  std::size_t pixel(std::int32_t x, std::int32_t y) const {
    return static_cast<std::size_t>(y - box_.y0) * kSide + static_cast<std::size_t>(x - box_.x0);
  }
  bool greater(std::size_t at, float value, std::uint32_t number) const;
  void replace(std::size_t at, float value, std::uint32_t number);
  void doubt(std::size_t at, std::uint32_t number);
  void clear_outside_photo(const ClassifyView& view, std::size_t first_doubt);
  void store(const ClassifyView& view, std::span<FaceId> ivm);
  void add_to(DrawnFaces& drawn) const;

  PixelBox box_;
  std::uint32_t view_width_ = 0;
  std::vector<float> depths_;
  std::vector<std::uint32_t> owners_;
  std::vector<FaceId> faces_;                ///< by number
  std::vector<Entry> entries_;               ///< by number
  std::vector<std::uint8_t> lost_, stored_;  ///< by number
  std::vector<std::uint32_t> unsure_;        ///< numbers
  std::vector<Span> spans_;                  ///< of the face at hand
  std::vector<Close> close_;                 ///< likewise
  std::vector<Claim> doubts_;
  std::size_t hidden_samples_ = 0;
};

}  // namespace gpvc::visibility
