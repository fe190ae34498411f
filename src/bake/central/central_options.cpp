#include "central_options.h"

#include <algorithm>

namespace sqmap::bake {

namespace {

constexpr double k_first_target = 0.5;

}  // namespace

CentralOptions central_options(double target_error, double r_max)
{
    target_error = std::max(target_error, k_first_target);
    CentralOptions central;
    central.r_max = r_max;
    central.tolerance = 0.0016 * target_error;
    central.foreign_tolerance = 0.003 * target_error;
    central.finest = 0.02 * target_error;
    central.silhouette = 0.022 * target_error;
    central.division = 0.003 * target_error;
    return central;
}

void scale(CentralOptions& central, double factor)
{
    for (double* size : {&central.finest, &central.tolerance, &central.foreign_tolerance, &central.silhouette, &central.division})
        *size *= factor;
}

}  // namespace sqmap::bake
