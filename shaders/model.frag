// Alpha says where texture is: a face without a page hides what is behind it and shows the background.
in vec2 uv;

uniform sampler2D page;
uniform bool textured;
uniform vec3 background;

layout(location = 0) out vec4 color;

void main() { color = textured ? vec4(texture(page, uv).rgb, 1.0) : vec4(background, 0.0); }
