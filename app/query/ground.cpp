#include "app/query/ground.h"

#include <utility>

#include "app/ortho/frame.h"
#include "app/pipeline/viewpoint.h"
#include "io/reference_system.h"
#include "io/view_rules.h"

namespace gpvc::query {

void Ground::to_lonlat(std::vector<WorldPoint>& points) const {
  for (WorldPoint& p : points) p.z = 0;  // heights play no part, and grids for them may be missing
  io::transform_points(wkt, io::kGeoJsonSystem, points);
}

Ground ground_of(const checks::Input& input) {
  ortho::Surface surface;
  surface.mesh.positions = input.mesh.positions;
  surface.mesh.faces = input.mesh.faces;
  surface.coordinates.srs = input.scene.srs;
  surface.coordinates.srs_offset = input.scene.offset;
  surface.source = input.mesh_file;
  if (!input.views.empty()) surface.up = pipeline::up_direction(input.scene, input.views);
  ortho::Frame frame = ortho::place_surface(surface, {});
  return {std::move(surface.mesh), std::move(frame.wkt), std::move(frame.name)};
}

}  // namespace gpvc::query
