// Where two bands show the same.
#include "io/bands/band_registration.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace gpvc::io {
namespace {

/// A picture of one value a pixel.
struct Plane {
  int width = 0, height = 0;
  std::vector<float> values{};
  float at(int x, int y) const { return values[pixel_index(x, y, width)]; }
};

Plane plane_of(const Samples& photo, std::size_t band) {
  Plane plane{photo.width, photo.height};
  const std::byte* from = photo.bytes.data() + band * bytes_of(photo.type);
  plane.values.resize(pixel_index(0, photo.height, photo.width));
  for (float& value : plane.values) {
    value = load_sample(from, photo.type);
    from += photo.pixel_bytes();
  }
  return plane;
}

Plane halved(const Plane& plane) {
  Plane half{plane.width / 2, plane.height / 2};
  half.values.reserve(pixel_index(0, half.height, half.width));
  for (int y = 0; y < half.height; ++y)
    for (int x = 0; x < half.width; ++x)
      half.values.push_back((plane.at(2 * x, 2 * y) + plane.at(2 * x + 1, 2 * y) + plane.at(2 * x, 2 * y + 1) +
                             plane.at(2 * x + 1, 2 * y + 1)) /
                            4);
  return half;
}

/// Each value and its neighbours to the left and right, weighted 1, 2, 1.
Plane blurred_rows(const Plane& plane) {
  Plane out = plane;
  for (int y = 0; y < plane.height; ++y)
    for (int x = 1; x + 1 < plane.width; ++x)
      out.values[pixel_index(x, y, plane.width)] = (plane.at(x - 1, y) + 2 * plane.at(x, y) + plane.at(x + 1, y)) / 4;
  return out;
}

Plane blurred_columns(const Plane& plane) {
  Plane out = plane;
  for (int y = 1; y + 1 < plane.height; ++y)
    for (int x = 0; x < plane.width; ++x)
      out.values[pixel_index(x, y, plane.width)] = (plane.at(x, y - 1) + 2 * plane.at(x, y) + plane.at(x, y + 1)) / 4;
  return out;
}

/// Magnitudes of the gradient, 0 at the border, and blurred: a correlation of lines as thin as a pixel is no parabola about its peak.
Plane edges_of(const Plane& plane) {
  Plane edges{plane.width, plane.height};
  edges.values.resize(plane.values.size());
  for (int y = 1; y + 1 < plane.height; ++y)
    for (int x = 1; x + 1 < plane.width; ++x) {
      const float across = plane.at(x + 1, y) - plane.at(x - 1, y), down = plane.at(x, y + 1) - plane.at(x, y - 1);
      edges.values[pixel_index(x, y, plane.width)] = std::sqrt(across * across + down * down);
    }
  return blurred_columns(blurred_rows(edges));
}

/// A rectangle of the primary's pixels.
struct Window {
  int left, top, right, bottom;
};

/// Sums over pairs of values, each in so many parts that compilers add side by side.
class PairSums {
 public:
  /// \pre a row is short against the digits of a float
  void add_row(const float* a, const float* b, int count) {
    Parts pa{}, pb{}, paa{}, pbb{}, pab{};
    int x = 0;
    for (; x + kParts <= count; x += kParts)
      for (int part = 0; part < kParts; ++part)
        add(a[x + part], b[x + part], static_cast<std::size_t>(part), pa, pb, paa, pbb, pab);
    for (; x < count; ++x) add(a[x], b[x], 0, pa, pb, paa, pbb, pab);
    for (std::size_t part = 0; part < pa.size(); ++part) {
      a_ += static_cast<double>(pa[part]);
      b_ += static_cast<double>(pb[part]);
      aa_ += static_cast<double>(paa[part]);
      bb_ += static_cast<double>(pbb[part]);
      ab_ += static_cast<double>(pab[part]);
    }
  }
  /// nullopt where either has one value alone.
  std::optional<double> correlation(double n) const {
    const double spread = (aa_ - a_ * a_ / n) * (bb_ - b_ * b_ / n);
    if (!(spread > 0)) return std::nullopt;
    return (ab_ - a_ * b_ / n) / std::sqrt(spread);
  }

