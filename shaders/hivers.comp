// Classification of the faces of one view, an invocation a face: LPCC (algorithm 1) on every look-up, VES or
// HIVERS (algorithm 2) as the order of look-ups. The twin of visibility/face_sampler.cpp and visibility/lpcc.h.
layout(local_size_x = 64) in;

layout(binding = 0) uniform usampler2D ivm;
layout(binding = 1) uniform usampler2D photo_mask;
layout(binding = 2) uniform usamplerBuffer positions;  // a double a texel
layout(binding = 3) uniform usamplerBuffer corners;    // a vertex index a texel
layout(std430, binding = 0) readonly buffer CandidateFaces { uint candidate_faces[]; };
layout(std430, binding = 1) writeonly buffer Codes { uint codes[]; };
layout(std430, binding = 2) buffer Counts { uint processed_faces, samples, corrected_samples; };

uniform double pose[12];
uniform double intrinsics[4];
uniform ivec2 size;
uniform uint first_face, face_count;  // codes[0] belongs to first_face
uniform int sampling;                 // 0 HIVERS, 1 VES, 2 dense
uniform bool correction;              // LPCC

// What becomes of a face.
const uint kHidden = 0u, kPartial = 1u, kFull = 2u, kNoCentre = 3u;

ProjectedVertex projected_vertex(uint number) {
  int first = int(number) * 3;
  dvec3 world = dvec3(packDouble2x32(texelFetch(positions, first).rg),
                      packDouble2x32(texelFetch(positions, first + 1).rg),
                      packDouble2x32(texelFetch(positions, first + 2).rg));
  return project(world, pose, intrinsics);
}

RasterFace raster_of(uint face) {
  int first = int(face) * 3;
  return raster_face(projected_vertex(texelFetch(corners, first).r),
                     projected_vertex(texelFetch(corners, first + 1).r),
                     projected_vertex(texelFetch(corners, first + 2).r));
}

// --- the face at hand
uint face;
RasterFace raster;
uint looked_at = 0u, restored = 0u;

EdgeValues values_at(ivec2 pixel) {
  return edge_values(raster, double(pixel.x) + 0.5LF, double(pixel.y) + 0.5LF);
}

bool lpcc_restores(ivec2 pixel, uint stored) {
  EdgeValues values = values_at(pixel);
  if (!crossed_by_edge(raster, values)) return false;
  if (stored == kNoFace) return true;
  RasterFace other = raster_of(stored);
  if (other.facing == kEdgeOn) return true;
  EdgeValues other_values = edge_values(other, double(pixel.x) + 0.5LF, double(pixel.y) + 0.5LF);
  if (!covers(other, other_values)) return true;
  double order = compare_depth(plane_depth(raster, values), plane_depth(other, other_values));
  return order < 0.0LF || (order == 0.0LF && face < stored);
}

bool sees(ivec2 pixel) {
  ++looked_at;
  if (!in_photo(pixel)) return false;
  uint stored = texelFetch(ivm, pixel, 0).r;
  if (stored == face) return true;
  if (!correction || !lpcc_restores(pixel, stored)) return false;
  ++restored;
  return true;
}

bool inside_frame() {
  for (int k = 0; k < 3; ++k) {
    ProjectedVertex v = raster.vertex[k];
    precise double width = double(size.x) * v.z, height = double(size.y) * v.z;
    if (!(v.z > 0.0LF && v.u >= 0.0LF && v.v >= 0.0LF && v.u <= width && v.v <= height)) return false;
  }
  return true;
}

bool misses_frame() {
  bvec4 beyond = bvec4(true);
  bool behind = true;
  for (int k = 0; k < 3; ++k) {
    ProjectedVertex v = raster.vertex[k];
    precise double width = double(size.x) * v.z, height = double(size.y) * v.z;
    behind = behind && !(v.z > 0.0LF);
    beyond = bvec4(beyond.x && v.z > 0.0LF && v.u < 0.0LF, beyond.y && v.z > 0.0LF && v.v < 0.0LF,
                   beyond.z && v.z > 0.0LF && v.u > width, beyond.w && v.z > 0.0LF && v.v > height);
  }
  return behind || any(beyond);
}

/// Pixels whose centres may be covered, `high` excluded; a double quotient is off by far less than 2^-20 px.
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

