#include "io/reference_system.h"

#include <proj.h>
#include <proj_experimental.h>  // proj_crs_promote_to_3D

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <string_view>

#include "io/error.h"
#include "io/files/text_scan.h"
#include "io/number_text.h"

namespace gpvc::io {
namespace {

struct DestroyContext {
  void operator()(PJ_CONTEXT* context) const { proj_context_destroy(context); }
};
struct Destroy {
  void operator()(PJ* object) const { proj_destroy(object); }
};
using Context = std::unique_ptr<PJ_CONTEXT, DestroyContext>;
using Object = std::unique_ptr<PJ, Destroy>;

std::string short_name(const std::string& system) {
  constexpr std::size_t kMost = 60;
  return quote(system.size() > kMost ? system.substr(0, kMost) + "..." : system);
}

// A system bound to WGS 84 by seven zeros (TOWGS84) is the system itself, which PROJ has more to say of.
Object without_zero_shift(PJ_CONTEXT* context, Object system) {
  if (proj_get_type(system.get()) != PJ_TYPE_BOUND_CRS) return system;
  const Object shift(proj_crs_get_coordoperation(context, system.get()));
  std::array<double, 7> terms{};
  if (!shift || proj_coordoperation_get_towgs84_values(context, shift.get(), terms.data(), 7, 0) == 0) return system;
  if (std::any_of(terms.begin(), terms.end(), [](double term) { return term != 0; })) return system;
  Object base(proj_get_source_crs(context, system.get()));
  return base ? std::move(base) : std::move(system);
}

// PROJ takes "+proj=utm +zone=32" for a conversion unless it says that it is a system, which files leave out: OpenDroneMap's
// proj.txt, .prj files.
Object object_from(PJ_CONTEXT* context, const std::string& text) {
  const bool is_string = text.starts_with("+proj=") || text.starts_with("+init=");
  const bool says_so = text.find("+type=crs") != std::string::npos;
  return Object(proj_create(context, (is_string && !says_so ? text + " +type=crs" : text).c_str()));
}

// `with_heights`: above the ellipsoid where the system has none of its own.
Object system_from(PJ_CONTEXT* context, const std::string& text, bool with_heights = true) {
  Object flat = object_from(context, text);
  if (!flat || !proj_is_crs(flat.get()))
    throw Error(short_name(text) +
                " is no coordinate reference system that PROJ knows: expected EPSG:NUMBER, a WKT or a "
                "PROJ string");
  flat = without_zero_shift(context, std::move(flat));
  const PJ_TYPE type = proj_get_type(flat.get());
  const bool is_flat = type == PJ_TYPE_GEOGRAPHIC_2D_CRS || type == PJ_TYPE_PROJECTED_CRS;
  Object high(is_flat && with_heights ? proj_crs_promote_to_3D(context, nullptr, flat.get()) : nullptr);
  return high ? std::move(high) : std::move(flat);
}

}  // namespace

void transform_points(const std::string& from, const std::string& to, std::span<WorldPoint> points,
                      HeightsAbove heights) {
  const Context context(proj_context_create());
  proj_log_level(context.get(), PJ_LOG_NONE);
  // From a system without heights PROJ leaves z as it is.
  const Object source = system_from(context.get(), from, heights == HeightsAbove::own_ellipsoid),
               target = system_from(context.get(), to);
  Object raw(proj_create_crs_to_crs_from_pj(context.get(), source.get(), target.get(), nullptr, nullptr));
  const Object way(raw ? proj_normalize_for_visualization(context.get(), raw.get()) : nullptr);
  if (!way) throw Error("PROJ knows no way from " + short_name(from) + " to " + short_name(to));
  if (points.empty()) return;
  constexpr std::size_t kStep = sizeof(WorldPoint);
  const std::vector<WorldPoint> before(points.begin(), points.end());
  proj_trans_generic(way.get(), PJ_FWD, &points[0].x, kStep, points.size(), &points[0].y, kStep, points.size(),
                     &points[0].z, kStep, points.size(), nullptr, 0, 0);
  const auto finite = [](const WorldPoint& p) {
    return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
  };
  const auto bad = std::find_if_not(points.begin(), points.end(), finite);
  if (bad == points.end()) return;
  const WorldPoint& p = before[static_cast<std::size_t>(bad - points.begin())];
  throw Error("the point (" + shortest_text(p.x) + ", " + shortest_text(p.y) + ", " + shortest_text(p.z) +
              ") is none of " + short_name(from));
}

SystemName system_name(const std::string& system) {
  const Context context(proj_context_create());
  proj_log_level(context.get(), PJ_LOG_NONE);
  SystemName found;
  Object object = object_from(context.get(), system);
  if (!object || !proj_is_crs(object.get())) return found;
  // PROJ calls what a string describes "unknown".
  if (const char* name = proj_get_name(object.get()); name != nullptr && std::string_view(name) != "unknown")
    found.name = name;
  // A height is measured in a system of its own; the first of the two is that of the ground.
  if (proj_get_type(object.get()) == PJ_TYPE_COMPOUND_CRS)
    object = Object(proj_crs_get_sub_crs(context.get(), object.get(), 0));
  object = without_zero_shift(context.get(), std::move(object));
  const Object axes(proj_crs_get_coordinate_system(context.get(), object.get()));
  const char* unit = nullptr;
  if (axes &&
      proj_cs_get_axis_info(context.get(), axes.get(), 0, nullptr, nullptr, nullptr, nullptr, &unit, nullptr,
                            nullptr) != 0 &&
      unit != nullptr)
    found.unit = unit;
  return found;
}

std::string utm_zone(const WorldPoint& geocentric) {
  std::vector<WorldPoint> point{geocentric};
  transform_points(kGeocentric, "EPSG:4979", point);
  const int zone = std::clamp(static_cast<int>(std::floor((point[0].x + 180) / 6)) + 1, 1, 60);
  return "EPSG:" + std::to_string((point[0].y >= 0 ? 32600 : 32700) + zone);
}

}  // namespace gpvc::io
