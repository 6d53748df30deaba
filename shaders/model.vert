// A textured model. Clip coordinates are made on the CPU, in double, relative to the camera; w = z, so the rasterizer
// clips at the camera plane.
layout(location = 0) in vec3 projected;  // x and y in clip coordinates, z in front of the camera
layout(location = 1) in vec2 texcoord;

uniform float near_m;  // depth is near_m / z, as for the IVM

out vec2 uv;

void main() {
  uv = texcoord;
  gl_Position = vec4(projected.xy, near_m, projected.z);
}
