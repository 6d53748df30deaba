#include "io/reference_system.h"

#include <proj.h>
#include <proj_experimental.h>  // proj_crs_promote_to_3D

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string_view>

#include "io/error.h"
#include "io/files/frees.h"
#include "io/files/text_scan.h"
#include "io/finite.h"
#include "io/number_text.h"
#include "io/scene_members.h"

namespace gpvc::io {
namespace {

using Context = std::unique_ptr<PJ_CONTEXT, Frees<proj_context_destroy>>;
using Object = std::unique_ptr<PJ, Frees<proj_destroy>>;
using Objects = std::unique_ptr<PJ_OBJ_LIST, Frees<proj_list_destroy>>;
using Factory = std::unique_ptr<PJ_OPERATION_FACTORY_CONTEXT, Frees<proj_operation_factory_context_destroy>>;

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
    throw Error(quote(text) +
                " is no coordinate reference system that PROJ knows: expected EPSG:NUMBER, a WKT or a "
                "PROJ string");
  flat = without_zero_shift(context, std::move(flat));
  const PJ_TYPE type = proj_get_type(flat.get());
  const bool is_flat = type == PJ_TYPE_GEOGRAPHIC_2D_CRS || type == PJ_TYPE_PROJECTED_CRS;
  Object high(is_flat && with_heights ? proj_crs_promote_to_3D(context, nullptr, flat.get()) : nullptr);
  return high ? std::move(high) : std::move(flat);
}

/// Takes points as they are given, x east or longitude; null where PROJ knows no way.
Object way_between(PJ_CONTEXT* context, const Object& source, const Object& target) {
  const Object raw(proj_create_crs_to_crs_from_pj(context, source.get(), target.get(), nullptr, nullptr));
  return Object(raw ? proj_normalize_for_visualization(context, raw.get()) : nullptr);
}

bool has_own_heights(const Object& system) { return proj_get_type(system.get()) == PJ_TYPE_COMPOUND_CRS; }

/// The first grid of an operation that is not there.
std::optional<MissingGrid> absent_grid(PJ_CONTEXT* context, const PJ* operation) {
  for (int i = 0; i < proj_coordoperation_get_grid_used_count(context, operation); ++i) {
    const char *name = nullptr, *url = nullptr;
    int available = 1;
    if (proj_coordoperation_get_grid_used(context, operation, i, &name, nullptr, nullptr, &url, nullptr, nullptr,
                                          &available) != 0 &&
        available == 0)
      return MissingGrid{name != nullptr ? name : "", url != nullptr ? url : ""};
  }
  return std::nullopt;
}

bool covers(PJ_CONTEXT* context, const PJ* operation, const WorldPoint& degrees) {
  double west = 0, south = 0, east = 0, north = 0;
  constexpr double kUnknown = -1000;
  if (proj_get_area_of_use(context, operation, &west, &south, &east, &north, nullptr) == 0 || west == kUnknown)
    return true;
  const bool in_east = west <= east ? west <= degrees.x && degrees.x <= east : degrees.x >= west || degrees.x <= east;
  return in_east && south <= degrees.y && degrees.y <= north;
}

/// True for a way of PROJ's that leaves heights as they are because it knows nothing better.
bool guesses_heights(const PJ* way) {
  const char* name = proj_get_name(way);
  return name != nullptr && lower_case(name).find("ballpark vertical transformation") != std::string::npos;
}

/// What is missed of the ways that cover the place: the grid of the most accurate one, if it is not there, with what is left
/// then; or any way for heights.
std::optional<MissingGrid> missing_grid_at(PJ_CONTEXT* context, const Object& source, const Object& target,
                                           const WorldPoint& point) {
  const Object globe = system_from(context, "EPSG:4326", false);
  const Object to_degrees = way_between(context, source, globe);
  if (!to_degrees) return std::nullopt;
  const PJ_COORD at = proj_trans(to_degrees.get(), PJ_FWD, proj_coord(point.x, point.y, point.z, 0));
  const Factory factory(proj_create_operation_factory_context(context, nullptr));
  proj_operation_factory_context_set_spatial_criterion(context, factory.get(),
                                                       PROJ_SPATIAL_CRITERION_PARTIAL_INTERSECTION);
  proj_operation_factory_context_set_grid_availability_use(context, factory.get(), PROJ_GRID_AVAILABILITY_IGNORED);
  const Objects ways(proj_create_operations(context, source.get(), target.get(), factory.get()));
  constexpr double kUnknown = std::numeric_limits<double>::infinity();
  double best = kUnknown, usable = kUnknown;
  std::optional<MissingGrid> missing, for_heights;
  bool any = false, takes_heights = false;
  for (int i = 0; ways && i < proj_list_get_count(ways.get()); ++i) {
    const Object way(proj_list_get(context, ways.get(), i));
    if (!way || !covers(context, way.get(), {at.xy.x, at.xy.y, 0})) continue;
    const bool is_guess = proj_coordoperation_has_ballpark_transformation(context, way.get()) != 0;
    const double stated = proj_coordoperation_get_accuracy(context, way.get());
    const double accuracy = is_guess || stated < 0 ? kUnknown : stated;
    std::optional<MissingGrid> absent = absent_grid(context, way.get());
    if (!absent) usable = std::min(usable, accuracy);
    any = true;
    if (!guesses_heights(way.get())) {
      takes_heights = takes_heights || !absent;
      if (!for_heights) for_heights = absent;
    }
    if (accuracy >= best) continue;
    best = accuracy;
    missing = std::move(absent);
  }
  if (best >= usable) missing.reset();
  if (!missing && any && !takes_heights) missing = for_heights.value_or(MissingGrid{});
  if (missing) missing->accuracy_m = usable == kUnknown ? -1 : usable;
  return missing;
}

}  // namespace

