// SPDX-License-Identifier: GPL-3.0-or-later
// The sources in shaders/, put into the program by CMake; make_program puts
// #version and kFrame before each.
#pragma once

namespace cornice::viewer::shaders {

extern const char* const kFrame;
extern const char* const kSurfaceVertex;
extern const char* const kSurfaceFragment;
extern const char* const kSkyVertex;
extern const char* const kSkyFragment;
extern const char* const kEdgesFragment;
extern const char* const kOverdrawFragment;
extern const char* const kOverdrawColoursFragment;

}  // namespace cornice::viewer::shaders
