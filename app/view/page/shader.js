// How faces are drawn. A face's number follows from its corners' (gl_VertexID / 3), and what is known of faces lies in textures.

export const kWide = 4096; // values of a row of such a texture

export const vertexShader = `
precision highp float;
precision highp int;
uniform mat4 modelViewMatrix, projectionMatrix;
in vec3 position;
in vec2 uv;
out vec2 at;
out vec3 corner, eye;
flat out int face;
void main() {
  face = gl_VertexID / 3;
  int i = gl_VertexID - 3 * face;
  corner = vec3(i == 0, i == 1, i == 2);
  at = uv;
  vec4 p = modelViewMatrix * vec4(position, 1.0);
  eye = p.xyz;
  gl_Position = projectionMatrix * p;
}`;

export const fragmentShader = `
precision highp float;
precision highp int;
precision highp usampler2D;
in vec2 at;
in vec3 corner, eye;
flat in int face;
out vec4 color;
uniform sampler2D page;
uniform highp sampler2D values;
uniform usampler2D marks, seams;
uniform bool textured, numbers, showsSeams;
uniform int mode;            // 0: the texture; 1: values from low to high; 2: values as kinds; 3: tags
uniform float low, high, strength;

ivec2 place() { return ivec2(face % ${kWide}, face / ${kWide}); }

// Dark blue to yellow (a fit to viridis by polynomials of its published table), even in lightness.
vec3 ramp(float t) {
  const vec3 a = vec3(0.267, 0.005, 0.329), b = vec3(0.128, 0.567, 0.551), c = vec3(0.993, 0.906, 0.144);
  return t < 0.5 ? mix(a, b, 2.0 * t) : mix(b, c, 2.0 * t - 1.0);
}
// Hues far from each other for neighbouring numbers.
vec3 kind(float n) {
  float hue = fract(n * 0.61803398875), light = 0.55 + 0.25 * fract(n * 0.7548776662);
  return clamp(abs(fract(hue + vec3(0.0, 2.0, 1.0) / 3.0) * 6.0 - 3.0) - 1.0, 0.0, 1.0) * (1.0 - light * 0.4) + light * 0.3;
}
// As view.css has them.
vec3 tag(float n) {
  return n < 0.5 ? vec3(0.18, 0.49, 0.31) : n < 1.5 ? vec3(0.90, 0.72, 0.20) : n < 2.5 ? vec3(0.80, 0.27, 0.23) : vec3(0.45, 0.30, 0.65);
}
void main() {
  if (numbers) {
    uint n = uint(face + 1);
    color = vec4(float(n & 255u), float((n >> 8) & 255u), float((n >> 16) & 255u), float(n >> 24)) / 255.0;
    return;
  }
  vec3 normal = normalize(cross(dFdx(eye), dFdy(eye)));
  vec3 shown = textured ? texture(page, at).rgb : vec3(0.35 + 0.4 * abs(normal.z));
  if (mode > 0) {
    float value = texelFetch(values, place(), 0).r;
    bool known = value == value;
    vec3 tint = !known ? vec3(0.5) : mode == 1 ? ramp(clamp((value - low) / (high - low), 0.0, 1.0)) : mode == 2 ? kind(value) : tag(value);
    float grey = dot(shown, vec3(0.299, 0.587, 0.114));
    shown = mix(shown, tint * (0.7 + 0.4 * grey), strength);
  }
  uint mark = texelFetch(marks, place(), 0).r;
  float stripe = fract((gl_FragCoord.x + gl_FragCoord.y) / 12.0);
  if ((mark & 1u) != 0u) shown = mix(shown, vec3(1.0, 0.5, 0.0), 0.5);
  if ((mark & 2u) != 0u && stripe < 0.5) shown = vec3(0.1);
  if ((mark & 4u) != 0u) shown = mix(shown, vec3(0.0, 0.8, 1.0), 0.6);
  if (showsSeams) {
    uint seam = texelFetch(seams, place(), 0).r;
    // The edge from corner i to the next lies across corner i + 2.
    vec3 width = fwidth(corner) * 1.2;
    bvec3 near = lessThan(corner, width);
    if (((seam & 1u) != 0u && near.z) || ((seam & 2u) != 0u && near.x) || ((seam & 4u) != 0u && near.y))
      shown = vec3(1.0, 0.0, 1.0);
  }
  color = vec4(shown, 1.0);
}`;

