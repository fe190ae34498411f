// Loaded before a program (LD_PRELOAD), it keeps sqmap to SSE4, as for speed.c beside WebAssembly.
// g++ -shared -fPIC sse4.cpp -o sse4.so -lhwy
#include <hwy/targets.h>

namespace {
const struct OnlySse4 {
    OnlySse4() { hwy::SetSupportedTargetsForTest(HWY_SSE4 | HWY_SCALAR); }
} only_sse4;
}  // namespace
