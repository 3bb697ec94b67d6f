# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(base unit/base/atomic_file_test.cpp unit/base/input_file_test.cpp unit/base/memory_test.cpp
             unit/base/parallel_test.cpp unit/base/radix_sort_test.cpp
             unit/base/random_test.cpp LIBS cornice_base cornice_test_support)
