# SPDX-License-Identifier: GPL-3.0-or-later
# What several tests need: folders that vanish, programs run and looked at.
cornice_library(test_support support/full_disk.cpp support/process.cpp support/temporary_folder.cpp)
target_link_libraries(cornice_test_support PUBLIC cornice_base)
