// A skin and points between two frames: as swept.cpp, with the lattice posed in between.
#include "sqmap/query/skin.h"

#include "crossing.h"
#include "sqmap/math/assert.h"

#include <algorithm>
#include <cmath>

namespace sqmap::query {

namespace {

bool meets(const PosedSkin::Box& box, Vec3d a, Vec3d b, double slack)
{
    for (int k = 0; k < 3; ++k)
        if (!(std::max(a[k], b[k]) >= box.lo[k] - slack && std::min(a[k], b[k]) <= box.hi[k] + slack)) return false;
    return true;
}

}  // namespace

struct SkinSweep {
    const SweptSkinQuery& query;
    const SweptOptions& options;
    SkinWorkspace& workspace;
    std::span<SkinContact> contacts;
    MovingSkin& skin = *query.skin;
    const std::span<const Vec3d> previous = query.previous, now = query.now;
    const std::span<const std::uint8_t> active = query.active;

    SweptResult run() noexcept
    {
        SweptResult result;
        if (now.size() != workspace.size_ || previous.size() != now.size()) return result;
        result.probe = query_skin({query.bound, &skin.to(), now, active}, options.query, workspace, contacts);
        double longest = 0;
        for (std::size_t i = 0; i < now.size(); ++i) {
            workspace.fast_[i] = 0;
            if (active.size() == now.size() && active[i] == 0) continue;
            const double path = norm(now[i] - previous[i]) + skin.motion();
            if (!(path > options.step && std::isfinite(path))) continue;
            if (!meets(skin.to().box(), previous[i], now[i], skin.motion())) continue;
            workspace.fast_[i] = 1;
            ++result.fast;
            longest = std::max(longest, path);
        }
        if (result.fast == 0) return result;

        std::size_t count = std::min(result.probe.contacts, contacts.size());
        std::fill(workspace.contact_.begin(), workspace.contact_.end(), k_no_contact);
        for (std::size_t c = 0; c < count; ++c) workspace.contact_[contacts[c].index] = static_cast<std::uint32_t>(c);
        const double wanted = std::ceil(longest / options.step);
        const auto steps = static_cast<std::uint32_t>(std::min(wanted, std::max(1.0, static_cast<double>(options.max_steps))));
        if (wanted > steps) result.probe.status |= k_coarse;
        for (std::uint32_t step = 1; step < steps; ++step, ++result.positions) {
            const double share = static_cast<double>(step) / steps;
            for (std::size_t b = 0; b < skin.maps_.size(); ++b) {
                const Affine &from = skin.from_.maps()[b], &to = skin.to_.maps()[b];
                for (int k = 0; k < 3; ++k)
                    skin.maps_[b].linear.row[k] = from.linear.row[k] + share * (to.linear.row[k] - from.linear.row[k]);
                skin.maps_[b].shift = from.shift + share * (to.shift - from.shift);
            }
            (void)skin.between_.pose(skin.maps_);
            for (std::size_t i = 0; i < now.size(); ++i) workspace.at_[i] = previous[i] + share * (now[i] - previous[i]);
            const ProbeResult found = query_skin({query.bound, &skin.between_, workspace.at_, workspace.fast_}, options.query,
                                                 workspace, workspace.swept_);
            result.probe.status |= static_cast<std::uint8_t>(found.status & ~k_full);
            for (std::size_t f = 0; f < std::min(found.contacts, workspace.swept_.size()); ++f)
                if (workspace.fast_[workspace.swept_[f].index] == 1) take(workspace.swept_[f], count, result);
        }
        return result;
    }

    /// A contact on the path counts where the end lies behind its surface and the end's own contact leads another path.
    void take(SkinContact c, std::size_t& count, SweptResult& result) const noexcept
    {
        Affine first, last;
        if (!skin.from_.carry_forward(c.bound_witness, first) || !skin.to_.carry_forward(c.bound_witness, last)) return;
        const Vec3d surface = apply(last, c.bound_witness), normal = carried_normal(last, c.bound_normal);
        const Vec3d start = previous[c.index] - apply(first, c.bound_witness), end = now[c.index] - surface;
        if (!(dot(normalized(start - end), normal) > k_head_on)) return;
        const double behind = -dot(end, normal);
        if (!(behind > 0)) return;
        const std::uint32_t own = workspace.contact_[c.index];
        if (own != k_no_contact && dot(contacts[own].normal, normal) > 0) return;
        c.normal = normal;
        c.depth = behind;
        c.witness = now[c.index] + behind * normal;
        workspace.fast_[c.index] = 2;  // the first crossing counts
        keep_crossing(c, own, contacts, count, result);
    }
};

SweptResult query_swept_skin(const SweptSkinQuery& query, const SweptOptions& options, SkinWorkspace& workspace,
                             std::span<SkinContact> contacts) noexcept
{
    SQMAP_ASSERT(!options.query.offset && !(options.query.margin > 0));
    SQMAP_ASSERT(query.skin != nullptr);
    if (query.bound == nullptr) return {};
    return SkinSweep{query, options, workspace, contacts}.run();
}

}  // namespace sqmap::query
