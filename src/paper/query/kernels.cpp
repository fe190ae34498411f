// K. Moustakas, D. Tzovaras, M. G. Strintzis, SQ-Map, IEEE TVCG 13(1), 2007, section 4.2, for many points at once. Compiled for
// each instruction set by Highway (J. Wassenberg et al.); no fused multiply-add, so that all give the same bits.
#include "job.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "paper/query/kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#if HWY_TARGET != HWY_SCALAR
#include "probe-inl.h"
#endif

HWY_BEFORE_NAMESPACE();
namespace sqmap::paper::HWY_NAMESPACE {
namespace {

#if HWY_TARGET == HWY_SCALAR  // compiled once, in one_lane.cpp
ProbeResult run(const PaperJob& job) { return run_one_lane(job); }
#else
ProbeResult run(const PaperJob& job) { return PaperKernel(job).run(); }
#endif

}  // namespace
}  // namespace sqmap::paper::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sqmap::paper {

HWY_EXPORT(run);

ProbeResult run_paper(const PaperJob& job) noexcept { return HWY_DYNAMIC_DISPATCH(run)(job); }

}  // namespace sqmap::paper
#endif
