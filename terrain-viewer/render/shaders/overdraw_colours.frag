// From counts of fragments to the colours of overdraw_ramp() in scene/ramp.h.
layout(binding = 0) uniform usampler2D counts;
layout(binding = 1) uniform sampler2D depths;
uniform int left;
uniform vec3 colours[9];  // sRGB; the last of all higher counts, too
layout(location = 0) in vec2 at;
layout(location = 0) out vec4 result;
void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy) - ivec2(left, 0);
  uint count = texelFetch(counts, pixel, 0).x;
  result = vec4(colours[min(count, 8u)], 1.0);
  gl_FragDepth = texelFetch(depths, pixel, 0).x;
}
