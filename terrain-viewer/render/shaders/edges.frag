// Edges of triangles.
layout(location = 0) out vec4 result;
void main() { result = vec4(0.05, 0.07, 0.12, 0.8); }
