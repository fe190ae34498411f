#include "common/dress/costumes.h"

namespace sqmap::app {

Costume costume(std::string_view name, std::uint32_t vertices)
{
    if (name == "skirt")
        return {sim::skirt({.centre = {0, 1.08, 0}, .waist_radius = 0.155, .length = 0.5, .vertices = vertices}), "pelvis"};
    if (name == "poncho")
        return {sim::sheet(
                    {.centre = {0, 1.56, 0}, .width = 1.1, .depth = 1.1, .hole_x = 0.13, .hole_z = 0.13, .vertices = vertices}),
                ""};
    return {sim::shirt({.collar = {0, 1.53, 0},
                        .chest = 0.52,
                        .length = 0.62,
                        .span = 1.0,
                        .sleeve = 0.24,
                        .neck = 0.24,
                        .gap = 0.14,
                        .vertices = vertices}),
            ""};
}

}  // namespace sqmap::app
