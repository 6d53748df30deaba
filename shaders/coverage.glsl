// The GLSL twin of visibility/raster.h.

const uint kEdgeOn = 0u, kFront = 1u, kBack = 2u;

const double kRoundoff = 1.0LF / 9007199254740992.0LF;     // 2^-53
const double kEdgeOnFactor = 1.0LF / 17592186044416.0LF;  // 512 * 2^-53

struct RasterFace {
  ProjectedVertex vertex[3];
  uint facing;
};

double largest(double a, double b, double c) { return max(max(abs(a), abs(b)), abs(c)); }

RasterFace raster_face(const ProjectedVertex a, const ProjectedVertex b, const ProjectedVertex c) {
  precise double du1 = b.u - a.u, dv1 = b.v - a.v, dz1 = b.z - a.z;
  precise double du2 = c.u - a.u, dv2 = c.v - a.v, dz2 = c.z - a.z;
  precise double determinant = a.u * (dz1 * dv2 - dv1 * dz2) + a.v * (du1 * dz2 - dz1 * du2) +
                               a.z * (dv1 * du2 - du1 * dv2);
  double u = largest(a.u, b.u, c.u), v = largest(a.v, b.v, c.v), z = largest(a.z, b.z, c.z);
  double du = max(abs(du1), abs(du2)), dv = max(abs(dv1), abs(dv2)), dz = max(abs(dz1), abs(dz2));
  precise double margin = kEdgeOnFactor * (u * (v * dz + z * dv) + v * (z * du) + dv * dz * u + du * dz * v);
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
