# SPDX-License-Identifier: GPL-3.0-or-later
cornice_library(las las_info.cpp las_reader.cpp las_writer.cpp las_head_writer.cpp laszip_encoder.cpp
                lax_writer.cpp output_stream.cpp copc_octree.cpp copc_writer.cpp)
target_link_libraries(cornice_las PUBLIC cornice_points cornice_geo
                                  PRIVATE LASzip::LASzip GDAL::GDAL)
target_sources(cornice_las PRIVATE byte_source.cpp zip_source.cpp las_header.cpp las_vlr.cpp
                                   laz_vlr.cpp laz_chunk_table.cpp las_chunks.cpp
                                   laszip_stream.cpp laszip_decoder.cpp copc_hierarchy.cpp ordered_work.cpp
                                   las_decode.cpp lax_reader.cpp)
