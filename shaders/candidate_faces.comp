// Lazy projection: sets a bit for every face that owns a pixel of the IVM inside the photo.
layout(local_size_x = 16, local_size_y = 16) in;

layout(std430, binding = 0) buffer CandidateFaces { uint candidate_faces[]; };

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(pixel, size)) || !in_photo(pixel)) return;
  uint face = stored_at(pixel);
  if (face == kNoFace) return;
  // Adjacent pixels mostly belong to the same face: only the first of a run sets the bit.
  if (pixel.x > 0 && in_photo(pixel - ivec2(1, 0)) && stored_at(pixel - ivec2(1, 0)) == face) return;
  atomicOr(candidate_faces[face / 32u], 1u << (face % 32u));
}
