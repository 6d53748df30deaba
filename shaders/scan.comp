// Scans the faces of one view for the exact correction: the twin of ExactScan, with the same result for every face it
// is sure about. The CPU decides the other faces and the claimed pixels (visibility/classify/exact_scan.cpp). Compiled
// twice: with one invocation a face, which leaves large faces to the second variant (LARGE), with one workgroup a face,
// whose invocations take adjacent pixels of a row.
//
// Certainty rests on error bounds of doubles (r = 2^-53). They hold whether or not the compiler fuses multiplications
// and additions, which only rounds less. Depths in front of the camera lie in [1e-60, 1e60] (ProjectedMesh::moderate),
// so no relevant product overflows or loses bits to underflow; values that overflow behind the camera compare as not
// certain.
layout(local_size_x = 64) in;

layout(std430, binding = 1) buffer Counts {
  uint processed_faces, samples;               // of the faces found full
  uint contested_samples, contested_overflow;  // 64 bits
  uint claim_count, large_count;
};
layout(std430, binding = 2) writeonly buffer Claims { uvec2 claims[]; };  // pixel, face
layout(std430, binding = 3) buffer Large { uint large_faces[]; };         // less first_face

// Counts of the face's samples: stored as its own, stored as another's or nothing, and of the latter those in the
// photo.
uint own = 0u, foreign = 0u, contested = 0u;
bool unsure = false;
double nearest;

// --- the latest stored owner, kept because adjacent pixels mostly have the same one
uint owner_face = kNoFace;
RasterFace owner;
double owner_farthest;

/// Upper bound of the error of each edge value: edge_error() in visibility/raster/exact.cpp.
double edge_error(const RasterFace of, const EdgeValues values, double px, double py) {
  double z = largest(of.vertex[0].z, of.vertex[1].z, of.vertex[2].z);
  double a = largest(values.a[0], values.a[1], values.a[2]), b = largest(values.b[0], values.b[1], values.b[2]);
  double da = kRoundoff * (px * z + a), db = kRoundoff * (py * z + b);
  return 4.0LF * (a * db + b * da) + 8.0LF * kRoundoff * (a * b);
}

/// Depth of the plane at a centre that the face covers, and the bound of its error: depth() in
/// visibility/raster/exact.cpp, where a quotient is off by r of itself. GLSL allows 2.5 ULP = 5 r when the divisor lies
/// in [2^-126, 2^126]: 4 r more, which the additional 16 r here exceed.
bool depth_of(const RasterFace of, const EdgeValues values, double error, out dvec2 depth) {
  double z0 = of.vertex[0].z, dz1 = of.vertex[1].z - z0, dz2 = of.vertex[2].z - z0;
  double s = values.e[0] + values.e[1] + values.e[2];
  double dz = max(abs(dz1), abs(dz2));
  double value = z0 + (dz1 * values.e[1] + dz2 * values.e[2]) / s;
  depth = dvec2(value, dz * (12.0LF * error / s + 32.0LF * kRoundoff) + 2.0LF * kRoundoff * (abs(value) + dz));
  return s > 8.0LF * error && s > 1e-37LF && s < 1e37LF;
}

/// True when the stored owner certainly covers the centre of a pixel and is certainly nearer there.
bool stored_owner_keeps(uint stored, ivec2 pixel) {
  if (stored == kNoFace) return false;
  if (stored != owner_face) {
    owner_face = stored;
    owner = raster_of(stored);
    owner_farthest = max(owner.vertex[0].z, max(owner.vertex[1].z, owner.vertex[2].z));
  }
  if (owner.facing == kEdgeOn) return false;
  double px = double(pixel.x) + 0.5LF, py = double(pixel.y) + 0.5LF;
  EdgeValues there = edge_values(owner, px, py);
  double there_error = edge_error(owner, there, px, py);
  if (!(there.e[0] > there_error && there.e[1] > there_error && there.e[2] > there_error)) return false;
  if (owner_farthest < nearest) return true;
  EdgeValues here = edge_values(raster, px, py);
  dvec2 f, g;
  bool known = depth_of(raster, here, edge_error(raster, here, px, py), f);
  known = depth_of(owner, there, there_error, g) && known;
  return known && g.x + 2.0LF * (f.y + g.y) < f.x;
}

/// Keeps counting beyond the capacity, so that the CPU learns how much room is needed, but stops before the counter
/// wraps.
void claim(ivec2 pixel) {
  uint slot = atomicAdd(claim_count, 1u);
  if (slot < uint(claims.length())) {
    claims[slot] = uvec2(uint(pixel.y) * uint(size.x) + uint(pixel.x), face);
  } else if (slot > 0x40000000u) {
    atomicAdd(claim_count, 0xFFFFFFFFu);
  }
}

void scan_sample(ivec2 pixel) {
  uint stored = stored_at(pixel);
  bool in_image = in_photo(pixel);
  if (in_image && stored == face) {
    ++own;
    return;
  }
  ++foreign;
  if (!in_image) return;
  ++contested;
  if (!stored_owner_keeps(stored, pixel)) claim(pixel);
}

