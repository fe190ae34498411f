#include "query/distance/mapped_surface.h"

#include "model/bound_tree.h"
#include "model/hierarchy.h"
#include "query/dispatch/model_point.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace sqmap::query {
namespace {

/// Searches outside the solid; it keeps the nearest surface that it found.
class NearestSearch {
public:
    NearestSearch(const model::ModelView& model, Vec3f p) : model_(model), p_(p) {}

    std::optional<MappedSurface> nearest()
    {
        // The nearest samples in directions that differ: one of them leads to the nearest surface.
        constexpr std::size_t k_starts = 4;
        Vec3f directions[k_starts];
        for (std::size_t i = 0; i < k_starts; ++i) {
            const model::SurfaceSample* sample = nearest_sample({directions, i});
            if (sample == nullptr) break;
            const Vec3f at = model::sample_point(model_.distance.header, *sample);
            directions[i] = normalized(p_ - at);
            offer(at, directions[i], -1);
            approach(at - below() * model::decode_axis(sample->normal[0], sample->normal[1]));
        }
        return found_;
    }

private:
    /// The nearest sample that does not lie in about one of some directions from the point; null where there is none.
    const model::SurfaceSample* nearest_sample(std::span<const Vec3f> directions) const
    {
        constexpr float k_alike = 0.9f;
        const model::SurfaceSample* nearest = nullptr;
        float least = INFINITY;
        for (const model::SurfaceSample& sample : model_.distance.samples) {
            const Vec3f d = p_ - model::sample_point(model_.distance.header, sample);
            const float d_sq = norm_sq(d);
            if (!(d_sq < least)) continue;
            const float alike = k_alike * std::sqrt(d_sq);
            if (std::any_of(directions.begin(), directions.end(), [&](Vec3f n) { return dot(n, d) >= alike; })) continue;
            least = d_sq;
            nearest = &sample;
        }
        return nearest;
    }

    /// How far below the surface layer 3 is queried for it.
    float below() const { return 0.004f * static_cast<float>(model_.header.r_max); }

    /// Takes a point of the surface where it is nearer than what was found before; true then. direction: from there to the
    /// queried point, unit.
    bool offer(Vec3f at, Vec3f direction, std::int32_t part)
    {
        const float away = norm(p_ - at);
        if (!(away < (found_ ? found_->distance : INFINITY))) return false;
        found_ = MappedSurface{away, direction, at, part};
        return true;
    }

    /// Layer 3 finds the surface above a point in the solid; the search repeats from a point just below the surface found.
    void approach(Vec3f start)
    {
        constexpr int k_rounds = 10;
        Vec3f last = start;
        for (int round = 0; round < k_rounds; ++round) {
            const ModelContact c = query_in_model(model_, start, {});
            const Vec3f to_point = p_ - c.witness;
            const float away = norm(to_point);
            const Vec3f direction = away > 1e-4f * model_.header.sphere[3] ? (1 / away) * to_point : c.normal;
            const bool is_known = c.contact && (c.status & k_no_surface) == 0;
            // The first leads on though it is no nearer than the sample.
            if (is_known && (offer(c.witness, direction, c.part) || round == 0)) {
                last = start;
                // Along the tangent plane to the foot of the queried point, and below it.
                start = p_ - dot(to_point, c.normal) * c.normal - below() * c.normal;
            } else if (round == 0) {
                return;
            } else {
                start = 0.5f * (start + last);
            }
        }
    }

    const model::ModelView& model_;
    const Vec3f p_;
    std::optional<MappedSurface> found_;
};

}  // namespace

std::optional<MappedSurface> nearest_mapped_surface(const model::ModelView& model, Vec3f p)
{
    const ModelContact contact = model.header.solid != 0 ? query_in_model(model, p, {}) : ModelContact{};
    if (!contact.contact) return NearestSearch(model, p).nearest();
    if ((contact.status & k_no_surface) != 0) return std::nullopt;
    return MappedSurface{-contact.depth, contact.normal, contact.witness, contact.part};
}

}  // namespace sqmap::query