// CIEDE2000 of two sRGB colours (Sharma, Wu, Dalal 2005).
export const colorDifference = `
vec3 lab(vec3 rgb) {
  vec3 l = mix(rgb / 12.92, pow((rgb + 0.055) / 1.055, vec3(2.4)), step(0.04045, rgb));
  vec3 xyz = vec3(dot(l, vec3(0.4124564, 0.3575761, 0.1804375)), dot(l, vec3(0.2126729, 0.7151522, 0.0721750)),
                  dot(l, vec3(0.0193339, 0.1191920, 0.9503041))) / vec3(0.95047, 1.0, 1.08883);
  vec3 f = mix(7.787037 * xyz + 16.0 / 116.0, pow(xyz, vec3(1.0 / 3.0)), step(0.008856, xyz));
  return vec3(116.0 * f.y - 16.0, 500.0 * (f.x - f.y), 200.0 * (f.y - f.z));
}
float difference(vec3 first, vec3 second) {
  const float pi = 3.14159265359;
  vec3 p = lab(first), q = lab(second);
  float c7 = pow((length(p.yz) + length(q.yz)) / 2.0, 7.0), g = 0.5 * (1.0 - sqrt(c7 / (c7 + 6103515625.0)));
  p.y *= 1.0 + g, q.y *= 1.0 + g;
  float c1 = length(p.yz), c2 = length(q.yz), h1 = c1 > 0.0 ? atan(p.z, p.y) : 0.0, h2 = c2 > 0.0 ? atan(q.z, q.y) : 0.0;
  if (h1 < 0.0) h1 += 2.0 * pi;
  if (h2 < 0.0) h2 += 2.0 * pi;
  float turn = h2 - h1;
  if (c1 * c2 == 0.0) turn = 0.0; else if (turn > pi) turn -= 2.0 * pi; else if (turn < -pi) turn += 2.0 * pi;
  float dl = q.x - p.x, dc = c2 - c1, dh = 2.0 * sqrt(c1 * c2) * sin(turn / 2.0);
  float l = (p.x + q.x) / 2.0, c = (c1 + c2) / 2.0, h = h1 + h2;
  if (c1 * c2 != 0.0) h = abs(h1 - h2) <= pi ? h / 2.0 : h < 2.0 * pi ? h / 2.0 + pi : h / 2.0 - pi;
  float t = 1.0 - 0.17 * cos(h - pi / 6.0) + 0.24 * cos(2.0 * h) + 0.32 * cos(3.0 * h + pi / 30.0) - 0.2 * cos(4.0 * h - 63.0 * pi / 180.0);
  float l50 = (l - 50.0) * (l - 50.0), sl = 1.0 + 0.015 * l50 / sqrt(20.0 + l50), sc = 1.0 + 0.045 * c, sh = 1.0 + 0.015 * c * t;
  float bend = (h * 180.0 / pi - 275.0) / 25.0, cc = pow(c, 7.0);
  float rt = -2.0 * sqrt(cc / (cc + 6103515625.0)) * sin(pi / 3.0 * exp(-bend * bend));
  return sqrt(max(0.0, dl * dl / (sl * sl) + dc * dc / (sc * sc) + dh * dh / (sh * sh) + rt * dc / sc * dh / sh));
}
vec3 heat(float t) { return clamp(vec3(3.0 * t, 3.0 * t - 1.0, 3.0 * t - 2.0), 0.0, 1.0); }
`;
