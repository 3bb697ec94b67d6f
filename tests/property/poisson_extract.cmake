# SPDX-License-Identifier: GPL-3.0-or-later
cornice_test(poisson_extract property/poisson_extract/extract_test.cpp
             property/poisson_extract/fields.cpp property/poisson_extract/support_test.cpp
             property/poisson_extract/table_test.cpp
             LIBS cornice_poisson_extract cornice_mesh)
