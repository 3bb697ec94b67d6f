// What holds for a whole picture. C++: FrameBlock in terrain_renderer.cpp.
layout(std140, binding = 0) uniform Frame {
  mat4 view_projection;   // from positions relative to the eye
  vec4 sun;               // direction towards the sun; w: strength 0..1
  vec4 sky_colour;        // light from above; w: strength of the ambient light
  vec4 ground_colour;     // light from below; w: density of the haze per metre at the eye's height
  vec4 haze_colour;       // w: metres over which haze thins to 1/e with height, 0: it does not
  vec4 eye_height;        // x: height of the eye; y, z: low and high of the ramp; w: opacity
  vec4 contours;          // x: metres between lines, 0: none; y: snow line; z: tree line
  ivec4 shading;          // x: which; y: 1: swipe line in use;
                          // z: 1: a legend explains the colours; w: unused
  vec4 swipe;             // x: pixel column; y: -1 left of it is drawn, 1 right of it;
                          // z, w: the eye in plan, modulo what floats hold well
} frame;

// From light to sRGB and back, IEC 61966-2-1.
vec3 encoded(vec3 light) {
  return mix(12.92 * light, 1.055 * pow(light, vec3(1.0 / 2.4)) - 0.055,
             vec3(greaterThan(light, vec3(0.0031308))));
}
vec3 decoded(vec3 colour) {
  return mix(colour / 12.92, pow((colour + 0.055) / 1.055, vec3(2.4)),
             vec3(greaterThan(colour, vec3(0.04045))));
}
