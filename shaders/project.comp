// Projects the vertices, once per view: the twin of visibility/raster/projection.h. Reads 24 bytes and writes 24 per
// vertex, coalesced.
layout(local_size_x = 64) in;

layout(binding = 2) uniform usamplerBuffer positions;  // a double a texel
layout(std430, binding = 0) writeonly buffer Projected { double projected[]; };

uniform double pose[12];
uniform double intrinsics[4];
uniform uint first_vertex, vertex_count;  // projected[0] belongs to first_vertex

void main() {
  uint at = gl_GlobalInvocationID.x;
  if (at >= vertex_count) return;
  int first = int(first_vertex + at) * 3;
  dvec3 world = dvec3(packDouble2x32(texelFetch(positions, first).rg),
                      packDouble2x32(texelFetch(positions, first + 1).rg),
                      packDouble2x32(texelFetch(positions, first + 2).rg));
  ProjectedVertex p = project(world, pose, intrinsics);
  projected[3u * at] = p.u;
  projected[3u * at + 1u] = p.v;
  projected[3u * at + 2u] = p.z;
}
