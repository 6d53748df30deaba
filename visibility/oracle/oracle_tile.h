// A square of the image, and which face is nearest at each of its pixel centres and sub-pixel samples.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "visibility/oracle/oracle_exact.h"
#include "visibility/oracle/oracle_faces.h"
#include "visibility/result.h"

namespace gpvc::visibility::truth {

/// The samples of a face, over all tiles. Sums and unions: the order of the tiles does not matter.
struct Tally {
  std::uint32_t members = 0;     ///< pixel centres certainly in the projection
  std::uint32_t seen = 0;        ///< of these, certainly seeing the face
  std::uint32_t disputed = 0;    ///< of these, with another face at the same depth or an edge in between
  std::uint32_t seen_exact = 0;  ///< of the disputed, those that exact arithmetic gives to the face
  std::uint32_t on_edge = 0;     ///< OnEdge, of centres on the face's own edges
};

enum OnEdge : std::uint32_t {
  kEdgeAny = 1,       ///< there is such a centre
  kEdgeIn = 2,        ///< some centre belongs to the face by the top-left rule
  kEdgeInSeen = 4,    ///< some centre belongs to the face and sees it
  kEdgeInUnseen = 8,  ///< some centre belongs to the face and does not see it
  kEdgeMaySee = 16,   ///< some centre sees the face if it belongs to it, for some way of resolving ties
  kEdgeMayMiss = 32,  ///< some centre does not see it, for some way of resolving ties
};

/// One of the four samples of a face without pixel centre.
struct Sample {
  std::uint32_t face = 0;
  std::uint16_t number = 0;  ///< 0..2: between centroid and that vertex; 3: the centroid
  std::uint16_t pixel = 0;   ///< within its tile
  Answer in_image = Answer::no;
  bool in_image_exactly = false;
  bool hidden = false;    ///< certainly
  bool disputed = false;  ///< ties with an occluder
  bool beaten = false;    ///< in exact arithmetic, by an occluder that it ties with
};

/// The point that a sample projects, times a constant: on the face's plane, so its depth is known as well.
Vertex sample_point(const Corners& corners, std::size_t number);

/// The input of all tiles.
struct OracleScene {
  const Mesh& mesh;
  const View& view;
  std::vector<Vertex> vertices;
  std::vector<FaceFacts> facts;
};

class Tile {
 public:
  static constexpr int kSize = 64;

  Tile(const OracleScene& scene, int column, int row);
  /// Finds the nearest face at every pixel centre. `faces` ascend; results are added to `tallies`.
  void decide_pixels(std::span<const std::uint32_t> faces, std::span<Tally> tallies);
  /// Finds the samples that other faces hide. \pre all of them lie in this tile
  void decide_samples(std::span<const std::uint32_t> faces, std::span<Sample> samples);

 private:
  static constexpr std::size_t kPixels = static_cast<std::size_t>(kSize) * kSize;
  static constexpr std::uint32_t kNoOwner = 0xFFFFFFFFU;

  struct Nearest {
    double depth, error;
    std::uint32_t face;
  };
  /// A face at a pixel where doubles cannot decide which face is nearest, or whether this one covers the centre.
  struct Claim {
    std::uint32_t pixel, face;
    LocalFace::Depth depth;
    bool member;  ///< certainly
  };
  struct Box {
    int x0, y0, x1, y1;
  };
  /// A claim in exact arithmetic.
  struct Contender {
    std::uint32_t face;
    bool certain;  ///< the centre is further than a tie from its edges
    bool inside;   ///< it covers the centre, by the top-left rule
    ExactDepth depth;
  };
  struct PlacedSample {
    double dx, dy, position_error;
    LocalFace::Depth depth;
  };

  Box box_of(std::uint32_t face) const;
  LocalFace local(std::uint32_t face) const;
  const ExactFace& exact(std::uint32_t face);
  void draw(std::uint32_t face, std::span<Tally> tallies);
  void compare_with_nearest(std::uint32_t face, std::size_t pixel, const LocalFace::Depth& depth);
  void resolve_claims(std::span<Tally> tallies);
  std::vector<Contender> contenders(std::span<const Claim> claims, std::span<Tally> tallies);
  void resolve_contest(std::uint32_t pixel, std::vector<Contender>& contest, std::span<Tally> tallies);
  void resolve_exactly(std::uint32_t pixel, std::vector<Contender>& contest, std::span<Tally> tallies);
  static void count_contender(const Contender& contender, std::span<const Contender> contest, const Contender* wall,
                              const Contender* owner, Tally& tally);
  void count_seen(std::span<Tally> tallies) const;
  void hide_samples(std::uint32_t face, std::span<Sample> samples);
  void hide_sample(std::uint32_t face, const LocalFace& local, Sample& sample, const PlacedSample& placed);
  PlacedSample place(const Sample& sample) const;
  bool same_triangle(std::uint32_t f, std::uint32_t g) const;
  /// Which is in front where their depths are equal: one that is seen from its front, then the lower index.
  bool precedes(std::uint32_t f, std::uint32_t g) const;
  ExactPoint centre(std::uint32_t pixel) const;

  const OracleScene& scene_;
  int x0_, y0_, width_, height_;  ///< pixels of the frame
  double origin_x_, origin_y_;    ///< of LocalFace: the centre of a pixel near the middle
  std::array<Nearest, kPixels> nearest_;
  std::array<bool, kPixels> outside_{};  ///< the centre lies outside the photo
  std::array<bool, kPixels> contested_{};
  std::vector<Claim> claims_;
  std::unordered_map<std::uint32_t, ExactFace> exact_;
  std::vector<PlacedSample> placed_;
  std::array<std::uint32_t, kPixels + 1> first_sample_;
};

}  // namespace gpvc::visibility::truth
