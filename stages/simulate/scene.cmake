# SPDX-License-Identifier: GPL-3.0-or-later
cornice_library(
  simulate_scene
  scene.cpp
  scene_canopy.cpp
  scene_cover.cpp
  scene_cubes.cpp
  scene_embree.cpp
  scene_erosion.cpp
  scene_field.cpp
  scene_field_lanes.cpp
  scene_file.cpp
  scene_mesher.cpp
  scene_noise.cpp
  scene_rays.cpp
  scene_relief.cpp)
target_link_libraries(
  cornice_simulate_scene
  PUBLIC cornice_base cornice_io
  PRIVATE embree yaml-cpp::yaml-cpp)
# Vectors of four doubles are passed between inlined functions alone: no binary interface to change.
set_source_files_properties(scene_field.cpp scene_field_lanes.cpp PROPERTIES COMPILE_OPTIONS
                                                                             -Wno-psabi)
