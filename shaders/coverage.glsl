// The GLSL twin of visibility/raster/raster.h: the same operations in the same order.

const uint kEdgeOn = 0u, kFront = 1u, kBack = 2u;

const double kRoundoff = 1.0LF / 9007199254740992.0LF;  // 2^-53

uniform dvec2 projection_rounding;  // u_per_z, z_per_u

struct RasterFace {
  ProjectedVertex vertex[3];
  uint facing;
};

double largest(double a, double b, double c) { return max(max(abs(a), abs(b)), abs(c)); }

double cofactors(const ProjectedVertex p, const ProjectedVertex q) {
  precise double sum = abs(p.v * q.z - p.z * q.v) + abs(p.z * q.u - p.u * q.z) +
                       abs(p.u * q.v - p.v * q.u) * projection_rounding.y;
  return sum;
}

double size_of(const ProjectedVertex p) {
  precise double sum = abs(p.u) + abs(p.v) + projection_rounding.x * abs(p.z);
  return sum;
}

RasterFace raster_face(ProjectedVertex a, ProjectedVertex b, ProjectedVertex c) {
  double za = abs(a.z), zb = abs(b.z), zc = abs(c.z);
  ProjectedVertex given_a = a, given_b = b, given_c = c;
  if (zb < za && zb <= zc) {
    a = given_b;
    b = given_c;
    c = given_a;
  } else if (zc < za && zc < zb) {
    a = given_c;
    b = given_a;
    c = given_b;
  }
  precise double du1 = b.u - a.u, dv1 = b.v - a.v, dz1 = b.z - a.z;
  precise double du2 = c.u - a.u, dv2 = c.v - a.v, dz2 = c.z - a.z;
  precise double pu1 = dz1 * dv2, pu2 = dv1 * dz2, pv1 = du1 * dz2, pv2 = dz1 * du2;
  precise double pz1 = dv1 * du2, pz2 = du1 * dv2;
  precise double determinant = a.u * (pu1 - pu2) + a.v * (pv1 - pv2) + a.z * (pz1 - pz2);
  precise double input_error =
      size_of(a) * cofactors(b, c) + size_of(b) * cofactors(c, a) + size_of(c) * cofactors(a, b);
  precise double terms = abs(a.u) * (abs(pu1) + abs(pu2)) + abs(a.v) * (abs(pv1) + abs(pv2)) +
                         abs(a.z) * (abs(pz1) + abs(pz2));
  precise double margin = 16.0LF * kRoundoff * (input_error + terms);
  RasterFace face;
  face.vertex[0] = a;
  face.vertex[1] = b;
  face.vertex[2] = c;
  face.facing = kEdgeOn;
  if (determinant > margin) {
    face.facing = kFront;
  } else if (determinant < -margin) {
    face.facing = kBack;
    face.vertex[1] = c;
    face.vertex[2] = b;
  }
  return face;
}

struct EdgeValues {
  double e[3], a[3], b[3];
};

EdgeValues edge_values(const RasterFace face, double px, double py) {
  EdgeValues values;
  for (int k = 0; k < 3; ++k) {
    precise double a = face.vertex[k].u - px * face.vertex[k].z;
    precise double b = face.vertex[k].v - py * face.vertex[k].z;
    values.a[k] = a;
    values.b[k] = b;
  }
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    precise double e = values.a[j] * values.b[i] - values.a[i] * values.b[j];
    values.e[k] = e;
  }
  return values;
}

dvec2 edge_gradient(const RasterFace face, const EdgeValues values, int k) {
  const int i = (k + 1) % 3, j = (k + 2) % 3;
  double zi = face.vertex[i].z, zj = face.vertex[j].z;
  precise double x = zi * values.b[j] - zj * values.b[i];
  precise double y = zj * values.a[i] - zi * values.a[j];
  return dvec2(x, y);
}

bool covers(const RasterFace face, const EdgeValues values) {
  for (int k = 0; k < 3; ++k) {
    if (values.e[k] < 0.0LF) return false;
    if (values.e[k] == 0.0LF) {
      dvec2 inside = edge_gradient(face, values, k);
      if (!(inside.x > 0.0LF || (inside.x == 0.0LF && inside.y > 0.0LF))) return false;
    }
  }
  return true;
}

bool crossed_by_edge(const RasterFace face, const EdgeValues values) {
  for (int k = 0; k < 3; ++k) {
    dvec2 gradient = edge_gradient(face, values, k);
    precise double reach = 0.5LF * (abs(gradient.x) + abs(gradient.y));
    if (abs(values.e[k]) <= reach) return true;
  }
  return false;
}

/// z0 + n / s.
struct PlaneDepth {
  double z0, n, s;
};

PlaneDepth plane_depth(const RasterFace face, const EdgeValues values) {
  precise double n = (face.vertex[1].z - face.vertex[0].z) * values.e[1] +
                     (face.vertex[2].z - face.vertex[0].z) * values.e[2];
  precise double s = values.e[0] + values.e[1] + values.e[2];
  return PlaneDepth(face.vertex[0].z, n, s);
}

double compare_depth(const PlaneDepth f, const PlaneDepth g) {
  precise double order = (f.z0 - g.z0) * (f.s * g.s) + (f.n * g.s - g.n * f.s);
  return order;
}
