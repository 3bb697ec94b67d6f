# SPDX-License-Identifier: GPL-3.0-or-later
# PCL's headers need the definitions of a target of their own; only the adapter sees them.
cornice_library(bench_pcl_poisson poisson/pcl_poisson.cpp)
target_link_libraries(cornice_bench_pcl_poisson PUBLIC cornice_base PRIVATE PCL::surface)
cornice_add_bench(poisson cornice_bench_pcl_poisson cornice_poisson_engine cornice_poisson_extract
                  cornice_mesh cornice_io)
target_sources(bench-poisson PRIVATE poisson/hills.cpp poisson/run.cpp)
