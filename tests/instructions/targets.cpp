// Stands in for libhwy.so, whose static initialiser runs rdtscp wherever the processor has it. Some virtual processors do not
// list rdtscp in CPUID, and valgrind refuses instructions that CPUID does not list.
#include <hwy/targets.h>

namespace hwy {

std::int64_t SupportedTargets()
{
#if HWY_ARCH_X86
    std::int64_t targets = HWY_EMU128 | HWY_SCALAR;
    if (__builtin_cpu_supports("sse4.2")) targets |= HWY_SSE4;
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) targets |= HWY_AVX2;
    if (__builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq"))
        targets |= HWY_AVX3;
    return targets;
#else
    return HWY_STATIC_TARGET;
#endif
}

ChosenTarget& GetChosenTarget()
{
    static ChosenTarget chosen;
    return chosen;
}

}  // namespace hwy
