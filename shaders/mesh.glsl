// The faces of the mesh in the current view, from the vertices that project.comp has projected.
layout(binding = 2) uniform usamplerBuffer projected;  // u, v and z of a vertex, a double a texel
layout(binding = 3) uniform usamplerBuffer corners;    // a vertex index a texel

ProjectedVertex projected_vertex(uint number) {
  int first = int(number) * 3;
  return ProjectedVertex(packDouble2x32(texelFetch(projected, first).rg),
                         packDouble2x32(texelFetch(projected, first + 1).rg),
                         packDouble2x32(texelFetch(projected, first + 2).rg));
}

RasterFace raster_of(uint face) {
  int first = int(face) * 3;
  return raster_face(projected_vertex(texelFetch(corners, first).r),
                     projected_vertex(texelFetch(corners, first + 1).r),
                     projected_vertex(texelFetch(corners, first + 2).r));
}
