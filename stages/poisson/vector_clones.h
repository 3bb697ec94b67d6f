// SPDX-License-Identifier: GPL-3.0-or-later
// A build switch: hot loops are compiled a second time for AVX2, and the processor's own version is
// taken at run time. Without fused operations both do the same arithmetic, so give the same bytes.
#pragma once

#if defined(__x86_64__) && defined(__gnu_linux__) && defined(__GNUC__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) && !defined(__clang__)
#define CORNICE_VECTOR_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define CORNICE_VECTOR_CLONES
#endif
