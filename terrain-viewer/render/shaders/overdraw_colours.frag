// From counts of fragments to colours: green where nothing is drawn, blue for 1 and 2, yellow to
// red from 3 to 8 and above.
layout(binding = 0) uniform usampler2D counts;
layout(binding = 1) uniform sampler2D depths;
uniform int left;
layout(location = 0) in vec2 at;
layout(location = 0) out vec4 result;
void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy) - ivec2(left, 0);
  uint count = texelFetch(counts, pixel, 0).x;
  vec3 colour = vec3(0.20, 0.45, 0.25);
  if (count == 1u) colour = vec3(0.16, 0.25, 0.45);
  if (count == 2u) colour = vec3(0.35, 0.50, 0.80);
  if (count > 2u)
    colour = mix(vec3(0.95, 0.85, 0.35), vec3(0.75, 0.05, 0.05), clamp(float(count - 3u) / 5.0, 0.0, 1.0));
  result = vec4(colour, 1.0);
  gl_FragDepth = texelFetch(depths, pixel, 0).x;
}
