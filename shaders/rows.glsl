// The rows of pixels that a face covers: the twin of SpanWalker in visibility/raster/raster.h. raster.cpp derives the
// tolerance.

// --- the current face
uint face;
RasterFace raster;

EdgeValues values_at(ivec2 pixel) {
  return edge_values(raster, double(pixel.x) + 0.5LF, double(pixel.y) + 0.5LF);
}

bool inside_frame() {
  for (int k = 0; k < 3; ++k) {
    ProjectedVertex v = raster.vertex[k];
    precise double width = double(size.x) * v.z, height = double(size.y) * v.z;
    if (!(v.z > 0.0LF && v.u >= 0.0LF && v.v >= 0.0LF && v.u <= width && v.v <= height)) return false;
  }
  return true;
}

/// The twin of misses_frame() in visibility/raster/raster.h.
bool misses_frame() {
  bvec4 beyond = bvec4(true);
  bool behind = true;
  for (int k = 0; k < 3; ++k) {
    ProjectedVertex v = raster.vertex[k];
    precise double width = double(size.x) * v.z, height = double(size.y) * v.z;
    behind = behind && !(v.z > 0.0LF);
    beyond = bvec4(beyond.x && v.u < 0.0LF, beyond.y && v.v < 0.0LF, beyond.z && v.u > width, beyond.w && v.v > height);
  }
  return behind || any(beyond);
}

/// Pixels whose centres may be covered, from `low` up to `high`; a double quotient is off by far less than 2^-20 px.
void pixel_bounds(out ivec2 low, out ivec2 high) {
  low = ivec2(0);
  high = size;
  if (!(raster.vertex[0].z > 0.0LF && raster.vertex[1].z > 0.0LF && raster.vertex[2].z > 0.0LF)) return;
  const double margin = 0.5LF + 1.0LF / 1048576.0LF;
  dvec2 least = dvec2(size) + 2.0LF, most = dvec2(-2.0LF);
  for (int k = 0; k < 3; ++k) {
    dvec2 p = dvec2(raster.vertex[k].u / raster.vertex[k].z, raster.vertex[k].v / raster.vertex[k].z);
    least = min(least, p);
    most = max(most, p);
  }
  low = ivec2(ceil(clamp(least - margin, dvec2(0.0LF), dvec2(size))));
  high = ivec2(floor(clamp(most + margin, dvec2(0.0LF), dvec2(size))));
}

/// Bounding-box area, in pixels, from which a face is split over a workgroup (scan.comp: at least 8 pixels for each of
/// its 64 invocations) or left to the CPU (hivers.comp), so that no invocation runs long after the others are done.
const uint kLargeFace = 512u;

// --- rows
struct Row {
  bool certain;     // exactly the pixels first .. last - 1 are covered
  int first, last;  // otherwise each of them has to be tested
};

dvec3 line[3];  // e = x dx + y dy + c from the centre of pixel `low`
double tolerance;

void prepare_rows(ivec2 low, ivec2 high) {
  EdgeValues values = values_at(low);
  double z = largest(raster.vertex[0].z, raster.vertex[1].z, raster.vertex[2].z);
  for (int k = 0; k < 3; ++k) line[k] = dvec3(edge_gradient(raster, values, k), values.e[k]);
  double a = largest(values.a[0], values.a[1], values.a[2]) + double(high.x - low.x) * z;
  double b = largest(values.b[0], values.b[1], values.b[2]) + double(high.y - low.y) * z;
  double da = kRoundoff * (double(high.x + 1) * z + a), db = kRoundoff * (double(high.y + 1) * z + b);
  tolerance = 8.0LF * (a * db + b * da) + 64.0LF * kRoundoff * (a * b);
}

Row row_of(ivec2 low, ivec2 high, int y) {
  int width = high.x - low.x;
  Row row = Row(true, 0, width);
  for (int k = 0; k < 3; ++k) {
    double x = line[k].x, c = line[k].y * double(y - low.y) + line[k].z;
    if (x == 0.0LF) {
      if (!(abs(c) > tolerance)) row.certain = false;
      if (c < 0.0LF) row.last = 0;
      continue;
    }
    // The first pixel on the far side of the edge's line, confirmed by the values at that pixel and at the one before.
    int split = int(ceil(clamp(-c / x, 0.0LF, double(width))));
    double sign = x > 0.0LF ? 1.0LF : -1.0LF;
    if (split < width && !(sign * (x * double(split) + c) > tolerance)) row.certain = false;
    if (split > 0 && !(sign * (x * double(split - 1) + c) < -tolerance)) row.certain = false;
    if (x > 0.0LF) {
      row.first = max(row.first, split);
    } else {
      row.last = min(row.last, split);
    }
  }
  return row.certain ? Row(true, low.x + row.first, low.x + row.last) : Row(false, low.x, high.x);
}
