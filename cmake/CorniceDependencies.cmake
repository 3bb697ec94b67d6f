# SPDX-License-Identifier: GPL-3.0-or-later
# Finds every library; one message lists all Debian packages that are missing.

set(CORNICE_MISSING "")

# cornice_find(DEBIAN_PACKAGE CMAKE_PACKAGE ARGS...)
macro(cornice_find debian_package cmake_package)
  find_package(${cmake_package} QUIET ${ARGN})
  if(NOT ${cmake_package}_FOUND)
    list(APPEND CORNICE_MISSING ${debian_package})
  endif()
endmacro()

# cornice_find_library(TARGET DEBIAN_PACKAGE HEADER LIBRARIES...): for those without a CMake config.
function(cornice_find_library target debian_package header)
  string(MAKE_C_IDENTIFIER "CORNICE_${target}" prefix)
  find_path(${prefix}_INCLUDE ${header} PATH_SUFFIXES imgui pcl-1.15 pcl-1.14 pcl-1.13 pcl-1.12)
  set(found ${${prefix}_INCLUDE})
  set(libraries "")
  foreach(name IN LISTS ARGN)
    find_library(${prefix}_${name} ${name})
    if(NOT ${prefix}_${name})
      set(found "")
    endif()
    list(APPEND libraries "${${prefix}_${name}}")
  endforeach()
  if(NOT found)
    set(CORNICE_MISSING ${CORNICE_MISSING} ${debian_package} PARENT_SCOPE)
    return()
  endif()
  add_library(${target} INTERFACE IMPORTED GLOBAL)
  target_include_directories(${target} SYSTEM INTERFACE "${${prefix}_INCLUDE}")
  target_link_libraries(${target} INTERFACE ${libraries})
endfunction()

set(THREADS_PREFER_PTHREAD_FLAG ON)
find_package(Threads REQUIRED)
cornice_find(libtbb-dev TBB)
cornice_find(libgdal-dev GDAL)
cornice_find(libspdlog-dev spdlog)
cornice_find(nlohmann-json3-dev nlohmann_json)
cornice_find(libcli11-dev CLI11)
cornice_find(libyaml-cpp-dev yaml-cpp)
cornice_find(libeigen3-dev Eigen3)
cornice_find_library(LASzip::LASzip liblaszip-dev laszip/laszip_api.h laszip)
# Debian's own CMake file of OpenImageIO names folders of packages that it does not depend on.
cornice_find_library(OpenImageIO::OpenImageIO libopenimageio-dev OpenImageIO/imageio.h OpenImageIO
                     OpenImageIO_Util)
cornice_find_library(xxhash::xxhash libxxhash-dev xxhash.h xxhash)
cornice_find_library(zstd::zstd libzstd-dev zstd.h zstd)
# OpenGL and EGL are found when the viewer runs, through epoxy.
cornice_find_library(epoxy::epoxy libepoxy-dev epoxy/gl.h epoxy)
cornice_find_library(glfw::glfw libglfw3-dev GLFW/glfw3.h glfw)
# Its static library holds the back ends for GLFW and OpenGL 3.
cornice_find_library(imgui::imgui libimgui-dev imgui.h imgui stb)
cornice_find_library(nova::nova libnova-dev libnova/solar.h nova)
# Ubuntu 22.04 still has GeographicLib 1, whose package and library go by a shorter name.
find_library(CORNICE_GEOGRAPHIC_1 Geographic)
if(CORNICE_GEOGRAPHIC_1)
  cornice_find_library(GeographicLib::GeographicLib libgeographic-dev GeographicLib/UTMUPS.hpp
                       Geographic)
else()
  cornice_find_library(GeographicLib::GeographicLib libgeographiclib-dev GeographicLib/UTMUPS.hpp
                       GeographicLib)
endif()
cornice_find_library(flann::flann libflann-dev flann/flann.hpp flann_cpp lz4)
# PCL's own CMake file looks for VTK and Qt, which nothing here uses; its libraries are named alone.
cornice_find_library(PCL::filters libpcl-dev pcl/point_cloud.h pcl_filters pcl_features pcl_search
                     pcl_kdtree pcl_octree pcl_sample_consensus pcl_common)
if(TARGET PCL::filters)
  target_link_libraries(PCL::filters INTERFACE Eigen3::Eigen flann::flann)
endif()
if(CORNICE_BUILD_BENCH)
  cornice_find_library(PCL::surface libpcl-dev pcl/surface/poisson.h pcl_surface pcl_search pcl_kdtree
                       pcl_octree pcl_common)
  if(TARGET PCL::surface)
    target_link_libraries(PCL::surface INTERFACE Eigen3::Eigen flann::flann)
  endif()
endif()
# Header-only; the libraries are those of its exact numbers.
cornice_find_library(CGAL::headers libcgal-dev CGAL/AABB_tree.h gmp mpfr)
# OpenMesh reads OBJ, OFF and STL. Ubuntu 22.04 does not have it: there, .ply alone is read.
find_path(CORNICE_OPENMESH_INCLUDE OpenMesh/Core/IO/importer/BaseImporter.hh)
find_library(CORNICE_OPENMESH OpenMeshCore)
if(CORNICE_OPENMESH AND CORNICE_OPENMESH_INCLUDE)
  add_library(OpenMesh::core INTERFACE IMPORTED GLOBAL)
  target_include_directories(OpenMesh::core SYSTEM INTERFACE "${CORNICE_OPENMESH_INCLUDE}")
  target_link_libraries(OpenMesh::core INTERFACE "${CORNICE_OPENMESH}")
else()
  message(STATUS "OpenMesh (libopenmesh-dev) is missing: meshes are read from .ply alone, "
                 "not from .obj, .off and .stl")
endif()
# Used as headers everywhere: Ubuntu 22.04 has a compiled library beside them, the others do not.
cornice_find_library(tinygltf::headers libtinygltf-dev tiny_gltf.h)
foreach(version 4 3)
  if(NOT TARGET embree)
    find_package(embree ${version} QUIET)
  endif()
endforeach()
if(NOT TARGET embree)
  list(APPEND CORNICE_MISSING libembree-dev)
endif()
if(CORNICE_BUILD_TESTS)
  cornice_find(libgtest-dev GTest)
endif()
if(CORNICE_BUILD_BENCH)
  cornice_find(libbenchmark-dev benchmark)
endif()

if(CORNICE_MISSING)
  list(JOIN CORNICE_MISSING " " missing)
  message(FATAL_ERROR "Missing Debian packages: ${missing}\n"
                      "Install them with: scripts/setup (or apt-get install ${missing})")
endif()
if(TARGET yaml-cpp AND NOT TARGET yaml-cpp::yaml-cpp)
  add_library(yaml-cpp::yaml-cpp ALIAS yaml-cpp)
endif()
