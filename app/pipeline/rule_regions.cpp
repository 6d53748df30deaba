#include "app/pipeline/rule_regions.h"

#include <fmt/format.h>

#include <cstdint>
#include <vector>

#include "io/photo_pixel.h"
#include "io/reference_system.h"
#include "visibility/visibility.h"

namespace gpvc::pipeline {

namespace {

// Marks what one view shows.
void mark_shown(const checks::Input& input, ViewId id, const visibility::ViewVisibility& seen, const PhotoPoint& low,
                const PhotoPoint& high, std::vector<bool>& shown) {
  const View& view = input.scene.views[index(id)];
  const auto is_inside = [&](const PixelPoint& p) {
    const std::optional<PhotoPoint> at = photo_from_pixel(view.camera, p);
    if (!at) return false;
    const auto [x, y] = io::taken_pixel(view, *at);
    return x >= low.x && x <= high.x && y >= low.y && y <= high.y;
  };
  std::vector<std::int64_t> inside_less_outside(input.mesh.faces.size(), 0);
  std::vector<bool> has_pixels(input.mesh.faces.size(), false);
  for (int y = 0; y < seen.ivm.height; ++y)
    for (int x = 0; x < seen.ivm.width; ++x) {
      const FaceId face = seen.ivm.at(x, y);
      if (face == kNoFace) continue;
      has_pixels[index(face)] = true;
      inside_less_outside[index(face)] += is_inside({x + 0.5, y + 0.5}) ? 1 : -1;
    }
  const auto shows_middle = [&](const Triangle& face) {
    WorldPoint middle{};
    for (const std::uint32_t v : face) {
      const WorldPoint& p = input.mesh.positions[v];
      middle = {middle.x + p.x / 3, middle.y + p.y / 3, middle.z + p.z / 3};
    }
    const CameraPoint c = camera_from_world(view.pose, middle);
    return c.z > 0 && is_inside(pixel_from_camera(view.camera, c));
  };
  for (std::uint32_t f = 0; f < input.mesh.faces.size(); ++f)
    if (seen.classes[f] != visibility::FaceClass::hidden &&
        (has_pixels[f] ? inside_less_outside[f] >= 0 : shows_middle(input.mesh.faces[f])))
      shown[f] = true;
}

}  // namespace

io::FaceRegion faces_shown(const checks::Input& input, std::span<const ViewId> views, const PhotoPoint& low,
                           const PhotoPoint& high) {
  visibility::VisibilityOptions options;
  options.method = visibility::Gpvc{.drawing = visibility::Drawing::native};
  visibility::VisibilityStage stage(input.mesh, options);
  std::vector<bool> shown(input.mesh.faces.size(), false);
  for (const ViewId id : views)
    mark_shown(input, id, stage.classify(input.scene.views[index(id)], id, nullptr), low, high, shown);
  io::FaceRegion region;
  for (std::uint32_t f = 0; f < shown.size(); ++f)
    if (shown[f]) region.ranges.push_back({f, f});
  return region;
}

io::Region region_of(const io::Region& region, const Mesh& mesh) {
  if (mesh.file_positions.empty() || std::holds_alternative<io::FaceRegion>(region)) return region;
  io::FaceRegion listed;
  for (const std::uint32_t f : io::FaceLocator(mesh.file_positions, mesh.faces).faces_in(region))
    listed.ranges.push_back({f, f});
  return listed;
}

io::Region region_of(io::GroundRegion region, const std::string& srs, const checks::Input& input) {
  const Scene& scene = input.scene;
  if (scene.srs.empty() && srs == io::kGeoJsonSystem) return region_of(std::move(region), input.mesh);
  if (scene.srs.empty()) throw RegionError(fmt::format("is in {}, and the scene names no reference system", srs));
  std::vector<WorldPoint> corners;
  for (const auto& [x, y] : region.corners) corners.push_back({x, y, 0});
  try {
    io::transform_points(srs, scene.srs, corners);
  } catch (const Error& error) {
    throw RegionError(fmt::format("cannot be brought to the scene's reference system: {}", error.what()));
  }
  for (std::size_t n = 0; n < corners.size(); ++n)
    region.corners[n] = {corners[n].x - scene.offset.x, corners[n].y - scene.offset.y};
  return region;
}

}  // namespace gpvc::pipeline
