# SPDX-License-Identifier: GPL-3.0-or-later
# The checker is a library of its own because the property tests use it too.
cornice_library(cracks_checker cracks/checker.cpp)
target_link_libraries(cornice_cracks_checker PUBLIC cornice_hlod)
