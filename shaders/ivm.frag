// The item buffer: the index of the face drawn at each pixel.
layout(early_fragment_tests) in;

uniform uint first_face;  // of this draw call
layout(location = 0) out uint face;

void main() { face = first_face + uint(gl_PrimitiveID); }
