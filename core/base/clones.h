// SPDX-License-Identifier: GPL-3.0-or-later
// Hot loops compiled for several instruction sets, the best chosen as the program starts.
#pragma once

// Only the width of vectors differs between the versions. Contraction is off (cmake/), so each lane
// does the same arithmetic everywhere and the bytes are the same. Clang 14 has no clones of C++
// functions, and sanitizers are not up yet when the choice is made. Tests build some loops with
// CORNICE_ONE_VERSION, too, and compare.
#if !defined(CORNICE_ONE_VERSION) && defined(__x86_64__) && defined(__gnu_linux__) && \
    defined(__GNUC__) && !defined(__clang__) && !defined(__AVX2__) &&                 \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define CORNICE_CLONES __attribute__((target_clones("avx2", "default")))
/// For loops that choose between values in every line: AVX-512 has masks.
#define CORNICE_WIDE_CLONES __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define CORNICE_CLONES
#define CORNICE_WIDE_CLONES
#endif
