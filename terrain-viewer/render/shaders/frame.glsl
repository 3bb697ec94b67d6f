// What holds for a whole picture. C++: FrameBlock in terrain_renderer.cpp.
layout(std140, binding = 0) uniform Frame {
  mat4 view_projection;   // from positions relative to the eye
  vec4 sun;               // direction towards the sun; w: strength 0..1
  vec4 sun_colour;        // of its light; w: how far haze below it takes that colour
  vec4 sky_colour;        // light from above; w: strength of the ambient light
  vec4 ground_colour;     // light from below; w: density of the haze per metre at the eye's height
  vec4 haze_colour;       // w: metres over which haze thins to 1/e with height, 0: it does not
  vec4 eye_height;        // x: height of the eye; y, z: low and high of the ramp; w: opacity
  vec4 contours;          // x: metres between lines, 0: none; y: snow line; z: tree line
  ivec4 shading;          // x: which; y: 1: a legend explains the colours
  vec4 place;             // x, y: the eye in plan, modulo what floats hold well
} frame;

// What air far away looks like in a direction (unit vector), sRGB.
vec3 haze_towards(vec3 way) {
  vec2 plan = way.xy, sun = frame.sun.xy;
  float towards = 0.5 + 0.5 * dot(plan, sun) / max(length(plan) * length(sun), 1e-6);
  // As bright as elsewhere.
  vec3 warm = frame.sun_colour.rgb * frame.haze_colour.b;
  return mix(frame.haze_colour.rgb, warm, frame.sun_colour.w * towards * towards);
}
// How much brighter air is where one looks to the sun through it.
vec3 glow_towards(vec3 way) {
  return 0.15 * clamp(frame.sun.w, 0.0, 1.0) * pow(max(dot(way, frame.sun.xyz), 0.0), 64.0) *
         vec3(1.0, 0.94, 0.80) * frame.sun_colour.rgb;
}

// From light to sRGB and back, IEC 61966-2-1.
vec3 encoded(vec3 light) {
  return mix(12.92 * light, 1.055 * pow(light, vec3(1.0 / 2.4)) - 0.055,
             vec3(greaterThan(light, vec3(0.0031308))));
}
vec3 decoded(vec3 colour) {
  return mix(colour / 12.92, pow((colour + 0.055) / 1.055, vec3(2.4)),
             vec3(greaterThan(colour, vec3(0.04045))));
}
