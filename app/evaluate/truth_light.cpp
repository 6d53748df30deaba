// How far brightness and tint of a model are off the truth, place by place.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <tuple>
#include <vector>

#include "app/evaluate/truth_score.h"
#include "io/order_statistics.h"

namespace gpvc::evaluate {
namespace {

/// Squares along the longer edge of the ground. Each has some thousand points, whose ratios scatter by a few per cent.
constexpr int kSquares = 20;

using Logs = std::array<double, 3>;

/// The squares of the ground by x and y.
class Ground {
 public:
  explicit Ground(const Mesh& mesh) {
    constexpr double kFar = std::numeric_limits<double>::infinity();
    double most_x = -kFar, most_y = -kFar;
    least_x_ = least_y_ = kFar;
    for (const WorldPoint& p : mesh.positions) {
      least_x_ = std::min(least_x_, p.x);
      least_y_ = std::min(least_y_, p.y);
      most_x = std::max(most_x, p.x);
      most_y = std::max(most_y, p.y);
    }
    edge_ = std::max({most_x - least_x_, most_y - least_y_, std::numeric_limits<double>::min()}) / kSquares;
  }
  std::size_t square(const WorldPoint& p) const {
    const auto place = [&](double at, double least) {
      return static_cast<std::size_t>(std::clamp((at - least) / edge_, 0.0, kSquares - 1.0));
    };
    return place(p.y, least_y_) * kSquares + place(p.x, least_x_);
  }

 private:
  double least_x_ = 0, least_y_ = 0, edge_ = 1;
};

/// Sets `log` to the logarithm of the ratio of a texel to the mean of its own colours. False if either is too dark or too bright for
/// that.
bool log_ratio(const Pixel& texel, const OwnColors& own, Logs& log) {
  constexpr float kDarkest = 24, kBrightest = 245;
  for (std::size_t c = 0; c < 3; ++c) {
    const float mean = own.sum[c] / own.count;
    if (std::min(mean, texel[c]) < kDarkest || std::max(mean, texel[c]) > kBrightest) return false;
    log[c] = std::log(static_cast<double>(texel[c]) / static_cast<double>(mean));
  }
  return true;
}

/// The largest of the logarithms, and the one that 95 % of them stay below, as shares.
std::array<double, 2> worst_and_95(std::vector<double>& logs) {
  if (logs.empty()) return {};
  std::ranges::sort(logs);
  return {std::expm1(logs.back()), std::expm1(logs[(logs.size() - 1) * 19 / 20])};
}

}  // namespace

TruthLight light_of(const Mesh& mesh, const TruthPoints& points, std::span<const std::optional<Pixel>> texels) {
  constexpr std::size_t kEnough = 30;
  const Ground ground(mesh);
  std::array<std::vector<std::vector<double>>, 3> logs;
  for (auto& channel : logs) channel.resize(std::size_t{kSquares} * kSquares);
  for (std::size_t i = 0; i < points.seen.size(); ++i) {
    Logs log{};
    if (!texels[i] || !log_ratio(*texels[i], points.own[i], log)) continue;
    const std::size_t square = ground.square(position_of(mesh, points.seen[i]));
    for (std::size_t c = 0; c < 3; ++c) logs[c][square].push_back(log[c]);
  }
  std::vector<Logs> places;
  for (std::size_t square = 0; square < logs[0].size(); ++square)
    if (logs[0][square].size() >= kEnough)
      places.push_back({upper_median(std::span(logs[0][square])), upper_median(std::span(logs[1][square])),
                        upper_median(std::span(logs[2][square]))});
  TruthLight light;
  light.places = places.size();
  if (places.empty()) return light;
  for (std::size_t c = 0; c < 3; ++c) {
    std::vector<double> all;
    for (const Logs& place : places) all.push_back(place[c]);
    const double middle = upper_median(std::span(all));
    for (Logs& place : places) place[c] -= middle;
  }
  std::vector<double> bright, tint;
  for (const Logs& place : places) {
    const double mean = (place[0] + place[1] + place[2]) / 3;
    bright.push_back(std::abs(mean));
    tint.push_back(std::max({std::abs(place[0] - mean), std::abs(place[1] - mean), std::abs(place[2] - mean)}));
  }
  std::tie(light.brightness_worst, light.brightness_95) = std::tuple_cat(worst_and_95(bright));
  std::tie(light.tint_worst, light.tint_95) = std::tuple_cat(worst_and_95(tint));
  return light;
}

}  // namespace gpvc::evaluate
