// Faces in the oracle's doubles, each value with a bound of its error.
//
// With r the roundoff of a type (2^-53 for double, 2^-64 for long double), a sum or product of n steps is off by at
// most n r times the sum of the sizes of what went in. Bounds below name n and are rounded up.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "io/scene.h"

namespace gpvc::visibility::truth {

/// A tie: a sample this close to an edge, or two depths this close, relative to the depth.
inline constexpr double kTiePx = 1e-9, kTieDepth = 1e-12;

enum class Answer : std::uint8_t { no, maybe, yes };

/// (x, y, z) with x = fx X + cx Z, y = fy Y + cy Z for the camera frame's X, Y, Z = z: the pixel position times depth.
/// Each of x - p z and y - q z, for a position (p, q) within the frame, and z is off by at most `error`.
struct Vertex {
  long double x = 0, y = 0, z = 0, error = 0;
};

using Corners = std::array<Vertex, 3>;

/// O(vertices), TBB.
std::vector<Vertex> project_vertices(const Mesh& mesh, const View& view);

inline Corners corners_of(const Mesh& mesh, const std::vector<Vertex>& vertices, std::size_t face) {
  const Triangle& t = mesh.faces[face];
  return {vertices[t[0]], vertices[t[1]], vertices[t[2]]};
}

/// What is known of a face in a view before its samples are decided.
struct FaceFacts {
  std::int8_t orientation = 0;  ///< -1 front, 1 back, 0 edge-on or degenerate: hides nothing, never seen
  bool thin = false;            ///< too close to edge-on for doubles to agree about its orientation: a tie
  bool crosses = false;         ///< a vertex lies in or behind the camera plane
  Answer inside = Answer::no;   ///< all vertices in front of the camera and in [0,W] x [0,H]
  bool inside_exactly = false;
  bool reaches = false;                  ///< bounds meet the frame; the rest is set only then
  float x0 = 0, y0 = 0, x1 = 0, y1 = 0;  ///< bounds of the projection within the frame, pixels, widened
};

FaceFacts face_facts(const Mesh& mesh, const View& view, const Corners& corners, std::size_t face);

/// A face near one position of the frame, the origin of dx and dy below; valid within kReach pixels of it.
class LocalFace {
 public:
  static constexpr double kReach = 34;

  /// \pre orientation is not 0
  LocalFace(const Corners& corners, int orientation, double origin_x, double origin_y);

  struct Edge {
    double x, y, c;   ///< x dx + y dy + c: positive inside
    double error;     ///< of that value
    double doubtful;  ///< where the value's size is below this, the edge may be within kTiePx
    double slope;     ///< of that value, per pixel
  };
  using Values = std::array<double, 3>;

  const std::array<Edge, 3>& edges() const { return edges_; }

  /// `position_error`: of dx and dy, pixels.
  Answer covers(double dx, double dy, double position_error, Values& values) const {
    Answer answer = Answer::yes;
    for (std::size_t k = 0; k < 3; ++k) {
      const Edge& edge = edges_[k];
      values[k] = edge.x * dx + (edge.y * dy + edge.c);
      const double doubtful = edge.doubtful + position_error * edge.slope;
      if (values[k] < -doubtful) return Answer::no;
      if (!(values[k] > doubtful)) answer = Answer::maybe;
    }
    return answer;
  }

  struct Depth {
    double value, error;
  };
  /// Depth of the face's plane where the edges have these values.
  Depth depth(const Values& values, double position_error) const {
    double sum = 0, weighed = 0, lost = edge_error_sum_ + position_error * slope_sum_;
    for (std::size_t k = 0; k < 3; ++k) {
      const double share = values[k] * weight_[k];
      sum += share;
      weighed += share * (depth_[k] - depth_[0]);
    }
    // The shares are off by `lost` together, and the depths differ by `span_`: the mean of the depths is off by at most
    // 2 span lost / sum while lost is below half of sum, its own rounding by 16 r of the depths. A value that is
    // negative within its error keeps the shares' sizes below sum + 2 lost: the factor 4.
    constexpr double kRounding = 16 * std::numeric_limits<double>::epsilon();
    if (!(sum > 2 * lost)) return {0, std::numeric_limits<double>::infinity()};
    return {depth_[0] + weighed / sum, 4 * span_ * lost / sum + kRounding * largest_};
  }

 private:
  std::array<Edge, 3> edges_;
  std::array<double, 3> weight_, depth_;
  double edge_error_sum_ = 0, slope_sum_ = 0, span_ = 0, largest_ = 0;
};

}  // namespace gpvc::visibility::truth
