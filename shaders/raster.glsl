// Projection with the same arithmetic as visibility/raster/projection.h: only +, - and x on doubles, all `precise`, in
// the same order, so that both give the same bits.

/// A vertex in homogeneous pixel coordinates: pixel = (u / z, v / z), z the depth along the optical axis.
struct ProjectedVertex {
  double u, v, z;
};

/// pose: the rotation, row-major, then the centre. intrinsics: fx, fy, cx, cy.
ProjectedVertex project(const dvec3 world, const double pose[12], const double intrinsics[4]) {
  precise double dx = world.x - pose[9];
  precise double dy = world.y - pose[10];
  precise double dz = world.z - pose[11];
  precise double x = pose[0] * dx + pose[1] * dy + pose[2] * dz;
  precise double y = pose[3] * dx + pose[4] * dy + pose[5] * dz;
  precise double z = pose[6] * dx + pose[7] * dy + pose[8] * dz;
  precise double u = intrinsics[0] * x + intrinsics[2] * z;
  precise double v = intrinsics[1] * y + intrinsics[3] * z;
  return ProjectedVertex(u, v, z);
}
