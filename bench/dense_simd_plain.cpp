#include "dense_simd_kernel.inl"

namespace sqmap::bench {

std::uint32_t dense_kernel_plain(const FieldView& field, const ProbeView& probe, const CellPose& pose,
                                 const ContactWorkspace& workspace)
{
    return run(field, probe, pose, workspace);
}

}  // namespace sqmap::bench
