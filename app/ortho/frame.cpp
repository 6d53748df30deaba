#include "app/ortho/frame.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "app/pipeline/viewpoint.h"
#include "app/tileset/placing.h"
#include "io/error.h"
#include "io/reference_system.h"
#include "io/vector.h"

namespace gpvc::ortho {
namespace {

template <typename Change>
void change_all(std::vector<WorldPoint>& positions, const Change& change) {
  tbb::parallel_for(std::size_t{0}, positions.size(), [&](std::size_t i) { positions[i] = change(positions[i]); });
}

// --- without a reference system

using Axes = std::array<WorldPoint, 3>;  // of the picture, in the scene's coordinates

// The axes next to those of the scene whose third one is `up`.
Axes axes_along(const WorldPoint& up, io::UpAxis nearest) {
  io::ModelOptions turned;
  turned.up = nearest;
  Axes axes;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto along = [&](const WorldPoint& p) { return tileset::tile_from_world(turned, p).at[i]; };
    axes[i] = {along({1, 0, 0}), along({0, 1, 0}), along({0, 0, 1})};
  }
  // From there by the shortest turn, which takes axes[2] to `up`.
  const WorldPoint about = cross(axes[2], up);
  const double cosine = dot(axes[2], up);  // far from -1, as the axis is the nearest
  for (WorldPoint& axis : axes) axis = axis * cosine + cross(about, axis) + about * (dot(about, axis) / (1 + cosine));
  return axes;
}

// "-z", or its three numbers.
std::string axis_text(const WorldPoint& axis) {
  for (const auto& known : io::kUpAxisNames)
    if (length(pipeline::up_vector(known.value) - axis) < 1e-12) return known.name;
  return fmt::format("({:.6f}, {:.6f}, {:.6f})", axis.x, axis.y, axis.z);
}

Frame place_by_up(Surface& surface, const OrthoSettings& settings) {
  constexpr double kExact = 0.99619;  // the cosine of 5 degrees: scenes that somebody has turned upright are
  WorldPoint up{0, 0, 1};
  if (settings.up)
    up = pipeline::up_vector(*settings.up);
  else if (surface.up)
    up = unit(*surface.up);
  io::UpAxis nearest = io::UpAxis::pos_z;
  for (const auto& axis : io::kUpAxisNames)
    if (dot(pipeline::up_vector(axis.value), up) > dot(pipeline::up_vector(nearest), up)) nearest = axis.value;
  if (dot(pipeline::up_vector(nearest), up) >= kExact) up = pipeline::up_vector(nearest);
  const Axes axes = axes_along(up, nearest);
  change_all(surface.mesh.positions, [&](const WorldPoint& p) {
    const WorldPoint q = p + surface.coordinates.offset;
    return WorldPoint{dot(axes[0], q), dot(axes[1], q), dot(axes[2], q)};
  });
  return {"", fmt::format("no reference system: x, y and height are the scene's {}, {} and {}", axis_text(axes[0]),
                          axis_text(axes[1]), axis_text(axes[2]))};
}

// --- with one

// At the mean height of the surface.
std::string plane_of(const std::array<double, 2>& place, const std::vector<WorldPoint>& positions) {
  double sum = 0;
  for (const WorldPoint& p : positions) sum += p.z;
  return tileset::plane_around(place, std::round(sum / static_cast<double>(positions.size())));
}

void take_to_geocentric(std::vector<WorldPoint>& positions, const std::string& srs) {
  if (!tileset::place_of_enu(srs)) return io::transform_points(srs, io::kGeocentric, positions);
  io::ModelOptions there;
  there.srs = srs;
  there.up = io::UpAxis::pos_z;
  const tileset::Matrix m = *tileset::geocentric_from_tile(there);
  change_all(positions, [&](const WorldPoint& p) {
    const auto row = [&](std::size_t i) { return m[i] * p.x + m[4 + i] * p.y + m[8 + i] * p.z + m[12 + i]; };
    return WorldPoint{row(0), row(1), row(2)};
  });
}

// The system that a surface in `srs` is drawn in unless another is asked for.
std::string system_for(const std::string& srs, const std::vector<WorldPoint>& positions) {
  const io::SystemName name = io::system_name(srs);
  if (!name.is_geocentric && name.unit != "degree") return srs;
  std::vector<WorldPoint> middle{positions[positions.size() / 2]};
  take_to_geocentric(middle, srs);
  return io::utm_zone(middle.front());
}

}  // namespace

Frame place_surface(Surface& surface, const OrthoSettings& settings) {
  const std::string srs = surface.coordinates.srs;
  std::vector<WorldPoint>& positions = surface.mesh.positions;
  if (srs.empty()) {
    if (!settings.crs.empty())
      throw InputError(surface.source, "",
                       fmt::format("is in no known reference system, so that it cannot be taken to {}", settings.crs));
    return place_by_up(surface, settings);
  }
  const WorldPoint offset = surface.coordinates.offset + surface.coordinates.srs_offset;
  change_all(positions, [&](const WorldPoint& p) { return p + offset; });
  const auto enu = tileset::place_of_enu(srs);
  std::string to = settings.crs;
  if (to.empty()) to = enu ? plane_of(*enu, positions) : system_for(srs, positions);
  std::string wkt;
  try {
    wkt = io::system_wkt(to);
  } catch (const Error& unknown) {
    if (!settings.crs.empty()) throw;
    return {"", fmt::format("the scene's own: {}", unknown.what())};
  }
  if (enu && !settings.crs.empty()) {
    take_to_geocentric(positions, srs);
    io::transform_points(io::kGeocentric, to, positions);
  } else if (!enu && to != srs) {
    io::transform_points(srs, to, positions);
  }
  const io::SystemName name = io::system_name(to);
  return {wkt, fmt::format("coordinates of {}", name.name.empty() ? to : name.name)};
}

}  // namespace gpvc::ortho
