// Classifies the faces of one view for coverage corrections `off` and `paper`, one invocation a face: LPCC (algorithm
// 1) on every look-up, VES or HIVERS (algorithm 2) as the order of look-ups. The twin of visibility/classify/
// face_sampler.cpp and lpcc.h.
layout(local_size_x = 64) in;

layout(std430, binding = 1) readonly buffer CandidateFaces { uint candidate_faces[]; };
layout(std430, binding = 2) buffer Counts { uint processed_faces, samples, corrected_samples; };

uniform int sampling;     // 0 HIVERS, 1 VES, 2 dense
uniform bool correction;  // LPCC

uint looked_at = 0u, restored = 0u;

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
  uint stored = stored_at(pixel);
  if (stored == face) return true;
  if (!correction || !lpcc_restores(pixel, stored)) return false;
  ++restored;
  return true;
}

// --- sampling
bool any_seen = false, all_seen = true;

/// False once no further sample can change the class.
bool look(ivec2 pixel) {
  if (sees(pixel)) {
    any_seen = true;
  } else {
    all_seen = false;
  }
  return all_seen || !any_seen;
}

const int kEverySample = 0, kEnds = 1, kBetween = 2, kEdges = 3;

/// Looks at the samples of a row that `part` selects. Returns false to stop; sets `covered` when the row has any
/// sample.
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
      // VES does not test inner samples, but the face may be seen only here, and then is partial, not hidden.
      if (!any_seen) any_seen = sees(pixel);
      if (any_seen && !all_seen) return false;
      continue;
    }
    if (!look(pixel)) return false;
  }
  return true;
}

/// All rows, until the class is known.
bool look_at_rows(ivec2 low, ivec2 high, int part, inout bool covered) {
  for (int y = low.y; y < high.y; ++y)
    if (!look_at_row(row_of(low, high, y), y, part, covered)) return false;
  return true;
}

uint classify(bool candidate) {
  if (raster.facing != kFront || misses_frame()) return kHidden;
  ivec2 low, high;
  pixel_bounds(low, high);
  bool covered = false;
  if (all(lessThan(low, high))) {
    prepare_rows(low, high);
    ivec2 extent = high - low;
    if (candidate && uint(extent.x) * uint(extent.y) >= kLargeFace) return kUnsure;
    if (!candidate) {
      // A face that owns no pixel is hidden, or has no pixel centre: find out which.
      for (int y = low.y; y < high.y && !covered; ++y) {
        Row row = row_of(low, high, y);
        for (int x = row.first; x < row.last && !covered; ++x)
          covered = row.certain || covers(raster, values_at(ivec2(x, y)));
      }
    } else if (sampling == 1) {
      look_at_rows(low, high, kEdges, covered);
    } else {
      bool known = !look_at_rows(low, high, sampling == 2 ? kEverySample : kEnds, covered);
      if (!known && sampling != 2) look_at_rows(low, high, kBetween, covered);
    }
  }
  if (!covered) return kNoCentre;
  if (!candidate || !any_seen) return kHidden;
  return all_seen && inside_frame() ? kFull : kPartial;
}

// Sums of the workgroup: one invocation adds them to the totals, because atomics on one address are serialized.
shared uint group_faces, group_samples, group_corrected;

void main() {
  if (gl_LocalInvocationID.x == 0u) group_faces = group_samples = group_corrected = 0u;
  uint code = kHidden;
  if (gl_GlobalInvocationID.x < face_count) {
    face = first_face + gl_GlobalInvocationID.x;
    raster = raster_of(face);
    code = classify((candidate_faces[face / 32u] >> (face % 32u) & 1u) != 0u);
  }
  store_code(code);
  if (looked_at != 0u) {
    atomicAdd(group_faces, 1u);
    atomicAdd(group_samples, looked_at);
    atomicAdd(group_corrected, restored);
  }
  barrier();
  if (gl_LocalInvocationID.x != 0u || group_faces == 0u) return;
  atomicAdd(processed_faces, group_faces);
  atomicAdd(samples, group_samples);
  atomicAdd(corrected_samples, group_corrected);
}
