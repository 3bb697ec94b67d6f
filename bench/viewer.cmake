# SPDX-License-Identifier: GPL-3.0-or-later
cornice_add_bench(viewer cornice_hlod cornice_viewer_app)
target_sources(bench-viewer PRIVATE viewer/flight.cpp viewer/flight_figures.cpp viewer/likeness.cpp
               viewer/made_hierarchy.cpp)
