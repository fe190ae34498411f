// E. Coumans, "Contact generation", GDC 2010, keeps four contacts of a manifold by depth and area; here any number.
#include "manifold.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace sqmap::query {
namespace {

struct Planar {
    double x, y;
};
double area(Planar a, Planar b, Planar c) { return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x); }

/// A convex polygon, counter-clockwise, that grows by points.
class Outline {
public:
    static constexpr std::size_t k_max = 8;

    explicit Outline(Planar first) : corner_{first} {}

    [[nodiscard]] std::size_t size() const { return size_; }
    /// Twice the area that a point adds; of a segment, and of a single point, its length squared comes first.
    [[nodiscard]] double gain(Planar p) const
    {
        if (size_ == 1) return distance_sq(corner_[0], p);
        double sum = 0;
        for (std::size_t i = 0; i < size_; ++i) sum += std::max(-area(corner_[i], corner_[(i + 1) % size_], p), 0.);
        return sum;
    }
    void add(Planar p)
    {
        std::array<Planar, k_max> all = corner_;
        std::size_t count = size_;
        if (count == k_max) return;
        all[count++] = p;
        // The hull of few points, corner after corner (R. A. Jarvis, 1973).
        const auto lowest =
            static_cast<std::size_t>(std::min_element(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(count),
                                                      [](Planar a, Planar b) { return a.y != b.y ? a.y < b.y : a.x < b.x; }) -
                                     all.begin());
        size_ = 0;
        std::size_t at = lowest;
        do {
            corner_[size_++] = all[at];
            std::size_t next = at == 0 && count > 1 ? 1 : 0;
            for (std::size_t i = 0; i < count; ++i) {
                const double turn = area(all[at], all[next], all[i]);
                if (turn < 0 || (turn == 0 && distance_sq(all[at], all[i]) > distance_sq(all[at], all[next]))) next = i;
            }
            at = next;
        } while (at != lowest && size_ < count);
    }

private:
    static double distance_sq(Planar a, Planar b) { return (a.x - b.x) * (a.x - b.x) + (a.y - b.y) * (a.y - b.y); }

    std::array<Planar, k_max> corner_{};
    std::size_t size_ = 1;
};

/// Positions in the plane beside a normal, from an origin.
class PlaneMap {
public:
    PlaneMap(Vec3d origin, Vec3d normal) : origin_(origin)
    {
        const Vec3d beside = std::abs(normal.x) < 0.6 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
        u_ = normalized(cross(beside, normal));
        v_ = cross(normal, u_);
    }
    [[nodiscard]] Planar operator()(const SurfaceContact& c) const
    {
        const Vec3d d = c.witness.on_a - origin_;
        return {dot(d, u_), dot(d, v_)};
    }

private:
    Vec3d origin_, u_, v_;
};

/// The contact with the largest value, the first of equals; contacts.size() where none is above zero.
template <class Value>
std::size_t largest(std::span<const SurfaceContact> contacts, std::size_t first, Value&& value)
{
    std::size_t best = contacts.size();
    double best_value = 0;
    for (std::size_t i = first; i < contacts.size(); ++i)
        if (const double v = value(contacts[i]); v > best_value) {
            best = i;
            best_value = v;
        }
    return best;
}

}  // namespace

std::size_t keep_spanning(std::span<SurfaceContact> contacts, std::size_t count) noexcept
{
    if (contacts.size() <= count || count == 0) return std::min(contacts.size(), count);
    // Faces that only touch have many that are as deep, at their borders against side faces too: most bear the same way.
    Vec3f sum{};
    for (const SurfaceContact& c : contacts) sum = sum + c.normal;
    const auto deepest =
        std::max_element(contacts.begin(), contacts.end(), [&](const SurfaceContact& a, const SurfaceContact& b) {
            return a.depth != b.depth ? a.depth < b.depth : dot(a.normal, sum) < dot(b.normal, sum);
        });
    std::swap(contacts.front(), *deepest);
    const Vec3f normal = contacts.front().normal;
    const PlaneMap planar(contacts.front().witness.on_a, cast<double>(normal));
    Outline outline(planar(contacts.front()));
    std::size_t kept = 1;
    for (; kept < std::min(count, Outline::k_max); ++kept) {
        // The contact that bears as the deepest one does comes first of several at one position.
        const auto gain = [&](const SurfaceContact& c) {
            return (2 + static_cast<double>(dot(c.normal, normal))) * outline.gain(planar(c));
        };
        const std::size_t next = largest(contacts, kept, gain);
        if (next == contacts.size()) break;
        std::swap(contacts[kept], contacts[next]);
        outline.add(planar(contacts[kept]));
    }
    for (; kept < count; ++kept) {
        const std::size_t next = largest(contacts, kept, [&](const SurfaceContact& c) {
            double nearest = std::numeric_limits<double>::infinity();
            for (const SurfaceContact& k : contacts.first(kept))
                nearest = std::min(nearest, norm_sq(k.witness.on_a - c.witness.on_a));
            return nearest;
        });
        if (next == contacts.size()) break;  // the rest is where others are
        std::swap(contacts[kept], contacts[next]);
    }
    return kept;
}

}  // namespace sqmap::query
