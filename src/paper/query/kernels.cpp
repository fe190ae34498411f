// K. Moustakas, D. Tzovaras, M. G. Strintzis, SQ-Map, IEEE TVCG 13(1), 2007, section 4.2, for many points at once. Compiled for
// each instruction set by Highway (J. Wassenberg et al.); no fused multiply-add, so that all give the same bits.
#include "normal_job.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "query/normal/normal_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#if HWY_TARGET != HWY_SCALAR
#include "probe-inl.h"
#endif

HWY_BEFORE_NAMESPACE();
namespace sqmap::query::HWY_NAMESPACE {
namespace {

#if HWY_TARGET == HWY_SCALAR  // compiled once, in normal_one_lane.cpp
ProbeResult run(const NormalJob& job) { return run_normal_one_lane(job); }
#else
ProbeResult run(const NormalJob& job) { return NormalKernel(job).run(); }
#endif

}  // namespace
}  // namespace sqmap::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sqmap::query {

HWY_EXPORT(run);

ProbeResult run_normal(const NormalJob& job) noexcept { return HWY_DYNAMIC_DISPATCH(run)(job); }

}  // namespace sqmap::query
#endif
