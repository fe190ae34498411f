// K. Moustakas, D. Tzovaras, M. G. Strintzis, SQ-Map, IEEE TVCG 13(1), 2007, section 4.2: what all parts together say.
#include "sqmap/paper/projection.h"

#include <cmath>

namespace sqmap::paper {

CombinedAnswer combine(std::span<const PartAnswer> answers) noexcept
{
    CombinedAnswer combined;
    float least = 0;
    for (std::size_t i = 0; i < answers.size(); ++i) {
        const PartAnswer& answer = answers[i];
        if (is_witness(answer)) return {};
        if (answer.verdict != Verdict::Contact) continue;
        combined.contact = true;
        const bool surface = (answer.flags & (k_projection_cap | k_projection_miss)) == 0;
        if (surface && (!combined.has_surface || std::abs(answer.depth) < least)) {
            combined.has_surface = true;
            combined.part = static_cast<std::int32_t>(i);
            least = std::abs(answer.depth);
        } else if (combined.part < 0) {
            combined.part = static_cast<std::int32_t>(i);
        }
    }
    return combined;
}

}  // namespace sqmap::paper
