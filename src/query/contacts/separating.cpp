// The least of what is known: hulls, and the directions of contacts.
#include "sqmap/query/separating.h"

#include "hull_depth.h"
#include "parting.h"
#include "query/probe/triangle_tree.h"
#include "sqmap/query/distance.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sqmap::query {

namespace {

/// The bits of what forbids a search; k_ok where nothing does.
std::uint16_t refusal(const Body& a, const Body& b, const SeparatingWorkspace& workspace)
{
    if (!is_finite(a.pose) || !is_finite(b.pose) || !(norm(b_in_a(a, b).shift) < 1e150)) return k_not_finite;
    if (!has_triangles(a) || !has_triangles(b)) return k_no_triangles;
    return workspace.holds(*a.probe, *b.probe) ? k_ok : k_full;
}

}  // namespace

class LeastTranslation {
public:
    LeastTranslation(const Body& a, const Body& b, SeparatingWorkspace& workspace)
        : a_(a), b_(b), tree_a_(a.probe->triangles()), tree_b_(b.probe->triangles()), move_(b_in_a(a, b)), workspace_(workspace)
    {
    }

    /// direction: unit, in a's frame.
    SeparatingTranslation along(Vec3d direction)
    {
        SeparatingTranslation out;
        out.direction = direction;
        PartingSearch search(tree_a_, tree_b_, move_, direction, workspace_);
        if (!search.run(out.distance)) {
            out.status = k_full;
            return out;
        }
        out.at_least = std::max(out.distance - search.error(), 0.);
        out.exact = true;
        return out;
    }

    SeparatingTranslation least()
    {
        HullDepth hulls(tree_a_, tree_b_, move_, workspace_);
        hulls.run();
        SeparatingTranslation best;
        best.direction = hulls.direction();
        best.distance = hulls.upper();
        if (best.distance == 0) {
            best.exact = true;
            return best;
        }
        if (hulls.is_exact() && is_convex(tree_a_) && is_convex(tree_b_)) {
            best.at_least = hulls.lower();
            best.exact = true;
            return best;
        }
        // Models add vertices to the contacts, which bound the translation from below.
        const ContactResult found = query_contacts(a_, b_, {}, workspace_.contacts_);
        best.at_least = std::min(least_by_vertices(found.contacts), best.distance);
        try_directions(found.contacts, best);
        best.at_least = std::min(best.at_least, best.distance);
        return best;
    }

private:
    static constexpr std::size_t k_max_directions = 16;

    bool is_convex(const TriangleTree& tree) { return query::is_convex(tree, workspace_); }

    /// A point of a solid that is so deep in the other has to leave it.
    [[nodiscard]] double least_by_vertices(std::span<const SurfaceContact> contacts) const
    {
        const SurfaceContact* deepest[2] = {nullptr, nullptr};
        for (const SurfaceContact& c : contacts)
            if (c.feature_a == Feature::Vertex || c.feature_b == Feature::Vertex) {
                const int of_b = c.index_a == k_unnamed ? 1 : 0;
                if (deepest[of_b] == nullptr || c.depth > deepest[of_b]->depth) deepest[of_b] = &c;
            }
        double least = 0;
        const double sizes = norm(size(tree_a_.box())) + norm(size(tree_b_.box()));
        for (int of_b = 0; of_b < 2; ++of_b) {
            const Body &touched = of_b != 0 ? a_ : b_, &collider = of_b != 0 ? b_ : a_;
            if (deepest[of_b] == nullptr || touched.model == nullptr) continue;
            const std::uint32_t vertex = of_b != 0 ? deepest[of_b]->index_b : deepest[of_b]->index_a;
            if (vertex >= collider.probe->triangles().points()) continue;
            const SignedDistance d = exact_distance(touched, apply(collider.pose, collider.probe->triangles().point(vertex)));
            const double error = d.known == DistanceKind::Exact ? 1e-12 : 1e-6;
            if (d.known == DistanceKind::Exact || d.known == DistanceKind::ExactInFloat)
                least = std::max(least, -d.distance - error * sizes);
        }
        return least;
    }

    /// Along the normals of contacts, the deepest first, none near one that was tried.
    void try_directions(std::span<const SurfaceContact> contacts, SeparatingTranslation& best)
    {
        Vec3f tried[k_max_directions];
        for (std::size_t count = 0; count < k_max_directions; ++count) {
            const SurfaceContact* next = nullptr;
            for (const SurfaceContact& c : contacts) {
                const bool is_new = std::none_of(tried, tried + count, [&](Vec3f n) { return dot(n, c.normal) > 0.99f; });
                if (is_new && norm(c.normal) > 0.5f && (next == nullptr || c.depth > next->depth)) next = &c;
            }
            if (next == nullptr) return;
            tried[count] = next->normal;
            const SeparatingTranslation found = along(normalized(transpose_mul(a_.pose.rotation, cast<double>(next->normal))));
            if (found.status != k_ok || !(found.distance < best.distance)) continue;
            best.distance = found.distance;
            best.direction = found.direction;
        }
    }

    const Body &a_, &b_;
    const TriangleTree &tree_a_, &tree_b_;
    const Affine move_;
    SeparatingWorkspace& workspace_;
};

SeparatingTranslation separating_translation(const Body& a, const Body& b, Vec3d direction,
                                             SeparatingWorkspace& workspace) noexcept
{
    SeparatingTranslation out;
    out.status = refusal(a, b, workspace);
    const double largest = std::max({std::abs(direction.x), std::abs(direction.y), std::abs(direction.z)});
    if (!(largest > 0) || !std::isfinite(largest)) out.status |= k_not_finite;
    if (out.status != k_ok) return out;
    const Vec3d unit = normalized(direction / largest);
    out = LeastTranslation(a, b, workspace).along(normalized(transpose_mul(a.pose.rotation, unit)));
    out.direction = unit;
    return out;
}

SeparatingTranslation least_separating_translation(const Body& a, const Body& b, SeparatingWorkspace& workspace) noexcept
{
    SeparatingTranslation out;
    out.status = refusal(a, b, workspace);
    if (out.status != k_ok) return out;
    out = LeastTranslation(a, b, workspace).least();
    out.direction = a.pose.rotation * out.direction;
    return out;
}

}  // namespace sqmap::query
