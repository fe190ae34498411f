#include "bake/parts/refinement.h"

#include "sqmap/parallel/for_each.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>
#include <utility>

namespace sqmap::bake {

namespace {

/// Volume that patch and caps enclose, by the divergence theorem.
double enclosed_volume(const mesh::Mesh& mesh, const PartWork& part)
{
    double six = 0;
    const auto add = [&](Vec3d a, Vec3d b, Vec3d c) { six += dot(a, cross(b, c)); };
    for (const std::uint32_t t : part.triangles) {
        const mesh::Triangle& tri = mesh.triangles[t];
        add(mesh.vertices[tri[0]], mesh.vertices[tri[1]], mesh.vertices[tri[2]]);
    }
    for (const CapTriangle& t : part.caps) add(t[0], t[1], t[2]);
    return six / 6;
}

/// Share of a part's area that other surface hides from its projection centre (section 5's Q2 for this projection).
double hidden_share(const SurfaceContext& context, const PartWork& part)
{
    const Vec3d centre = cast<double>(part.centre);
    const int start = context.bvh.winding_number(centre);
    double hidden = 0, seen = 0;
    std::vector<mesh::Bvh::Crossing> crossings;
    const std::size_t stride = std::max<std::size_t>(1, part.ordered.size() / 200);
    for (std::size_t i = 0; i < part.ordered.size(); i += stride) {
        const std::uint32_t t = part.ordered[i];
        const Vec3d to = mesh::triangle_centroid(context.mesh, t) - centre;
        if (!context.bvh.ray_crossings(centre, to, crossings)) continue;
        // Visible if the first change of verdict on the ray is at the triangle itself.
        int winding = start;
        bool visible = false;
        for (const mesh::Bvh::Crossing& c : crossings) {
            const int next = winding - c.sign;
            if ((next > 0) != (winding > 0)) {
                visible = c.triangle == t;
                break;
            }
            winding = next;
        }
        (visible ? seen : hidden) += mesh::triangle_area(context.mesh, t);
    }
    return hidden + seen > 0 ? hidden / (hidden + seen) : 0;
}

/// Patch and caps of a part as one surface, for certificates.
struct Held {
    std::vector<Vec3d> points;
    std::vector<mesh::Triangle> triangles;
};

Held held_by(const mesh::Mesh& mesh, std::span<const std::uint32_t> patch, std::span<const CapTriangle> caps)
{
    Held held;
    for (const CapTriangle& t : caps) {
        const auto first = static_cast<std::uint32_t>(held.points.size());
        held.triangles.push_back({first, first + 1, first + 2});
        held.points.insert(held.points.end(), t.begin(), t.end());
    }
    std::vector<std::uint32_t> vertices;
    for (const std::uint32_t t : patch) vertices.insert(vertices.end(), mesh.triangles[t].begin(), mesh.triangles[t].end());
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    const auto first = static_cast<std::uint32_t>(held.points.size());
    for (const std::uint32_t v : vertices) held.points.push_back(mesh.vertices[v]);
    for (const std::uint32_t t : patch) {
        mesh::Triangle& triangle = held.triangles.emplace_back();
        for (std::size_t k = 0; k < 3; ++k)
            triangle[k] =
                first + static_cast<std::uint32_t>(std::lower_bound(vertices.begin(), vertices.end(), mesh.triangles[t][k]) -
                                                   vertices.begin());
    }
    return held;
}

/// The fit, made in the canonical frame so that turning the mesh changes it by rounding only, and certified in the
/// model's: turned back, rounded to float, and enlarged by what that costs.
fit::FitReport fit_part(const SurfaceContext& context, const PartWork& part, const BakeOptions& options)
{
    std::vector<CapTriangle> turned = part.caps;
    for (CapTriangle& t : turned)
        for (Vec3d& p : t) p = context.frame * p;
    const auto key = [](const CapTriangle& t) {
        const Vec3d c = t[0] + t[1] + t[2];
        return std::tuple(c.x, c.y, c.z);
    };
    std::stable_sort(turned.begin(), turned.end(), [&](const CapTriangle& l, const CapTriangle& r) { return key(l) < key(r); });
    fit::FitReport report = fit::fit_bounding(context.canonical, part.ordered, turned, options.fit);

    const Held held = held_by(context.mesh, part.triangles, part.caps);
    const auto narrow = [](double v) { return static_cast<double>(static_cast<float>(v)); };
    const shape::Superquadricd fitted = report.superquadric;
    for (double slack = 0; slack<0.1; slack = slack> 0 ? 2 * slack : 1e-6) {
        shape::Superquadricd sq = fitted;
        const Mat3d rotation = fitted.rotation * context.frame;
        const Vec3d translation = transpose_mul(context.frame, fitted.translation);
        for (int i = 0; i < 3; ++i) {
            for (int k = 0; k < 3; ++k) sq.rotation.row[i][k] = narrow(rotation.row[i][k]);
            sq.translation[i] = narrow(translation[i]);
            sq.a[i] = narrow(fitted.a[i] * (1 + slack));
        }
        sq.bend = narrow(fitted.bend / (1 + slack));
        const fit::Certificate certificate = fit::certify(sq, held.points, held.triangles);
        if (certificate.largest_f > 1 - fit::float_margin(sq)) continue;
        report.superquadric = sq;
        report.certificate = certificate;
        report.certificate.bounding = true;
        report.volume = fit::volume(sq);
        return report;
    }
    // Turning cost more than a tenth: fit in the model's own frame instead.
    return fit::fit_bounding(context.mesh, part.triangles, part.caps, options.fit);
}

}  // namespace

void fit_and_centre(const SurfaceContext& context, PartWork& part, const BakeOptions& options)
{
    part.ordered = part.triangles;
    std::sort(part.ordered.begin(), part.ordered.end(),
              [&](std::uint32_t l, std::uint32_t r) { return context.canonical.triangles[l] < context.canonical.triangles[r]; });
    part.fit = fit_part(context, part, options);
    part.centre = choose_centre(context, part.fit.superquadric, part.ordered);
}

void finish(const SurfaceContext& context, PartWork& part, const BakeOptions& options)
{
    fit_and_centre(context, part, options);
    part.area = 0;
    for (const std::uint32_t t : part.triangles) part.area += mesh::triangle_area(context.mesh, t);
    part.solid_volume = enclosed_volume(context.mesh, part);
    part.q2_share = hidden_share(context, part);
}

fit::Certificate certify_part(const mesh::Mesh& mesh, const PartWork& part, const shape::Superquadricd& superquadric)
{
    const Held held = held_by(mesh, part.triangles, part.caps);
    return fit::certify(superquadric, held.points, held.triangles);
}

namespace {

std::vector<std::vector<std::uint32_t>> triangles_of(const decompose::Partition& partition)
{
    std::vector<std::vector<std::uint32_t>> triangles(partition.part_count);
    for (std::uint32_t t = 0; t < partition.part_of_triangle.size(); ++t) triangles[partition.part_of_triangle[t]].push_back(t);
    return triangles;
}

/// Parts of a changed partition; what was fitted before is taken from history, what was not is added to it.
/// hopeless(known parts): the change is not worth having, whatever the parts that are still to be fitted cost; asked
/// after each fit. Nothing is returned then. Several threads fit ahead, but what is kept does not depend on it.
template <class Hopeless>
std::optional<std::vector<PartWork>> update(const SurfaceContext& context, const decompose::Partition& partition,
                                            std::vector<PartWork>& history, const BakeOptions& options, Hopeless&& hopeless)
{
    std::vector<std::vector<std::uint32_t>> triangles = triangles_of(partition);
    std::vector<std::vector<CapTriangle>> caps = cap_parts(context.mesh, partition);
    std::vector<PartWork> parts(partition.part_count);
    std::vector<std::uint8_t> known(parts.size(), 0);
    parallel::for_each(parts.size(), options.threads, [&](std::size_t i) {
        PartWork& part = parts[i];
        // The same surface may have been fitted with other caps: the tightest that holds today's caps will do.
        std::vector<const PartWork*> same;
        for (const PartWork& o : history)
            if (o.triangles == triangles[i]) same.push_back(&o);
        std::stable_sort(same.begin(), same.end(),
                         [](const PartWork* l, const PartWork* r) { return l->fit.volume < r->fit.volume; });
        Held held;
        for (const PartWork* o : same) {
            if (o->caps == caps[i]) {
                part = *o;
                known[i] = 1;
                return;
            }
            if (held.points.empty()) held = held_by(context.mesh, triangles[i], caps[i]);
            const fit::Certificate certificate = fit::certify(o->fit.superquadric, held.points, held.triangles);
            if (certificate.largest_f > 1 - fit::float_margin(o->fit.superquadric)) continue;
            part = *o;
            part.caps = std::move(caps[i]);
            part.fit.certificate = certificate;
            part.solid_volume = enclosed_volume(context.mesh, part);
            known[i] = 1;
            return;
        }
        part.triangles = std::move(triangles[i]);
        part.caps = std::move(caps[i]);
    });
    std::vector<std::size_t> unknown;
    for (std::size_t i = 0; i < parts.size(); ++i)
        if (known[i] == 0) unknown.push_back(i);
    const std::size_t ahead = std::max<std::size_t>(1, parallel::thread_count(options.threads));
    const auto give_up = [&] {
        std::vector<const PartWork*> finished;
        for (std::size_t i = 0; i < parts.size(); ++i)
            if (known[i] != 0) finished.push_back(&parts[i]);
        return hopeless(finished);
    };
    if (give_up()) return std::nullopt;
    for (std::size_t first = 0; first < unknown.size(); first += ahead) {
        const std::size_t count = std::min(ahead, unknown.size() - first);
        parallel::for_each(count, options.threads, [&](std::size_t i) { finish(context, parts[unknown[first + i]], options); });
        for (std::size_t i = 0; i < count; ++i) {
            history.push_back(parts[unknown[first + i]]);
            known[unknown[first + i]] = 1;
            if (give_up()) return std::nullopt;
        }
    }
    return parts;
}

/// All parts of a partition.
std::vector<PartWork> update(const SurfaceContext& context, const decompose::Partition& partition, std::vector<PartWork>& history,
                             const BakeOptions& options)
{
    return *update(context, partition, history, options, [](const auto&) { return false; });
}

constexpr double k_least_cost = 0.005;  ///< no cut is tried for a part that costs less

/// What a part costs: the volume its superquadric adds to the solid's own, and the area its projection cannot see.
/// Both as shares of the whole object, so that a badly served finger does not outweigh a badly served torso.
double cost(const PartWork& part, double all_volume, double all_area)
{
    const double loose = std::max(0.0, part.fit.volume - std::max(0.0, part.solid_volume)) / all_volume;
    return loose + 2 * part.q2_share * part.area / all_area;
}

}  // namespace

std::vector<PartWork> fit_parts(const SurfaceContext& context, const decompose::Partition& partition, const BakeOptions& options)
{
    std::vector<PartWork> history;
    return update(context, partition, history, options);
}

void refine_parts(const SurfaceContext& context, decompose::Partition& partition, std::vector<PartWork>& parts,
                  const BakeOptions& options)
{
    double all_area = 0, all_volume = 0;
    for (const PartWork& part : parts) {
        all_area += part.area;
        all_volume += part.solid_volume;
    }
    if (!(all_volume > 0)) all_volume = 1;
    const auto total = [&](const std::vector<const PartWork*>& p) {
        double sum = 0;
        for (const PartWork* part : p) sum += cost(*part, all_volume, all_area);
        return sum;
    };
    const auto total_now = [&] {
        double sum = 0;
        for (const PartWork& part : parts) sum += cost(part, all_volume, all_area);
        return sum;
    };
    // Looseness of a part relative to its own solid: a box in a box-like superquadric has about 1.2, a bent or forked
    // part well above 2.
    const auto loose = [](const PartWork& p) { return p.fit.volume / std::max(p.solid_volume, 1e-3 * p.fit.volume); };
    const decompose::Cutter cutter(context.mesh);
    std::vector<PartWork> history = parts;
    std::vector<std::vector<std::uint32_t>> given_up;
    while (parts.size() < options.max_parts) {
        std::size_t worst = parts.size();
        double worst_cost = k_least_cost;
        for (std::size_t i = 0; i < parts.size(); ++i) {
            const bool needs = loose(parts[i]) > options.max_looseness || parts[i].q2_share > options.max_q2_share;
            if (!needs || std::find(given_up.begin(), given_up.end(), parts[i].triangles) != given_up.end()) continue;
            if (const double c = cost(parts[i], all_volume, all_area); c > worst_cost) {
                worst_cost = c;
                worst = i;
            }
        }
        if (worst == parts.size()) break;
        decompose::Split split = cutter.split(partition, static_cast<std::uint32_t>(worst), options.decompose);
        bool kept = false;
        if (split.found && split.partition.part_count <= options.max_parts) {
            // Slivers of surface whose superquadrics are mostly air are no parts, even where the sum looks better.
            const double limit = std::max(options.max_looseness, 1.2 * loose(parts[worst]));
            const auto is_sliver = [&](const PartWork* p) {
                return loose(*p) > limit &&
                       std::none_of(parts.begin(), parts.end(), [&](const PartWork& o) { return o.triangles == p->triangles; });
            };
            const double least = total_now() - options.split_gain * worst_cost;
            std::optional<std::vector<PartWork>> next =
                update(context, split.partition, history, options, [&](const std::vector<const PartWork*>& finished) {
                    return !(total(finished) < least) || std::any_of(finished.begin(), finished.end(), is_sliver);
                });
            if (next) {
                partition = std::move(split.partition);
                parts = std::move(*next);
                kept = true;
            }
        }
        if (!kept) given_up.push_back(parts[worst].triangles);
    }
    // Undo own cuts that one superquadric serves as well.
    for (bool again = true; again;) {
        again = false;
        for (const decompose::Boundary& b : partition.boundaries) {
            if (b.kind != decompose::CutKind::Error) continue;
            const decompose::Partition merged = cutter.merge(partition, b.part_a, b.part_b);
            const double most = total_now();
            std::optional<std::vector<PartWork>> next =
                update(context, merged, history, options,
                       [&](const std::vector<const PartWork*>& finished) { return total(finished) > most; });
            if (!next) continue;
            partition = merged;
            parts = std::move(*next);
            again = true;
            break;
        }
    }
    partition = cutter.ordered_by_area(partition);
    parts = update(context, partition, history, options);
}

}  // namespace sqmap::bake
