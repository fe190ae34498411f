#include "shape_options.h"

#include <cstdio>

namespace sqmap::app {
namespace {

constexpr std::size_t k_max_lines = 64;

std::string ratio_text(double ratio)
{
    char text[32];
    std::snprintf(text, sizeof text, "%.4g", ratio);
    return ratio >= 0 ? text : "-";
}

}  // namespace

void add_shape_option(Command& command, collider::ShapeChoice& choice)
{
    const auto take = [&choice](const std::string& text) {
        const std::optional<collider::ShapeChoice> named = collider::choice_named(text);
        if (!named)
            throw WrongUsage("--shape", "'" + text +
                                            "' is none of superquadric|ellipsoid|capsule|box|sphere|cylinder|hull|spheres:N, "
                                            "N from 1 to 4096");
        choice = *named;
    };
    command
        .text("--shape", take,
              "Shape of each part; spheres:N are at most N balls for the whole, whose greatest protrusion is small. A file that "
              "lacks the shape gets convex meshes")
        .type_name("superquadric|ellipsoid|capsule|box|sphere|cylinder|hull|spheres:N")
        .shows_default("hull");
}

void print_colliders(const collider::Colliders& colliders)
{
    const auto line = [](const std::string& name, const char* kind, const collider::Figures& f) {
        std::printf("  %-24s %-12s %8s %14.6g %12s\n", name.c_str(), kind, ratio_text(f.volume_ratio).c_str(), f.support_excess,
                    ratio_text(f.protrusion).c_str());
    };
    std::printf("  %-24s %-12s %8s %14s %12s\n", "part", "shape", "volume", "support excess", "protrusion");
    if (colliders.items.size() <= k_max_lines && colliders.items.size() > 1 && !colliders.is_cover())
        for (const collider::Colliders::Item& item : colliders.items)
            line(item.name, collider::name_of(item.shape.kind), item.figures);
    line("whole", (std::to_string(colliders.items.size()) + " shapes").c_str(), colliders.whole);
}

}  // namespace sqmap::app
