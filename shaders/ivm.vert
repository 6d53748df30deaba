// Shader-based projection (section 3.1), from world to clip coordinates. Deviation from formula 12: w = z, not 1, so
// that the rasterizer clips at the camera plane. Depth in clip space is linear in z: the constant N for APC (formula 5,
// depth = N / z), both terms for SPC (formula 1).
layout(location = 0) in dvec3 world;

uniform double pose[12];
uniform double intrinsics[4];
uniform dvec2 tile_origin;        // pixel where the viewport begins
uniform dvec2 clip_from_pixel;    // 2 / viewport size
uniform dvec2 clip_from_depth;    // z_clip = x z + y, see depth_mapping.cpp

void main() {
  ProjectedVertex p = project(world, pose, intrinsics);
  double x = (p.u - tile_origin.x * p.z) * clip_from_pixel.x - p.z;
  double y = (p.v - tile_origin.y * p.z) * clip_from_pixel.y - p.z;
  gl_Position = vec4(float(x), float(y), float(clip_from_depth.x * p.z + clip_from_depth.y), float(p.z));
}
