// Adds one to a pixel each time that it is drawn.
layout(location = 0) out vec4 result;
void main() { result = vec4(1.0); }
