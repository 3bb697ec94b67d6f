// Shading of the ground: light, natural colours by slope and height, ramps, contour lines, haze.
// Air: scattering by molecules as in Bruneton and Neyret, "Precomputed atmospheric scattering",
// Computer Graphics Forum 27(4), 2008.
layout(location = 0) in vec3 from_eye;       // metres
layout(location = 1) in vec3 normal;
layout(location = 2) in vec4 attributes;     // support in metres, source, lambda, height in metres
layout(location = 3) in vec3 own_colour;
layout(location = 4) in vec3 level_colour;

layout(binding = 0) uniform sampler1D ramp;

layout(location = 0) out vec4 result;

const int kNatural = 0, kPlain = 1, kSlope = 2, kAspect = 3, kAltitude = 4, kSupport = 5,
          kSource = 6, kColour = 7, kLevel = 8, kMorph = 9, kNormal = 10, kCell = 11;

float hash(ivec2 cell) {
  uint h = uint(cell.x) * 0x9E3779B1u ^ uint(cell.y) * 0x85EBCA77u;
  h ^= h >> 15; h *= 0x2C1B3C6Du; h ^= h >> 12;
  return float(h & 0xFFFFu) / 65535.0;
}

// Value noise, so that the borders of snow and grass are no contour lines.
float noise(vec2 at) {
  ivec2 cell = ivec2(floor(at));
  vec2 t = at - vec2(cell);
  t = t * t * (3.0 - 2.0 * t);
  return mix(mix(hash(cell), hash(cell + ivec2(1, 0)), t.x),
             mix(hash(cell + ivec2(0, 1)), hash(cell + ivec2(1, 1)), t.x), t.y);
}

vec3 natural(vec3 n, float height) {
  vec2 place = from_eye.xy + frame.place.xy;
  float grain = 0.6 * noise(place / 37.0) + 0.3 * noise(place / 9.0) + 0.1 * noise(place / 2.3);
  float steep = 1.0 - n.z;
  vec3 rock = mix(vec3(0.43, 0.40, 0.37), vec3(0.55, 0.52, 0.48), grain);
  vec3 scree = mix(vec3(0.56, 0.53, 0.48), vec3(0.64, 0.61, 0.56), grain);
  vec3 grass = mix(vec3(0.33, 0.37, 0.24), vec3(0.42, 0.44, 0.30), grain);
  vec3 snow = mix(vec3(0.90, 0.92, 0.95), vec3(0.97, 0.98, 1.0), grain);
  float tree_line = frame.contours.z + 120.0 * (grain - 0.5);
  vec3 ground = mix(grass, scree, smoothstep(tree_line - 80.0, tree_line + 80.0, height));
  ground = mix(ground, rock, smoothstep(0.22, 0.36, steep + 0.10 * (grain - 0.5)));
  float snow_line = frame.contours.y + 200.0 * (grain - 0.5);
  float lies = smoothstep(snow_line - 60.0, snow_line + 60.0, height) *
               (1.0 - smoothstep(0.24, 0.40, steep));
  return decoded(mix(ground, snow, lies));
}

vec3 along_ramp(float value) {
  float t = (value - frame.eye_height.y) / (frame.eye_height.z - frame.eye_height.y);
  return texture(ramp, clamp(t, 0.0, 1.0)).rgb;
}

vec3 surface_colour(vec3 n, float height) {
  switch (frame.shading.x) {
    case kNatural: return natural(n, height);
    case kSlope: return along_ramp(degrees(acos(clamp(n.z, -1.0, 1.0))));
    case kAspect: return mix(vec3(0.8), along_ramp(mod(degrees(atan(n.x, n.y)) + 360.0, 360.0)),
                             smoothstep(0.01, 0.05, length(n.xy)));
    case kAltitude: return along_ramp(height);
    case kSupport: return along_ramp(attributes.x);
    case kSource: return along_ramp(floor(attributes.y + 0.5) + 0.5);
    case kColour: return own_colour;
    case kLevel: case kCell: return level_colour;
    case kMorph: return along_ramp(attributes.z);
    case kNormal: return 0.5 + 0.5 * n;
    default: return vec3(0.30, 0.29, 0.275);
  }
}

// For colours that a legend explains: 1 where the ground faces the light, less elsewhere, so that
// none is lighter than the legend says, and no other hue.
float legend_shade(vec3 n) {
  const vec3 kLuminance = vec3(0.2126, 0.7152, 0.0722);
  const float kSun = 0.9, kAmbient = 0.7;
  float low = kAmbient * dot(frame.ground_colour.rgb, kLuminance);
  float high = kAmbient * dot(frame.sky_colour.rgb, kLuminance);
  float sun = kSun * min(frame.sun.w, 1.0), middle = 0.5 * (low + high), half_way = high - middle;
  float most = middle + length(vec3(0.0, 0.0, half_way) + sun * frame.sun.xyz);
  return (middle + half_way * n.z + sun * max(dot(n, frame.sun.xyz), 0.0)) / most;
}