 private:
  static constexpr int kParts = 8;
  using Parts = std::array<float, kParts>;
  static void add(float a, float b, std::size_t part, Parts& pa, Parts& pb, Parts& paa, Parts& pbb, Parts& pab) {
    pa[part] += a;
    pb[part] += b;
    paa[part] += a * a;
    pbb[part] += b * b;
    pab[part] += a * b;
  }
  double a_ = 0, b_ = 0, aa_ = 0, bb_ = 0, ab_ = 0;
};

/// The correlation of a window with the same one of the other plane, moved; nullopt where either shows nothing.
std::optional<double> correlation(const Plane& a, const Plane& b, Window w, int right, int down) {
  w.left = std::max({w.left, 0, -right});
  w.top = std::max({w.top, 0, -down});
  w.right = std::min({w.right, a.width, b.width - right});
  w.bottom = std::min({w.bottom, a.height, b.height - down});
  if (w.left >= w.right || w.top >= w.bottom) return std::nullopt;
  PairSums sums;
  for (int y = w.top; y < w.bottom; ++y)
    sums.add_row(&a.values[pixel_index(w.left, y, a.width)], &b.values[pixel_index(w.left + right, y + down, b.width)],
                 w.right - w.left);
  return sums.correlation(static_cast<double>(w.right - w.left) * (w.bottom - w.top));
}

/// The plane and its halves, quarters and so on, the edges of each.
std::vector<Plane> edge_pyramid(Plane plane) {
  constexpr int kCoarse = 96;
  std::vector<Plane> pyramid;
  for (; plane.width / 2 >= kCoarse && plane.height / 2 >= kCoarse; plane = halved(plane))
    pyramid.push_back(edges_of(plane));
  pyramid.push_back(edges_of(plane));
  return pyramid;
}

/// All of a plane, or as much about its middle as tells as well.
Window middle_of(const Plane& plane) {
  constexpr int kMost = 512;
  const int width = std::min(plane.width, kMost), height = std::min(plane.height, kMost);
  const int left = (plane.width - width) / 2, top = (plane.height - height) / 2;
  return {left, top, left + width, top + height};
}

struct Shift {
  int right = 0, down = 0;
  double score = -1;
};

Shift best_shift(const Plane& a, const Plane& b, const Window& window, const Shift& about, int reach) {
  Shift best;
  for (int down = about.down - reach; down <= about.down + reach; ++down)
    for (int right = about.right - reach; right <= about.right + reach; ++right)
      if (const auto score = correlation(a, b, window, right, down); score && *score > best.score)
        best = {right, down, *score};
  return best;
}

/// Where the parabola through three neighbouring values is highest, from the middle one.
double peak(double before, double middle, double behind) {
  const double bend = before - 2 * middle + behind;
  return bend < 0 ? std::clamp((before - behind) / (2 * bend), -0.5, 0.5) : 0;
}

/// The match of a square of the finest planes; nullopt where it shows too little.
std::optional<BandMatch> match_window(const Plane& a, const Plane& b, const Window& window, const Shift& about,
                                      int reach) {
  constexpr double kAlike = 0.5;
  const Shift best = best_shift(a, b, window, about, reach);
  if (best.score < kAlike) return std::nullopt;
  if (std::abs(best.right - about.right) == reach || std::abs(best.down - about.down) == reach) return std::nullopt;
  const auto beside = [&](int right, int down) {
    return correlation(a, b, window, best.right + right, best.down + down).value_or(best.score);
  };
  return BandMatch{(window.left + window.right) / 2.0, (window.top + window.bottom) / 2.0,
                   best.right + peak(beside(-1, 0), best.score, beside(1, 0)),
                   best.down + peak(beside(0, -1), best.score, beside(0, 1))};
}

}  // namespace

std::vector<BandMatch> match_bands(const Samples& photo, std::size_t primary, std::size_t band) {
  const std::vector<Plane> a = edge_pyramid(plane_of(photo, primary)), b = edge_pyramid(plane_of(photo, band));
  Shift shift;
  int reach = a.back().width / 8;
  for (std::size_t level = a.size(); level-- > 0; reach = 2) {
    const Window all = middle_of(a[level]);
    shift = best_shift(a[level], b[level], all, {2 * shift.right, 2 * shift.down}, reach);
    // Coarse levels may have lost what the fine ones show; most bands lie near each other.
    const bool is_far = std::max(std::abs(shift.right), std::abs(shift.down)) > 2;
    if (const Shift none = is_far ? best_shift(a[level], b[level], all, {}, 2) : shift; none.score > shift.score)
      shift = none;
    if (shift.score < 0) return {};
  }
  constexpr int kAcross = 8, kDown = 6;
  const int edge = std::clamp(std::min(photo.width, photo.height) / 8, 24, 96);
  std::vector<BandMatch> matches;
  for (int j = 0; j < kDown; ++j)
    for (int i = 0; i < kAcross; ++i) {
      const int left = (photo.width - edge) * i / (kAcross - 1), top = (photo.height - edge) * j / (kDown - 1);
      const int turned = 3 + edge / 24;  // px: what a turn and another focal length add far from the middle
      if (const auto match = match_window(a[0], b[0], {left, top, left + edge, top + edge}, shift, turned))
        matches.push_back(*match);
    }
  return matches;
}

}  // namespace gpvc::io