/// 1 when the centre is certainly covered, -1 when it certainly is not, 0 otherwise. The tolerance of the rows is above
/// the error of the values at any pixel of the bounding box.
int side_of_edges(ivec2 pixel) {
  EdgeValues values = values_at(pixel);
  if (values.e[0] > tolerance && values.e[1] > tolerance && values.e[2] > tolerance) return 1;
  if (values.e[0] < -tolerance || values.e[1] < -tolerance || values.e[2] < -tolerance) return -1;
  return 0;
}

/// Scans the pixels of the bounding box that belong to invocation `lane` of `lanes`, until one is not certain.
void scan_rows(ivec2 low, ivec2 high, int lane, int lanes) {
  nearest = min(raster.vertex[0].z, min(raster.vertex[1].z, raster.vertex[2].z));
  prepare_rows(low, high);
  for (int y = low.y; y < high.y; ++y) {
    Row row = row_of(low, high, y);
    for (int x = row.first + lane; x < row.last; x += lanes) {
      ivec2 pixel = ivec2(x, y);
      int side = row.certain ? 1 : side_of_edges(pixel);
      if (side == 0) {
        unsure = true;
        return;
      }
      if (side > 0) scan_sample(pixel);
    }
  }
}

/// The code that follows from the counts. \pre the face may reach the frame
uint code_of_face() {
  if (unsure) return kUnsure;
  if (raster.facing == kBack) return kHidden;
  if (own + foreign == 0u) return kNoCentre;
  if (own == 0u) return kUnstored;
  return foreign == 0u && inside_frame() ? kFull : kPartial;
}

/// Sums of the workgroup.
shared uint full_faces, full_samples, contested_sum;

void start_counts() {
  if (gl_LocalInvocationID.x == 0u) full_faces = full_samples = contested_sum = 0u;
  barrier();
}

/// One invocation adds the sums to the totals, because atomics on one address are serialized.
void add_counts() {
  barrier();
  if (gl_LocalInvocationID.x != 0u) return;
  if (full_faces != 0u) atomicAdd(processed_faces, full_faces);
  if (full_samples != 0u) atomicAdd(samples, full_samples);
  if (contested_sum == 0u) return;
  uint before = atomicAdd(contested_samples, contested_sum);
  if (before + contested_sum < before) atomicAdd(contested_overflow, 1u);
}

#ifdef LARGE

shared uint group_own, group_foreign, group_contested, group_unsure;

void scan_large_face(uint number) {
  uint lane = gl_LocalInvocationID.x;
  if (lane == 0u) group_own = group_foreign = group_contested = group_unsure = 0u;
  barrier();
  face = first_face + number;
  raster = raster_of(face);
  own = foreign = contested = 0u;
  unsure = false;
  ivec2 low, high;
  pixel_bounds(low, high);
  scan_rows(low, high, int(lane), 64);
  if (own != 0u) atomicAdd(group_own, own);
  if (foreign != 0u) atomicAdd(group_foreign, foreign);
  if (contested != 0u) atomicAdd(group_contested, contested);
  if (unsure) atomicOr(group_unsure, 1u);
  barrier();
  if (lane == 0u) {
    own = group_own;
    foreign = group_foreign;
    unsure = group_unsure != 0u;
    uint code = code_of_face();
    if (code == kFull) {
      ++full_faces;
      full_samples += own;
    }
    atomicOr(codes[number / 4u], code << (8u * (number % 4u)));
    if (code != kUnsure && group_contested != 0u) {
      uint before = atomicAdd(contested_samples, group_contested);
      if (before + group_contested < before) atomicAdd(contested_overflow, 1u);
    }
  }
  barrier();
}

void main() {
  start_counts();
  for (uint i = gl_WorkGroupID.x; i < large_count; i += gl_NumWorkGroups.x) scan_large_face(large_faces[i]);
  add_counts();
}

#else

uint scan_face(uint number) {
  face = first_face + number;
  raster = raster_of(face);
  if (raster.facing == kEdgeOn || misses_frame()) return kHidden;
  ivec2 low, high;
  pixel_bounds(low, high);
  ivec2 extent = max(high - low, ivec2(0));
  if (uint(extent.x) * uint(extent.y) >= kLargeFace) {
    large_faces[atomicAdd(large_count, 1u)] = number;
    return kHidden;  // the LARGE variant overwrites this
  }
  if (extent.x > 0 && extent.y > 0) scan_rows(low, high, 0, 1);
  return code_of_face();
}

void main() {
  start_counts();
  uint code = kHidden;
  if (gl_GlobalInvocationID.x < face_count) code = scan_face(gl_GlobalInvocationID.x);
  if (code == kFull) {
    atomicAdd(full_faces, 1u);
    atomicAdd(full_samples, own);
  }
  if (code != kUnsure && contested != 0u) atomicAdd(contested_sum, contested);
  store_code(code);
  add_counts();
}

#endif
