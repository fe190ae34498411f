#include "sqmap/query/swept.h"

#include "crossing.h"
#include "sqmap/math/assert.h"
#include "sqmap/math/rotation.h"

#include <algorithm>
#include <cmath>

namespace sqmap::query {

Pose between(const Pose& from, const Pose& to, double share) noexcept
{
    SQMAP_ASSERT(is_rotation(from.rotation) && is_rotation(to.rotation));
    if (!(share > 0)) return from;
    if (!(share < 1)) return to;
    const Vec3d turn = rotation_vector(to.rotation * transpose(from.rotation));
    return {rotation_by(share * turn) * from.rotation, from.translation + share * (to.translation - from.translation)};
}

struct SweptRun {
    const SweptQuery& query;
    const SweptOptions& options;
    SweptWorkspace& workspace;
    std::span<Contact> contacts;
    const std::span<const Vec3d> previous = query.previous, now = query.now;
    SweptResult result{};

    Vec3d start_of(std::uint32_t point) const { return apply(query.from, previous[point]); }
    Vec3d end_of(std::uint32_t point) const { return apply(query.to, now[point]); }

    /// The model's sphere where the frame ends, in the probe's frame, and how far the poses move points in it at most.
    struct Reach {
        Vec3d centre;
        double radius, motion;
    };
    Reach reach_of_model() const
    {
        const Sphere sphere = sphere_of({query.touched.model, nullptr, query.touched.pose});
        const Pose end = inverse(query.to), start = inverse(query.from);
        const Vec3d shift = apply(end, sphere.centre) - apply(start, sphere.centre);
        double turn_sq = 0;  // Frobenius norm, no less than the spectral
        for (int i = 0; i < 3; ++i) turn_sq += norm_sq(end.rotation.row[i] - start.rotation.row[i]);
        return {apply(end, sphere.centre), sphere.radius, norm(shift) + std::sqrt(turn_sq) * sphere.radius};
    }

    void run() noexcept
    {
        double longest = 0;
        const Reach reach = reach_of_model();
        const double slow = options.step - reach.motion;
        for (std::size_t i = 0; i < now.size(); ++i) {
            workspace.fast_[i] = 0;
            // Most points move too little, or are too far from the model, whatever the poses do to them.
            const double own_sq = norm_sq(now[i] - previous[i]);
            if (slow >= 0 && own_sq <= slow * slow) continue;
            const double far = reach.radius + std::sqrt(own_sq) + reach.motion;
            if (norm_sq(now[i] - reach.centre) > far * far) continue;
            const double path_sq = norm_sq(apply(query.to, now[i]) - apply(query.from, previous[i]));
            if (!(path_sq > options.step * options.step && std::isfinite(path_sq))) continue;
            workspace.fast_[i] = 1;
            ++result.fast;
            longest = std::max(longest, path_sq);
        }
        result.probe = query_probe(query.touched, {nullptr, query.probe, query.to}, options.query, contacts);
        if (result.fast == 0) return;

        std::size_t count = std::min(result.probe.contacts, contacts.size());
        std::fill(workspace.contact_.begin(), workspace.contact_.end(), k_no_contact);
        for (std::size_t c = 0; c < count; ++c) workspace.contact_[contacts[c].index] = static_cast<std::uint32_t>(c);
        const double wanted = std::ceil(std::sqrt(longest) / options.step);
        const auto steps = static_cast<std::uint32_t>(std::min(wanted, std::max(1.0, static_cast<double>(options.max_steps))));
        if (wanted > steps) result.probe.status |= k_coarse;
        const bool own_probe = workspace.probe_.size() == now.size();
        Probe& swept = own_probe ? workspace.probe_ : *query.probe;
        for (std::uint32_t step = 1; step < steps; ++step, ++result.positions) {
            const double share = static_cast<double>(step) / steps;
            const Pose pose = between(query.from, query.to, share);
            for (std::size_t i = 0; i < now.size(); ++i)
                if (workspace.fast_[i] == 1) workspace.at_[i] = previous[i] + share * (now[i] - previous[i]);
            swept.move(workspace.at_, workspace.fast_);
            const ProbeResult found = query_probe(query.touched, {nullptr, &swept, pose}, options.query, workspace.found_);
            result.probe.status |= static_cast<std::uint8_t>(found.status & ~k_full);
            for (std::size_t f = 0; f < std::min(found.contacts, workspace.found_.size()); ++f)
                if (workspace.fast_[workspace.found_[f].index] == 1) take(workspace.found_[f], count);
        }
        if (!own_probe) query.probe->move(now);
    }

    /// A contact on the path counts where the end lies behind its surface and the end's own contact leads another path.
    void take(Contact c, std::size_t& count) noexcept
    {
        // A point that slides over a bulge may end behind a plane without crossing the surface: only a head-on approach counts.
        const Vec3d end = end_of(c.index), start = start_of(c.index);
        if (!(dot(normalized(start - end), cast<double>(c.normal)) > k_head_on)) return;
        const double behind = dot(result.probe.position(c) - end, cast<double>(c.normal));
        if (!(behind > 0)) return;
        const std::uint32_t own = workspace.contact_[c.index];
        if (own != k_no_contact && dot(contacts[own].normal, c.normal) > 0.f) return;
        c.depth = static_cast<float>(behind);
        workspace.fast_[c.index] = 2;  // the first crossing counts
        keep_crossing(c, own, contacts, count, result);
    }
};

SweptResult query_swept(const SweptQuery& query, const SweptOptions& options, SweptWorkspace& workspace,
                        std::span<Contact> contacts) noexcept
{
    SQMAP_ASSERT(query.probe != nullptr && query.now.size() == query.probe->size() && query.previous.size() == query.now.size());
    if (query.touched.model == nullptr) return {};
    SweptRun run{query, options, workspace, contacts};
    run.run();
    return run.result;
}

}  // namespace sqmap::query