std::optional<MissingGrid> missing_grid(const std::string& from, const std::string& to, const WorldPoint& point,
                                        HeightsAbove heights) {
  const Context context(proj_context_create());
  proj_log_level(context.get(), PJ_LOG_NONE);
  return missing_grid_at(context.get(), system_from(context.get(), from, heights == HeightsAbove::own_ellipsoid),
                         system_from(context.get(), to), point);
}

std::string sentence_on(const MissingGrid& grid, const std::string& from, const std::string& to) {
  constexpr const char* kLeft = "leaves heights as they are, which may be wrong by 50 m";
  if (grid.name.empty())
    return "PROJ knows no way for heights from " + quote(from) + " to " + quote(to) + " and " + kLeft +
           ": expected heights of a system that it knows one for, or, if they are above the ellipsoid, the system of "
           "the "
           "ground alone";
  const std::string without = grid.accuracy_m < 0 ? kLeft : "is right within " + shortest_text(grid.accuracy_m) + " m";
  return "PROJ lacks the grid " + grid.name + " for the way from " + quote(from) + " to " + quote(to) +
         ", and what it does without " + without + ": put the grid where PROJ looks for its files (" +
         (grid.address.empty() ? "" : grid.address + "; ") + "Debian's package proj-data holds many)";
}

void transform_points(const std::string& from, const std::string& to, std::span<WorldPoint> points,
                      HeightsAbove heights) {
  const Context context(proj_context_create());
  proj_log_level(context.get(), PJ_LOG_NONE);
  // From a system without heights PROJ leaves z as it is.
  const Object source = system_from(context.get(), from, heights == HeightsAbove::own_ellipsoid),
               target = system_from(context.get(), to);
  const Object way = way_between(context.get(), source, target);
  if (!way) throw Error("PROJ knows no way from " + quote(from) + " to " + quote(to));
  if (points.empty()) return;
  if (has_own_heights(source) || has_own_heights(target))
    if (const auto grid = missing_grid_at(context.get(), source, target, points[0]); grid && grid->accuracy_m < 0)
      throw Error(sentence_on(*grid, from, to));
  constexpr std::size_t kStep = sizeof(WorldPoint);
  const std::vector<WorldPoint> before(points.begin(), points.end());
  proj_trans_generic(way.get(), PJ_FWD, &points[0].x, kStep, points.size(), &points[0].y, kStep, points.size(),
                     &points[0].z, kStep, points.size(), nullptr, 0, 0);
  const auto bad = std::find_if_not(points.begin(), points.end(), is_finite<WorldPoint>);
  if (bad == points.end()) return;
  const WorldPoint& p = before[static_cast<std::size_t>(bad - points.begin())];
  throw Error("the point (" + shortest_text(p.x) + ", " + shortest_text(p.y) + ", " + shortest_text(p.z) +
              ") is none of " + quote(from));
}

