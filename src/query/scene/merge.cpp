// Hashing into a grid of cells of twice the distance, so that eight cells hold all that is near: M. Teschner et al., Optimized
// spatial hashing for collision detection of deformable objects, VMV 2003.
#include "merge.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace sqmap::query {

namespace {

constexpr std::uint32_t k_end = 0xffffffffu;
constexpr float k_dropped = -1.f;  ///< depth of a contact that is left out

class Grid {
public:
    Grid(std::span<const PairContact> contacts, double distance, std::span<std::uint32_t> head, std::span<std::uint32_t> next)
        : origin_(contacts.front().witness.on_a), inverse_cell_(0.5 / distance), head_(head), next_(next)
    {
        std::fill(head.begin(), head.end(), k_end);
        for (std::size_t i = contacts.size(); i-- > 0;) {
            const Vec3d p = cell_of(contacts[i]);
            std::uint32_t& first = head_[slot(std::floor(p.x), std::floor(p.y), std::floor(p.z))];
            next_[i] = first;
            first = static_cast<std::uint32_t>(i);
        }
    }

    /// Calls visit for all contacts within the distance of c's end on a, and for some others.
    template <class Visit>
    void each_near(const PairContact& c, Visit&& visit) const
    {
        const Vec3d p = cell_of(c);
        const Vec3d lo{std::floor(p.x - 0.5), std::floor(p.y - 0.5), std::floor(p.z - 0.5)};
        for (int k = 0; k < 8; ++k) {
            const std::size_t at = slot(lo.x + (k & 1), lo.y + ((k >> 1) & 1), lo.z + (k >> 2));
            for (std::uint32_t i = head_[at]; i != k_end; i = next_[i]) visit(i);
        }
    }

private:
    Vec3d cell_of(const PairContact& c) const { return inverse_cell_ * (c.witness.on_a - origin_); }
    std::size_t slot(double x, double y, double z) const
    {
        const auto word = [](double v) { return static_cast<std::uint64_t>(static_cast<std::int64_t>(v)); };
        const std::uint64_t h = word(x) * 73856093u ^ word(y) * 19349663u ^ word(z) * 83492791u;
        return (h ^ h >> 20) & (head_.size() - 1);
    }

    Vec3d origin_;
    double inverse_cell_;
    std::span<std::uint32_t> head_, next_;
};

float deepest(std::span<const PairContact> contacts)
{
    float depth = 0.f;
    for (const PairContact& c : contacts) depth = std::max(depth, c.depth);
    return depth;
}

}  // namespace

std::size_t merge_mutual(std::span<PairContact> contacts, std::size_t split, const MergeRule& rule, std::span<std::uint32_t> head,
                         std::span<std::uint32_t> next) noexcept
{
    std::span<PairContact> few = contacts.first(split), many = contacts.subspan(split);
    if (few.empty() || many.empty()) return contacts.size();
    // The order follows the contacts, not which body is called a, so that the same contacts stay when the bodies are swapped.
    const auto order = [](std::span<const PairContact> side) {
        return std::tuple(side.size(), deepest(side), side.front().index);
    };
    if (order(few) > order(many)) std::swap(few, many);

    const double distance_sq = rule.distance * rule.distance;
    const Grid grid(many, rule.distance, head, next);
    for (PairContact& c : few) {
        double least = INFINITY;
        PairContact* twin = nullptr;
        grid.each_near(c, [&](std::uint32_t i) {
            PairContact& other = many[i];
            if (other.mutual || other.depth == k_dropped || !(dot(c.normal, other.normal) >= rule.cosine)) return;
            const double a_sq = norm_sq(c.witness.on_a - other.witness.on_a), b_sq = norm_sq(c.witness.on_b - other.witness.on_b);
            if (!(a_sq <= distance_sq && b_sq <= distance_sq)) return;
            // Lists may be visited twice, and their order is the grid's: ties go to the first contact.
            if (a_sq + b_sq > least || (a_sq + b_sq == least && &other >= twin)) return;
            least = a_sq + b_sq;
            twin = &other;
        });
        if (twin == nullptr) continue;
        PairContact& kept = std::tie(c.depth, c.index) > std::tie(twin->depth, twin->index) ? c : *twin;
        PairContact& left_out = &kept == &c ? *twin : c;
        kept.mutual = true;
        left_out.depth = k_dropped;
    }
    const auto end = std::remove_if(contacts.begin(), contacts.end(), [](const PairContact& c) { return c.depth == k_dropped; });
    return static_cast<std::size_t>(end - contacts.begin());
}

}  // namespace sqmap::query
