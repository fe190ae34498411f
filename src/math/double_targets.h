// Which instruction sets compile kernels with vectors of doubles. Such a file includes it before Highway.
#pragma once

#define SQMAP_HAS_DOUBLE_TARGETS

#ifdef __wasm__  // Highway 1.0.3 has no vectors of doubles there: one lane at a time
#undef HWY_COMPILE_ONLY_STATIC
#define HWY_COMPILE_ONLY_SCALAR
#endif
