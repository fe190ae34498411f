#include "caller_frame.h"

namespace sqmap::query {

CallerFrame::CallerFrame(const model::Header& header, const Pose& touched) noexcept : unit(static_cast<float>(header.unit))
{
    constexpr double k_near = 16;  // times R_max: 16 units in the last place of a float are 1e-6 of R_max
    const Vec3d origin = apply(touched, {header.origin[0], header.origin[1], header.origin[2]});
    const bool near = norm(origin) <= k_near * header.r_max * header.unit;
    if (!near) anchor = origin;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) rotation[3 * i + j] = static_cast<float>(touched.rotation.row[i][j]);
        translation[i] = near ? static_cast<float>(origin[i]) : 0.f;
        for (int j = 0; j < 3; ++j) is_turned = is_turned || rotation[3 * i + j] != (i == j ? 1.f : 0.f);
    }
}

}  // namespace sqmap::query
