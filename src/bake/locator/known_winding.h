// Sides of points near a point whose side is known.
#pragma once

#include "sqmap/mesh/solid.h"

#include <optional>

namespace sqmap::bake {

/// The winding number about one point, found when it is first needed, from which those about points nearby follow by the few
/// crossings between. Not thread-safe.
class KnownWinding {
public:
    /// distance: of the boundary from the point. outer: a point nearby, which outlives this, or null.
    KnownWinding(const mesh::Solid& solid, Vec3d point, double distance, const KnownWinding* outer = nullptr)
        : solid_(solid), point_(point), outer_(outer), on_surface_(!(distance > 0))
    {
    }

    [[nodiscard]] const mesh::Solid& solid() const { return solid_; }
    /// About p; exact for points off the surface.
    [[nodiscard]] int at(Vec3d p) const
    {
        if (!winding_ && !on_surface_) winding_ = from_outer(point_);
        if (winding_)
            if (const std::optional<int> change = solid_.bvh().winding_change(point_, p)) return *winding_ + *change;
        return from_outer(p);
    }

private:
    int from_outer(Vec3d p) const { return outer_ != nullptr ? outer_->at(p) : solid_.bvh().winding_number(p); }

    const mesh::Solid& solid_;
    Vec3d point_;
    const KnownWinding* outer_;
    bool on_surface_;
    mutable std::optional<int> winding_;
};

}  // namespace sqmap::bake
