// Percentiles of measured values.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace sqmap {

/// The value that so many percent of the others do not exceed; reorders the values. @pre there are some
template <class Real>
Real percentile(std::vector<Real>& values, std::size_t percent)
{
    const auto at = values.begin() + static_cast<std::ptrdiff_t>((values.size() - 1) * percent / 100);
    std::nth_element(values.begin(), at, values.end());
    return *at;
}

}  // namespace sqmap
