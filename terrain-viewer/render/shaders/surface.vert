// Pulls a packed vertex and its parent, and mixes the two by the vertex's own distance. Follows
// hlod/morph.h line by line.
layout(std430, binding = 0) readonly buffer Vertices { uint words[]; };

// C++: DrawRecord in terrain_renderer.cpp.
struct Draw {
  ivec4 origin;         // lowest of the node minus the eye's lattice point, steps; w: first vertex
  ivec4 parent_origin;  // the same for its parents, steps of the level above; w: first parent
  vec4 offset;          // minus the rest of the eye within its step, metres; w: step, metres
  vec4 parent_offset;
  vec4 morph;           // x: distance from which on the parent is drawn; y: 1 / width of the band;
                        // z: eye's distance to the slab of heights, metres, below 0 in octrees;
                        // w: 1 / largest octahedral component
  vec4 colour;          // of the level; w: height of the eye
};
layout(std430, binding = 1) readonly buffer Draws { Draw draws[]; };

layout(location = 0) in uint draw_index;

layout(location = 0) out vec3 from_eye;
layout(location = 1) out vec3 normal;
layout(location = 2) out vec4 attributes;
layout(location = 3) out vec3 own_colour;
layout(location = 4) flat out vec3 level_colour;

const uint kWords = 6u;

struct Vertex {
  vec3 position;  // relative to the eye, metres
  vec3 normal;
  float support;
  float source;
  vec3 colour;
};

vec3 decode_octahedral(uint packed_normal, float scale) {
  ivec2 whole = ivec2(int(packed_normal << 16) >> 16, int(packed_normal) >> 16);
  vec2 p = vec2(whole) * scale;
  vec3 n = vec3(p, 1.0 - abs(p.x) - abs(p.y));
  float fold = max(-n.z, 0.0);
  n.x += n.x >= 0.0 ? -fold : fold;
  n.y += n.y >= 0.0 ? -fold : fold;
  return normalize(n);
}

// A vertex that two cells share has the same whole numbers in both and becomes the same floats:
// nothing of the cell but whole numbers enters.
precise vec3 from_lattice(uint index, ivec4 origin, vec4 offset) {
  uint low = words[index * kWords], high = words[index * kWords + 1u];
  ivec3 steps = ivec3(low & 0x1FFFFFu, (low >> 21) | ((high & 0x3FFu) << 11), high >> 10);
  return vec3(origin.xyz + steps) * offset.w + offset.xyz;
}

Vertex pull(uint index, ivec4 origin, vec4 offset, float normal_scale) {
  uint base = index * kWords;
  Vertex v;
  v.position = from_lattice(index, origin, offset);
  v.normal = decode_octahedral(words[base + 2u], normal_scale);
  v.support = float(words[base + 3u] >> 16) * 0.01;
  v.source = float(words[base + 4u] >> 24);
  v.colour = unpackUnorm4x8(words[base + 4u]).rgb;
  return v;
}

void main() {
  Draw draw = draws[draw_index];
  uint index = uint(gl_VertexID);
  uint parent = uint(draw.parent_origin.w) + (words[index * kWords + 3u] & 0xFFFFu);
  Vertex v = pull(index, draw.origin, draw.offset, draw.morph.w);
  Vertex p = pull(parent, draw.parent_origin, draw.parent_offset, draw.morph.w);

  vec3 away = abs(v.position);
  float third = draw.morph.z < 0.0 ? away.z : draw.morph.z;
  float distance = max(max(away.x, away.y), third);
  float lambda = clamp((draw.morph.x - distance) * draw.morph.y, 0.0, 1.0);

  // The ends are the points themselves, not what a mix makes of them.
  from_eye = lambda >= 1.0 ? v.position : lambda <= 0.0 ? p.position : mix(p.position, v.position, lambda);
  normal = mix(p.normal, v.normal, lambda);
  attributes = vec4(mix(p.support, v.support, lambda), mix(p.source, v.source, lambda), lambda,
                    from_eye.z + draw.colour.w);
  own_colour = pow(mix(p.colour, v.colour, lambda), vec3(2.2));
  level_colour = draw.colour.rgb;
  gl_Position = frame.view_projection * vec4(from_eye, 1.0);
}
