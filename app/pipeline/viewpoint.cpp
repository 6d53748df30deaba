#include "app/pipeline/viewpoint.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "io/vector.h"

namespace gpvc::pipeline {
namespace {

struct MeanCamera {
  WorldPoint forward, up, centre;
};

// Means over the cameras; forward and up are shorter than 1 where cameras disagree.
MeanCamera mean_camera(const Scene& scene, std::span<const ViewId> used) {
  MeanCamera mean;
  const double share = 1.0 / static_cast<double>(used.size());
  for (const ViewId id : used) {
    const Pose& pose = scene.views[index(id)].pose;
    const auto& r = pose.rotation;
    mean.forward = mean.forward + WorldPoint{r[6], r[7], r[8]} * share;
    mean.up = mean.up - WorldPoint{r[3], r[4], r[5]} * share;
    mean.centre = mean.centre + pose.centre * share;
  }
  return mean;
}

// Root mean square distance of the cameras from their centre along a direction.
double spread(const Scene& scene, std::span<const ViewId> used, const WorldPoint& centre, const WorldPoint& direction) {
  double sum = 0;
  for (const ViewId id : used) {
    const double along = dot(scene.views[index(id)].pose.centre - centre, direction);
    sum += along * along;
  }
  return std::sqrt(sum / static_cast<double>(used.size()));
}

// True for photos taken on the ground: upright cameras whose places differ least in height. The photos of one flight strip
// share their up direction, too, but are spread along it. Two photos are too few to decide.
bool stand_upright(const Scene& scene, std::span<const ViewId> used, const MeanCamera& mean) {
  if (used.size() < 3 || length(mean.up) < 0.9) return false;
  const WorldPoint up = unit(mean.up);
  const WorldPoint right = unit(cross(mean.forward, up)), ahead = cross(up, right);
  const double height = spread(scene, used, mean.centre, up);
  const double width = spread(scene, used, mean.centre, right), depth = spread(scene, used, mean.centre, ahead);
  return height * 4 < std::max(width, depth) && height < std::min(width, depth);
}

io::UpAxis nearest_axis(const WorldPoint& d) {
  const double x = std::abs(d.x), y = std::abs(d.y), z = std::abs(d.z);
  if (z >= x && z >= y) return d.z >= 0 ? io::UpAxis::pos_z : io::UpAxis::neg_z;
  if (y >= x) return d.y >= 0 ? io::UpAxis::pos_y : io::UpAxis::neg_y;
  return d.x >= 0 ? io::UpAxis::pos_x : io::UpAxis::neg_x;
}

// Fraction of points on each side that are ignored as outliers.
constexpr double kTail = 0.002;

// Corners of the faces with a view (of all faces where none has one), thinned to about 8000 faces.
std::vector<WorldPoint> seen_points(std::span<const WorldPoint> positions, std::span<const Triangle> faces,
                                    std::span<const ViewId> labels) {
  std::size_t seen = 0;
  for (const ViewId label : labels) seen += label != kNoView ? 1 : 0;
  const bool any = seen > 0;
  const std::size_t step = std::max<std::size_t>(1, (any ? seen : labels.size()) / 8000);
  std::vector<WorldPoint> points;
  for (std::size_t f = 0, n = 0; f < labels.size(); ++f) {
    if ((any && labels[f] == kNoView) || n++ % step != 0) continue;
    for (const std::uint32_t v : faces[f]) points.push_back(positions[v]);
  }
  return points;
}

WorldPoint mean(std::span<const WorldPoint> points) {
  WorldPoint sum;
  for (const WorldPoint& p : points) sum = sum + p;
  return sum * (1 / static_cast<double>(points.size()));
}

// Rounds the rank outwards, so that quantiles of few values are their extremes.
double quantile(std::vector<double> values, double q) {
  const double rank = q * static_cast<double>(values.size() - 1);
  const auto at = static_cast<std::ptrdiff_t>(q > 0.5 ? std::ceil(rank) : std::floor(rank));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

// A camera that looks along `forward` and has all but the outliers of the points in its picture, with a margin.
Viewpoint framed(const std::vector<WorldPoint>& points, const WorldPoint& forward, const WorldPoint& up, int width,
                 int height) {
  constexpr double kMargin = 1.08;
  const WorldPoint z = unit(forward), x = unit(cross(z, up)), y = cross(z, x);
  Viewpoint v;
  v.camera.width = width;
  v.camera.height = height;
  v.camera.fx = v.camera.fy = 1.4 * width;  // a long lens: 39 degrees across
  v.camera.cx = width / 2.0;
  v.camera.cy = height / 2.0;
  v.pose.rotation = {x.x, x.y, x.z, y.x, y.y, y.z, z.x, z.y, z.z};
  const double tan_x = width / 2.0 / v.camera.fx / kMargin, tan_y = height / 2.0 / v.camera.fy / kMargin;
  // A point is inside when |x - x0| <= tan_x (depth): four half-planes. Each pair of quantiles of x -+ tan_x z gives
  // the place of its apex; the camera stands at the farther of the two apexes, in the middle of both pairs.
  const auto apex = [&](const WorldPoint& axis, double tangent, double& place) {
    std::vector<double> low, high;
    for (const WorldPoint& p : points) {
      low.push_back(dot(p, axis) + tangent * dot(p, z));
      high.push_back(dot(p, axis) - tangent * dot(p, z));
    }
    const double l = quantile(low, kTail), h = quantile(high, 1 - kTail);
    place = (l + h) / 2;
    return (l - h) / 2 / tangent;  // z of the apex
  };
  double px = 0, py = 0;
  const double zx = apex(x, tan_x, px), zy = apex(y, tan_y, py);
  v.pose.centre = x * px + y * py + z * std::min(zx, zy);
  return v;
}

}  // namespace

WorldPoint up_direction(const Scene& scene, std::span<const ViewId> used) {
  const MeanCamera mean = mean_camera(scene, used);
  if (stand_upright(scene, used, mean)) return unit(mean.up);
  // The viewing directions of cameras all around an object cancel each other; their up directions do not.
  if (length(mean.forward) < 0.05) return unit(mean.up);
  return unit(mean.forward * -1);
}

io::UpAxis scene_up(const Scene& scene, std::span<const ViewId> used) {
  return nearest_axis(up_direction(scene, used));
}

WorldPoint up_vector(io::UpAxis axis) {
  constexpr std::array<WorldPoint, 6> kVectors{{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}}};
  return kVectors[static_cast<std::size_t>(axis)];
}

Viewpoint overview(const Mesh& mesh, std::span<const ViewId> labels, const Scene& scene, std::span<const ViewId> used,
                   io::UpAxis axis, int width, int height) {
  const MeanCamera mean = mean_camera(scene, used);
  const std::vector<WorldPoint> points = seen_points(mesh.positions, mesh.faces, labels);
  // Where the cameras agree, they give the up direction more precisely than an axis does.
  const WorldPoint axis_up = up_vector(axis);
  const WorldPoint forward = unit(mean.forward);
  const bool look_down = dot(forward, axis_up) < -0.7;
  WorldPoint up = look_down && length(mean.forward) > 0.5 ? forward * -1 : axis_up;
  if (!look_down && length(mean.up) > 0.5) up = unit(mean.up);
  if (!look_down && length(mean.forward) > 0.3) return framed(points, forward, up, width, height);
  // From above: look 40 degrees below the horizon, in the direction that is up in the cameras' pictures or, where these
  // disagree, in the first one's.
  WorldPoint ahead = mean.up - up * dot(mean.up, up);
  if (length(ahead) < 0.2) {
    const auto& r = scene.views[index(used.front())].pose.rotation;
    ahead = WorldPoint{-r[3], -r[4], -r[5]};
    ahead = ahead - up * dot(ahead, up);
  }
  if (length(ahead) < 1e-6) ahead = cross(up, {up.y, up.z, up.x});
  constexpr double kCos40 = 0.766, kSin40 = 0.643;
  return framed(points, unit(ahead) * kCos40 - up * kSin40, up, width, height);
}

WorldPoint local_origin(const Mesh& mesh, const std::vector<WorldPoint>& written, std::span<const ViewId> labels,
                        const Scene& scene, std::span<const ViewId> used) {
  const std::vector<WorldPoint> points = seen_points(written, mesh.faces, labels);
  if (points.empty()) return {};
  double largest = 0, extent = 0;
  const auto middle_along = [&](double WorldPoint::*axis) {
    std::vector<double> values;
    for (const WorldPoint& p : points) values.push_back(p.*axis);
    const double low = quantile(values, kTail), high = quantile(values, 1 - kTail);
    largest = std::max({largest, std::abs(low), std::abs(high)});
    extent = std::max(extent, high - low);
    return (low + high) / 2;
  };
  const WorldPoint middle{middle_along(&WorldPoint::x), middle_along(&WorldPoint::y), middle_along(&WorldPoint::z)};
  // The middle in the scene's coordinates, about.
  const WorldPoint place = &written == &mesh.positions ? middle : mean(seen_points(mesh.positions, mesh.faces, labels));
  std::vector<double> sampling;  // ground size of a pixel there
  for (const ViewId id : used) {
    const View& view = scene.views[index(id)];
    sampling.push_back(length(place - view.pose.centre) / view.camera.fx);
  }
  // A coordinate c becomes a float with an error of at most |c| 2^-24.
  if (largest * 0x1p-24 <= 0.01 * quantile(sampling, 0.5)) return {};
  if (!(extent > 0)) return {};
  const double step = std::pow(10.0, std::min(2.0, std::floor(std::log10(extent))));
  const auto whole = [&](double v) { return std::round(v / step) * step; };
  return {whole(middle.x), whole(middle.y), whole(middle.z)};
}

}  // namespace gpvc::pipeline
