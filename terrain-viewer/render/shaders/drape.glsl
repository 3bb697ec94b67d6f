// A raster over the ground by plan position. C++: DrapeBlock and DrapeTexture in drape_texture.h.
layout(std140, binding = 1) uniform Drape {
  ivec4 what;        // x: 0 none, 1 photograph, 2 values; y: levels
  vec4 texel;        // x, y: of level 0, metres; z: opacity; w: how much light and shade it gets
  vec4 bounds;       // west, south, east, north from the eye
  vec4 ramp;         // x, y: its ends
  ivec4 tile[24];    // x, y: column and row of the eye's tile, by level
  vec4 within[24];   // x, y: place of the eye in that tile, from its north-western corner
} drape;

layout(binding = 1) uniform sampler2DArray drape_tiles;
layout(binding = 2) uniform usampler2DArray drape_pages;
layout(binding = 3) uniform sampler1D drape_ramp;

const int kDrapePages = 64;
const float kDrapeTexels = 256.0;
// Seen at a glancing angle a pixel covers a long strip: so many texels of it are mixed.
const float kDrapeStrip = 4.0;

// The finest that is there from `level` on; coverage 0 where nothing is.
vec4 drape_at(int level, vec2 place) {
  for (int l = level; l < drape.what.y; ++l) {
    vec2 tile_size = drape.texel.xy * exp2(float(l)) * kDrapeTexels;
    vec2 at = drape.within[l].xy + vec2(place.x, -place.y) / tile_size;
    vec2 steps = floor(at);
    ivec2 away = ivec2(steps);
    if (any(lessThan(away, ivec2(-kDrapePages / 2))) ||
        any(greaterThanEqual(away, ivec2(kDrapePages / 2)))) continue;
    ivec2 tile = drape.tile[l].xy + away;
    if (any(lessThan(tile, ivec2(0)))) continue;
    uint page = texelFetch(drape_pages, ivec3(tile & (kDrapePages - 1), l), 0).x;
    if (page == 0u) continue;
    vec2 in_tile = (1.0 + (at - steps) * kDrapeTexels) / (kDrapeTexels + 2.0);
    return textureLod(drape_tiles, vec3(in_tile, float(page - 1u)), 0.0);
  }
  return vec4(0.0);
}

vec4 drape_between_levels(float lod, vec2 place) {
  int level = int(lod);
  vec4 fine = drape_at(level, place);
  float t = fract(lod);
  return t > 0.0 ? mix(fine, drape_at(min(level + 1, drape.what.y - 1), place), t) : fine;
}

// rgb: the colour, linear; a: how much of it is to be seen. place: plan position from the eye.
// Derivatives are taken here: call it for all pixels alike.
vec4 drape_colour(vec2 place, vec3 n) {
  vec2 dx = dFdx(place) / drape.texel.xy, dy = dFdy(place) / drape.texel.xy;
  if (drape.what.x == 0 || any(lessThan(place, drape.bounds.xy)) ||
      any(greaterThan(place, drape.bounds.zw))) return vec4(0.0);
  float a = length(dx), b = length(dy);
  vec2 along = a > b ? dFdx(place) : dFdy(place);
  float longer = max(a, b), shorter = max(min(a, b), longer / kDrapeStrip);
  float lod = clamp(log2(max(shorter, 1e-6)), 0.0, float(drape.what.y - 1));
  int count = int(clamp(ceil(longer / max(shorter, 1e-6) - 0.01), 1.0, kDrapeStrip));
  vec4 sum = vec4(0.0);
  for (int i = 0; i < count; ++i)
    sum += drape_between_levels(lod, place + along * ((float(i) + 0.5) / float(count) - 0.5));
  vec4 mean = sum / float(count);
  vec3 colour = mean.rgb;
  float cover = mean.a;
  if (drape.what.x == 2) {
    float t = (mean.x - drape.ramp.x) / (drape.ramp.y - drape.ramp.x);
    colour = texture(drape_ramp, clamp(t, 0.0, 1.0)).rgb;
    cover = mean.y;
  }
  // From above nothing was seen of ground that faces down.
  return vec4(colour, smoothstep(0.25, 0.75, cover) * smoothstep(0.0, 0.05, n.z) * drape.texel.z);
}
