// Counts fragments that pass the depth test.
layout(early_fragment_tests) in;
layout(r32ui, binding = 0) uniform uimage2D counts;
void main() { imageAtomicAdd(counts, ivec2(gl_FragCoord.xy), 1u); }
