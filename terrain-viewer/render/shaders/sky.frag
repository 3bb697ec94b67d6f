// Haze at the horizon, the sky's colour above, the sun's disc.
layout(location = 0) in vec2 at;
layout(location = 0) out vec4 result;
uniform mat3 rays;  // columns: right, up, forward; scaled so that rays * (at, 1) leads to the pixel
void main() {
  vec3 way = normalize(rays * vec3(at, 1.0));
  float up = clamp(way.z, 0.0, 1.0);
  vec3 colour = mix(haze_towards(way), frame.sky_colour.rgb * 0.8, pow(up, 0.55));
  float glow = max(dot(way, frame.sun.xyz), 0.0);
  colour += glow_towards(way) +
            vec3(1.0, 0.94, 0.80) * frame.sun_colour.rgb * smoothstep(0.99996, 0.99998, glow);
  result = vec4(clamp(colour, 0.0, 1.0), 1.0);
}