namespace {

// The code of a system that is the same but for its name.
std::string code_of(PJ_CONTEXT* context, const Object& system) {
  constexpr int kSame = 70;
  int* confidence = nullptr;
  const Objects found(proj_identify(context, system.get(), "EPSG", nullptr, &confidence));
  std::string code;
  if (found && proj_list_get_count(found.get()) > 0 && confidence[0] >= kSame) {
    const Object best(proj_list_get(context, found.get(), 0));
    const char* number = best ? proj_get_id_code(best.get(), 0) : nullptr;
    if (number != nullptr) code = std::string("EPSG:") + number;
  }
  proj_int_list_destroy(confidence);
  return code;
}

// What the heights of a compound system are above.
std::string level_of_heights(PJ_CONTEXT* context, const Object& system) {
  const Object vertical(proj_crs_get_sub_crs(context, system.get(), 1));
  if (!vertical) return "a level of their own";
  const Object datum(proj_crs_get_datum_forced(context, vertical.get()));
  const char* name = proj_get_name(datum ? datum.get() : vertical.get());
  return name != nullptr ? name : "a level of their own";
}

}  // namespace

SystemName system_name(const std::string& system) {
  const Context context(proj_context_create());
  proj_log_level(context.get(), PJ_LOG_NONE);
  SystemName found;
  Object object = object_from(context.get(), system);
  if (!object || !proj_is_crs(object.get())) return found;
  // PROJ calls what a string describes "unknown".
  if (const char* name = proj_get_name(object.get()); name != nullptr && std::string_view(name) != "unknown")
    found.name = name;
  const bool is_compound = proj_get_type(object.get()) == PJ_TYPE_COMPOUND_CRS;
  if (is_compound) found.heights = level_of_heights(context.get(), object);
  found.code = code_of(context.get(), object);
  // A height is measured in a system of its own; the first of the two is that of the ground.
  if (is_compound) object = Object(proj_crs_get_sub_crs(context.get(), object.get(), 0));
  object = without_zero_shift(context.get(), std::move(object));
  found.is_geocentric = proj_get_type(object.get()) == PJ_TYPE_GEOCENTRIC_CRS;
  const Object axes(proj_crs_get_coordinate_system(context.get(), object.get()));
  const char* unit = nullptr;
  if (axes &&
      proj_cs_get_axis_info(context.get(), axes.get(), 0, nullptr, nullptr, nullptr, nullptr, &unit, nullptr,
                            nullptr) != 0 &&
      unit != nullptr)
    found.unit = unit;
  if (axes && !is_compound && proj_cs_get_axis_count(context.get(), axes.get()) == 3) found.heights = "";
  return found;
}

std::string system_wkt(const std::string& system) {
  const Context context(proj_context_create());
  proj_log_level(context.get(), PJ_LOG_NONE);
  const Object object = system_from(context.get(), system, false);
  const char* const options[] = {"MULTILINE=NO", nullptr};
  const char* wkt = proj_as_wkt(context.get(), object.get(), PJ_WKT2_2019, options);
  if (wkt == nullptr) throw Error(quote(system) + " has no definition as WKT");
  return wkt;
}

std::string utm_zone(const WorldPoint& geocentric) {
  std::vector<WorldPoint> point{geocentric};
  transform_points(kGeocentric, "EPSG:4979", point);
  const int zone = std::clamp(static_cast<int>(std::floor((point[0].x + 180) / 6)) + 1, 1, 60);
  return "EPSG:" + std::to_string((point[0].y >= 0 ? 32600 : 32700) + zone);
}

}  // namespace gpvc::io
