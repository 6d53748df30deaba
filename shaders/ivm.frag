// Item buffer: the index of the face drawn at each pixel.
layout(early_fragment_tests) in;

flat in uint face;
layout(location = 0) out uint face_id;

void main() { face_id = face; }
