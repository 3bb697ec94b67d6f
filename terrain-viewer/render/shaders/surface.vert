// Pulls a packed vertex and its parent, and mixes the two by the vertex's own distance. Follows
// hlod/morph.h line by line.
layout(std430, binding = 0) readonly buffer Vertices { uint words[]; };

// C++: DrawRecord in terrain_renderer.cpp. Fine steps are those of the finest level.
struct Draw {
  ivec4 origin;         // lowest of the node, steps of its level; w: first vertex
  ivec4 parent_origin;  // of its parents' positions, steps of the level above; w: first parent
  ivec4 band;           // end, shift, band, finer as in hlod/morph.h; band 0: no parent
  ivec4 eye;            // fine steps; w: distance to the slab of heights, below 0 in octrees
  vec4 offset;          // minus the rest of the eye within its fine step, metres; w: fine step, metres
  vec4 colour;          // of the level or cell; w: height of the eye
  vec4 parent_colour;   // of the level above, or again of the cell
  vec4 scales;          // x: 1 / largest octahedral component
};
layout(std430, binding = 1) readonly buffer Draws { Draw draws[]; };

layout(location = 0) in uint draw_index;

layout(location = 0) out vec3 from_eye;
layout(location = 1) out vec3 normal;
layout(location = 2) out vec4 attributes;
layout(location = 3) out vec3 own_colour;
layout(location = 4) out vec3 level_colour;

const uint kWords = 6u;

ivec3 lattice_point(uint index, ivec3 origin) {
  uint low = words[index * kWords], high = words[index * kWords + 1u];
  return origin + ivec3(low & 0x1FFFFFu, (low >> 21) | ((high & 0x3FFu) << 11), high >> 10);
}

vec3 decode_octahedral(uint packed_normal, float scale) {
  ivec2 whole = ivec2(int(packed_normal << 16) >> 16, int(packed_normal) >> 16);
  vec2 p = vec2(whole) * scale;
  vec3 n = vec3(p, 1.0 - abs(p.x) - abs(p.y));
  float fold = max(-n.z, 0.0);
  n.x += n.x >= 0.0 ? -fold : fold;
  n.y += n.y >= 0.0 ? -fold : fold;
  return normalize(n);
}

int morph_weight(int distance, ivec4 band) {
  if (band.z == 0) return 32768;
  int t = clamp((band.x - distance) >> band.y, 0, band.z);
  return (t << 15) / band.z;
}

int morph_coordinate(int own, int parent, int eye, int weight, int finer) {
  int way = own - (parent << 1);
  int low = (way & 32767) * weight;
  int whole = (way >> 15) * weight + (low >> 15);
  int bits = min(finer, 15);
  int fraction = (low & 32767) >> (15 - bits);
  return (((parent << 1) + whole) << finer) + (fraction << (finer - bits)) - eye;
}

void main() {
  Draw draw = draws[draw_index];
  uint index = uint(gl_VertexID);
  uint parent = uint(draw.parent_origin.w) + (words[index * kWords + 3u] & 0xFFFFu);
  int finer = draw.band.w;
  ivec3 own = lattice_point(index, draw.origin.xyz);
  ivec3 above = lattice_point(parent, draw.parent_origin.xyz);

  ivec3 away = abs((own << finer) - draw.eye.xyz);
  int distance = max(max(away.x, away.y), draw.eye.w < 0 ? away.z : draw.eye.w);
  int weight = morph_weight(distance, draw.band);
  ivec3 seen = ivec3(morph_coordinate(own.x, above.x, draw.eye.x, weight, finer),
                     morph_coordinate(own.y, above.y, draw.eye.y, weight, finer),
                     morph_coordinate(own.z, above.z, draw.eye.z, weight, finer));

  // What two cells share has been the same whole numbers so far and becomes the same floats here.
  precise vec3 place = vec3(seen) * draw.offset.w + draw.offset.xyz;
  from_eye = place;
  float lambda = float(weight) / 32768.0;
  uint base = index * kWords, parent_base = parent * kWords;
  normal = mix(decode_octahedral(words[parent_base + 2u], draw.scales.x),
               decode_octahedral(words[base + 2u], draw.scales.x), lambda);
  uint look = words[base + 4u], parent_look = words[parent_base + 4u];
  attributes.x = 0.01 * mix(float(words[parent_base + 3u] >> 16), float(words[base + 3u] >> 16), lambda);
  attributes.y = mix(float(parent_look >> 24), float(look >> 24), lambda);
  attributes.z = lambda;
  attributes.w = from_eye.z + draw.colour.w;
  own_colour = decoded(mix(unpackUnorm4x8(parent_look).rgb, unpackUnorm4x8(look).rgb, lambda));
  level_colour = mix(decoded(draw.parent_colour.rgb), decoded(draw.colour.rgb), lambda);
  gl_Position = frame.view_projection * vec4(from_eye, 1.0);
}
