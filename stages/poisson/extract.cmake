# SPDX-License-Identifier: GPL-3.0-or-later
cornice_library(poisson_extract extract.cpp)
target_link_libraries(cornice_poisson_extract PUBLIC cornice_poisson_engine cornice_base)