// --- rows
struct Row {
  bool certain;     // covered are exactly the pixels first .. last - 1
  int first, last;  // else every pixel between is to be asked
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
    // The first pixel on the far side of the edge line, then confirmed on both of its sides.
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

// --- sampling
bool any_seen = false, all_seen = true;

/// False when nothing can change the class any more.
bool look(ivec2 pixel) {
  if (sees(pixel)) {
    any_seen = true;
  } else {
    all_seen = false;
  }
  return all_seen || !any_seen;
}

const int kEverySample = 0, kEnds = 1, kBetween = 2, kEdges = 3;

/// Looks at the samples of a row that `part` names. Returns false to stop; `covered` tells whether there was
/// any sample at all.
bool look_at_row(Row row, int y, int part, inout bool covered) {
  int first = row.first, last = row.last;
  if (row.certain && part == kBetween) {
    ++first;
    --last;
  }
  for (int x = first; x < last; ++x) {
    ivec2 pixel = ivec2(x, y);
    if (!row.certain && !covers(raster, values_at(pixel))) continue;
    covered = true;
    if (row.certain && part == kEnds && x > row.first && x < row.last - 1) x = row.last - 1;
    pixel = ivec2(x, y);
    if (part == kEdges && !crossed_by_edge(raster, values_at(pixel))) {
      // Does not count for VES, but the face may be seen here alone.
      if (!any_seen) any_seen = sees(pixel);
      if (any_seen && !all_seen) return false;
      continue;
    }
    if (!look(pixel)) return false;
  }
  return true;
}

/// All rows, until the class is settled.
bool look_at_rows(ivec2 low, ivec2 high, int part, inout bool covered) {
  for (int y = low.y; y < high.y; ++y)
    if (!look_at_row(row_of(low, high, y), y, part, covered)) return false;
  return true;
}

/// On the unbounded grid, for a face without a centre in the frame.
bool covers_a_pixel() {
  for (int k = 0; k < 3; ++k)
    if (!(raster.vertex[k].z > 0.0LF)) return true;
  dvec2 least = dvec2(4194304.0LF), most = dvec2(-4194304.0LF);
  for (int k = 0; k < 3; ++k) {
    dvec2 p = dvec2(raster.vertex[k].u / raster.vertex[k].z, raster.vertex[k].v / raster.vertex[k].z);
    least = min(least, p);
    most = max(most, p);
  }
  ivec2 low = ivec2(floor(max(least, dvec2(-4194304.0LF)))), high = ivec2(ceil(min(most, dvec2(4194304.0LF))));
  for (int y = low.y; y < high.y; ++y)
    for (int x = low.x; x < high.x; ++x)
      if (covers(raster, values_at(ivec2(x, y)))) return true;
  return false;
}

uint classify(bool candidate) {
  if (raster.facing != kFront || misses_frame()) return kHidden;
  ivec2 low, high;
  pixel_bounds(low, high);
  bool covered = false;
  if (all(lessThan(low, high))) {
    prepare_rows(low, high);
    if (!candidate) {
      // Only whether there is a sample matters.
      for (int y = low.y; y < high.y && !covered; ++y) {
        Row row = row_of(low, high, y);
        for (int x = row.first; x < row.last && !covered; ++x)
          covered = row.certain || covers(raster, values_at(ivec2(x, y)));
      }
    } else if (sampling == 1) {
      look_at_rows(low, high, kEdges, covered);
    } else {
      bool settled = !look_at_rows(low, high, sampling == 2 ? kEverySample : kEnds, covered);
      if (!settled && sampling != 2) look_at_rows(low, high, kBetween, covered);
    }
  }
  if (!covered) return inside_frame() || !covers_a_pixel() ? kNoCentre : kHidden;
  if (!candidate || !any_seen) return kHidden;
  return all_seen && inside_frame() ? kFull : kPartial;
}

void main() {
  if (gl_GlobalInvocationID.x >= face_count) return;
  face = first_face + gl_GlobalInvocationID.x;
  bool candidate = (candidate_faces[face / 32u] >> (face % 32u) & 1u) != 0u;
  raster = raster_of(face);
  codes[gl_GlobalInvocationID.x] = classify(candidate);
  if (looked_at != 0u) {
    atomicAdd(processed_faces, 1u);
    atomicAdd(samples, looked_at);
    atomicAdd(corrected_samples, restored);
  }
}