// Air that thins to 1/e over `scale` metres, 0: that does not, as metres of air like the eye's.
float air_between(vec3 way, float scale) {
  float drop = scale > 0.0 ? way.z / scale : 0.0;
  float mean = abs(drop) > 1e-3 ? (1.0 - exp(-drop)) / drop : 1.0 - 0.5 * drop;
  return length(way) * clamp(mean, 0.0, 8.0);
}

// How much of red, green and blue comes through from there: molecules take blue first, so mountains
// turn blue before they turn pale; droplets and dust take all colours alike, but lie low.
vec3 through_air(vec3 way) {
  const vec3 kMolecules = vec3(5.8e-6, 13.5e-6, 33.1e-6);  // per metre at the sea
  const float kThinning = 8000.0;
  vec3 clear = kMolecules * exp(-max(frame.eye_height.x, 0.0) / kThinning);
  return exp(-clear * air_between(way, kThinning) -
             frame.ground_colour.w * air_between(way, frame.haze_colour.w));
}

// Presses light above kToneFrom so that snow in full sun, kWhite, just becomes white and keeps its
// relief: Reinhard et al., "Photographic tone reproduction for digital images", SIGGRAPH 2002, eq. 4.
const float kToneFrom = 0.25, kWhite = 2.6;
vec3 tone(vec3 light) {
  const float kRoom = 1.0 - kToneFrom, kMost = (kWhite - kToneFrom) / kRoom;
  vec3 over = max(light - kToneFrom, 0.0) / kRoom;
  return kToneFrom + kRoom * over * (1.0 + over / (kMost * kMost)) / (1.0 + over);
}

void main() {
  vec3 n = normalize(normal);
  // Seen from within the ground there is nothing to be seen but that it is the ground.
  bool from_below = !gl_FrontFacing;
  float height = attributes.w;
  vec4 over = drape_colour(from_eye.xy, n);
  if (from_below) over.a = 0.0;
  vec3 colour = from_below ? vec3(0.25, 0.22, 0.20) : surface_colour(n, height);
  if (frame.shading.x == kNormal) {
    result = vec4(colour, frame.eye_height.w);
    return;
  }

  float diffuse = max(dot(n, frame.sun.xyz), 0.0) * frame.sun.w;
  vec3 ambient = mix(frame.ground_colour.rgb, frame.sky_colour.rgb, 0.5 + 0.5 * n.z) *
                 frame.sky_colour.w;
  vec3 light = ambient + frame.sun_colour.rgb * diffuse;
  float shade = legend_shade(n);
  bool has_legend = frame.shading.y == 1 && !from_below;
  vec3 lit = colour * (has_legend ? vec3(shade) : light);
  // A photograph has its own light and shade.
  bool is_photo = drape.what.x == 1;
  lit = mix(lit, over.rgb * (is_photo ? mix(vec3(1.0), light, drape.texel.w) : vec3(shade)), over.a);
  // How much of what is seen here a legend explains: that is neither hazy nor pressed below.
  float told = is_photo ? (has_legend ? 1.0 - over.a : 0.0) : max(has_legend ? 1.0 : 0.0, over.a);

  if (frame.contours.x > 0.0) {
    float line = height / frame.contours.x;
    float width = fwidth(line);
    float off = abs(fract(line + 0.5) - 0.5);
    float thick = mod(floor(line + 0.5), 5.0) < 0.5 ? 1.3 : 0.7;
    float ink = (1.0 - smoothstep(thick - 0.5, thick + 0.5, off / max(width, 1e-6))) *
                (1.0 - smoothstep(0.25, 0.5, width));
    lit = mix(lit, vec3(0.30, 0.18, 0.08), 0.75 * ink);
  }

  vec3 pressed = mix(lit, tone(lit), vec3(greaterThan(lit, vec3(kToneFrom))));
  lit = mix(pressed, lit, is_photo ? max(told, over.a) : told);
  if (frame.ground_colour.w > 0.0) {
    vec3 way = normalize(from_eye);
    lit = mix(decoded(haze_towards(way) + glow_towards(way)), lit, max(through_air(from_eye), told));
  }
  result = vec4(encoded(clamp(lit, 0.0, 1.0)), frame.eye_height.w);
}
