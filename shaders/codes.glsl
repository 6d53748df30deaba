// The result of scanning a face, one byte a face: visibility/classify/face_scan.h.
const uint kHidden = 0u, kPartial = 1u, kFull = 2u, kNoCentre = 3u, kUnstored = 4u, kUnsure = 5u;

layout(std430, binding = 0) buffer Codes { uint codes[]; };  // codes[0]: first_face and the next three
uniform uint first_face, face_count;

// Four codes a word.
shared uint packed_codes[16];

/// Writes the codes of the 64 faces of the workgroup. All its invocations must call it.
void store_code(uint code) {
  uint lane = gl_LocalInvocationID.x;
  if (lane < 16u) packed_codes[lane] = 0u;
  barrier();
  atomicOr(packed_codes[lane / 4u], code << (8u * (lane % 4u)));
  barrier();
  uint word = gl_WorkGroupID.x * 16u + lane;
  if (lane < 16u && word < (face_count + 3u) / 4u) codes[word] = packed_codes[lane];
}
