// Where bands lie, by what was matched.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "io/bands/band_registration.h"
#include "io/order_statistics.h"

namespace gpvc::io {
namespace {

/// Coefficients of right or down by (1, x, y), by least squares; nullopt where the places do not tell. Solves the normal
/// equations by Cramer's rule: three unknowns, places about the photo's middle in units of its size.
std::optional<std::array<double, 3>> fit_plane(std::span<const std::array<double, 3>> places,
                                               std::span<const double> values) {
  std::array<std::array<double, 3>, 3> m{};
  std::array<double, 3> v{};
  for (std::size_t i = 0; i < places.size(); ++i)
    for (std::size_t r = 0; r < 3; ++r) {
      for (std::size_t c = 0; c < 3; ++c) m[r][c] += places[i][r] * places[i][c];
      v[r] += places[i][r] * values[i];
    }
  const auto determinant = [](const std::array<std::array<double, 3>, 3>& d) {
    return d[0][0] * (d[1][1] * d[2][2] - d[1][2] * d[2][1]) - d[0][1] * (d[1][0] * d[2][2] - d[1][2] * d[2][0]) +
           d[0][2] * (d[1][0] * d[2][1] - d[1][1] * d[2][0]);
  };
  const double all = determinant(m), n = static_cast<double>(places.size());
  constexpr double kSpread = 1e-6;  // of places that lie on a line
  if (!(all > kSpread * n * n * n)) return std::nullopt;
  std::array<double, 3> result{};
  for (std::size_t c = 0; c < 3; ++c) {
    auto replaced = m;
    for (std::size_t r = 0; r < 3; ++r) replaced[r][c] = v[r];
    result[c] = determinant(replaced) / all;
  }
  return result;
}

double median(std::vector<double> values) { return upper_median(std::span(values)); }

/// Right and down as functions of (1, x, y).
using Map = std::array<std::array<double, 3>, 2>;

/// Fits matches, again without what lies far off until nothing does.
class Fitter {
 public:
  Fitter(std::span<const BandMatch> matches, int width, int height) {
    for (const BandMatch& match : matches) {
      places_.push_back({1, match.x / width - 0.5, match.y / height - 0.5});
      right_.push_back(match.right);
      down_.push_back(match.down);
    }
  }

  /// \param error the median distance of the matches that count
  Map fit(bool affine, double& error) const {
    std::vector<std::size_t> kept(places_.size());
    for (std::size_t i = 0; i < kept.size(); ++i) kept[i] = i;
    Map map{};
    constexpr int kRounds = 5;
    for (int round = 0; round < kRounds; ++round) {
      map = map_of(kept, affine);
      std::vector<double> distances(places_.size());
      for (std::size_t i = 0; i < distances.size(); ++i) distances[i] = distance(map, i);
      std::vector<double> of_kept;
      for (const std::size_t i : kept) of_kept.push_back(distances[i]);
      error = median(of_kept);
      constexpr double kSure = 0.05;  // px: what interpolation between correlations leaves
      kept.clear();
      for (std::size_t i = 0; i < distances.size(); ++i)
        if (distances[i] <= 3 * error + kSure) kept.push_back(i);
    }
    return map;
  }

 private:
  Map map_of(const std::vector<std::size_t>& kept, bool affine) const {
    std::vector<std::array<double, 3>> places;
    std::vector<double> right, down;
    for (const std::size_t i : kept) {
      places.push_back(places_[i]);
      right.push_back(right_[i]);
      down.push_back(down_[i]);
    }
    const auto x = affine ? fit_plane(places, right) : std::nullopt,
               y = affine ? fit_plane(places, down) : std::nullopt;
    if (x && y) return {*x, *y};
    return {{{median(right), 0, 0}, {median(down), 0, 0}}};
  }
  double distance(const Map& map, std::size_t i) const {
    const auto& p = places_[i];
    const auto value = [&](const std::array<double, 3>& c) { return c[0] + c[1] * p[1] + c[2] * p[2]; };
    return std::hypot(value(map[0]) - right_[i], value(map[1]) - down_[i]);
  }

  std::vector<std::array<double, 3>> places_;
  std::vector<double> right_, down_;
};

/// A map that is nearly a shift by whole pixels at the four corners becomes one.
void snap(Map& map) {
  constexpr double kNear = 0.1;
  const std::array<double, 2> whole{std::round(map[0][0]), std::round(map[1][0])};
  for (const double x : {-0.5, 0.5})
    for (const double y : {-0.5, 0.5})
      for (std::size_t i = 0; i < 2; ++i)
        if (std::abs(map[i][0] + map[i][1] * x + map[i][2] * y - whole[i]) > kNear) return;
  for (std::size_t i = 0; i < 2; ++i) map[i] = {whole[i], 0, 0};
}

}  // namespace

BandPlace place_of_matches(std::span<const BandMatch> matches, int width, int height) {
  BandPlace place;
  if (matches.size() < kFewestMatches) return place;
  const Fitter fitter(matches, width, height);
  constexpr double kBetter = 0.9;
  double shift_error = 0, affine_error = 0;
  Map map = fitter.fit(false, shift_error);
  const Map affine = fitter.fit(true, affine_error);
  const bool is_affine = affine_error < kBetter * shift_error;
  if (is_affine) map = affine;
  snap(map);
  // In units of the photo's size, from its middle, to pixels from its corner.
  const auto row = [&](const std::array<double, 3>& c) {
    return std::array<double, 3>{c[1] / width, c[2] / height, c[0] - c[1] / 2 - c[2] / 2};
  };
  const auto x = row(map[0]), y = row(map[1]);
  place.file_from_photo = {1 + x[0], x[1], x[2], y[0], 1 + y[1], y[2]};
  place.error_px = is_affine ? affine_error : shift_error;
  return place;
}

}  // namespace gpvc::io
