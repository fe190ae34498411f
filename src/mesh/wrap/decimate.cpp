// Garland, Heckbert, "Surface simplification using quadric error metrics", 1997, orders the collapses. Samples
// of the surface, which every triangle carries, bound how far they may move it (Klein, Liebich, Strasser 1996).
#include "steps.h"

#include "enclosed.h"
#include "symmetric.h"

#include "../surface.h"

#include "math/triangle.h"
#include "mesh/simplified.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <queue>
#include <tuple>

namespace sqmap::mesh {

namespace {

constexpr double k_free_share = 1e-3;   ///< share of the greatest eigenvalue below which a direction is free
constexpr double k_turn = 0.3;          ///< least cosine between a triangle's normals before and after
constexpr double k_shape = 0.02;        ///< height over longest side below which a triangle is not made worse
constexpr double k_length = 1e-5;       ///< weight of an edge's squared length, so that flat regions get even triangles
constexpr double k_far = 1;             ///< root mean square distance from the planes that is not tried, in allowed errors
constexpr double k_on_input = 1e-6;     ///< a vertex so near lies on the input
constexpr double k_outward = 0.5;       ///< allowed errors by which a target that meets the enclosed moves out
constexpr double k_box_rim = 1 + 1e-9;  ///< allowed errors: beyond a triangle's box by more than that no sample is near enough
constexpr double k_never = 1e100;       ///< cost of an edge that is not tried
constexpr double k_first_sweep = 2e-5, k_next_sweep = 4;
constexpr double k_worth_a_sweep = 0.95;  ///< share of the triangles that a sweep leaves, above which the next costs more
constexpr double k_coarse_error = 0.05, k_max_coarse_error = 4;  ///< of a simplified mesh, in sides of its triangles
constexpr std::size_t k_max_ring = 60;                           ///< triangles about both ends of an edge

struct Collapse {
    std::uint32_t a, b;
    Vec3d target;
    double cost;
};

/// An edge and its cost when both ends had these stamps; small, as there are many.
struct Waiting {
    float cost;
    std::uint32_t a, b, stamps;
    /// The cheapest one is the greatest.
    friend bool operator<(const Waiting& l, const Waiting& r) { return std::tie(l.cost, l.a, l.b) > std::tie(r.cost, r.a, r.b); }
};

class Decimator {
public:
    /// input: on which vertices stay that lie on it; null: none, and targets are found faster.
    Decimator(ClosedMesh& mesh, const Bvh* input, const DecimateLimits& limits)
        : mesh_(mesh),
          input_(input),
          enclosed_(limits.enclosed),
          locked_(limits.locked),
          planes_(mesh.vertices.size()),
          around_(mesh.vertices.size()),
          stamp_(mesh.vertices.size()),
          first_sample_(mesh.triangles.size(), k_none),
          seen_(mesh.vertices.size()),
          count_(static_cast<std::uint32_t>(mesh.triangles.size()))
    {
        for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
            const Vec3d c = cross(corner(t, 1) - corner(t, 0), corner(t, 2) - corner(t, 0));
            for (const std::uint32_t v : mesh.triangles[t]) {
                around_[v].push_back(t);
                planes_[v].add(corner(t, 0), normalized(c), 0.5 * norm(c));
            }
        }
        samples_.reserve(mesh.samples.size());
        for (const Vec3d& p : mesh.samples) samples_.push_back({p, k_none});
        for (std::uint32_t s = 0; s < samples_.size(); ++s) attach(s, mesh.carrier[s]);
        add_borders();
    }

    void run(double max_error, std::uint32_t least_count)
    {
        max_error_ = max_error;
        for (double cost = k_first_sweep; cost < max_error * max_error; cost *= k_next_sweep) sweep(cost, least_count);
        for_each_edge([&](std::uint32_t a, std::uint32_t b) { push(a, b); });
        while (!heap_.empty() && count_ > least_count) {
            const Waiting top = heap_.top();
            heap_.pop();
            if (stamp_[top.a] + stamp_[top.b] != top.stamps || around_[top.a].empty() || around_[top.b].empty()) continue;
            if (collapse(collapse_of(top.a, top.b))) for_each_neighbour(top.a, [&](std::uint32_t u) { push(top.a, u); });
        }
        heap_ = {};
    }

    /// The same by sweeps alone, which is faster where most triangles go; with greater and greater errors from least to max,
    /// until they are few enough.
    void sweep_down(double least_error, double max_error, std::uint32_t least_count)
    {
        for (double cost = k_first_sweep; count_ > least_count && cost < max_error * max_error; cost *= k_next_sweep) {
            max_error_ = std::max(least_error, 2 * std::sqrt(cost));
            for (std::uint32_t before = 0; count_ > least_count && before != count_;) {
                before = count_;
                sweep(cost, least_count);
                if (count_ > k_worth_a_sweep * before) break;
            }
        }
    }

    [[nodiscard]] std::uint32_t count() const { return count_; }

    /// Drops collapsed vertices and triangles; carriers are numbered as what is left.
    void compact()
    {
        std::uint32_t kept = 0;
        std::vector<std::uint32_t> number(mesh_.vertices.size(), k_none);
        std::vector<Vec3d> vertices;
        for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
            if (!alive(t)) continue;
            Triangle v = mesh_.triangles[t];
            for (std::uint32_t& i : v) {
                if (number[i] == k_none) {
                    number[i] = static_cast<std::uint32_t>(vertices.size());
                    vertices.push_back(mesh_.vertices[i]);
                }
                i = number[i];
            }
            for (std::uint32_t s = first_sample_[t]; s != k_none; s = samples_[s].next) mesh_.carrier[s] = kept;
            mesh_.triangles[kept] = v;
            mesh_.made_up[kept++] = mesh_.made_up[t];
        }
        mesh_.vertices = std::move(vertices);
        mesh_.triangles.resize(kept);
        mesh_.made_up.resize(kept);
    }

private:
    [[nodiscard]] Vec3d corner(std::uint32_t t, int k) const { return mesh_.vertices[mesh_.triangles[t][k]]; }
    [[nodiscard]] bool alive(std::uint32_t t) const { return mesh_.triangles[t][0] != k_none; }

    void attach(std::uint32_t sample, std::uint32_t t)
    {
        samples_[sample].next = first_sample_[t];
        first_sample_[t] = sample;
    }

    /// Keeps the border between input and made-up surface: planes through its edges, upright on the triangles.
    void add_borders()
    {
        if (std::adjacent_find(mesh_.made_up.begin(), mesh_.made_up.end(), std::not_equal_to<>()) == mesh_.made_up.end()) return;
        std::vector<std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>> edges;
        for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t)
            for (int k = 0; k < 3; ++k) {
                const auto [lo, hi] = std::minmax(mesh_.triangles[t][k], mesh_.triangles[t][(k + 1) % 3]);
                edges.emplace_back(lo, hi, t);
            }
        std::sort(edges.begin(), edges.end());
        for (std::size_t i = 0; i + 1 < edges.size(); i += 2) {
            const auto [a, b, t] = edges[i];
            const std::uint32_t other = std::get<2>(edges[i + 1]);
            if (mesh_.made_up[t] == mesh_.made_up[other]) continue;
            const Vec3d p = mesh_.vertices[a], along = mesh_.vertices[b] - p;
            const Vec3d n = normalized(cross(along, cross(corner(t, 1) - corner(t, 0), corner(t, 2) - corner(t, 0))));
            planes_[a].add(p, n, norm_sq(along));
            planes_[b].add(p, n, norm_sq(along));
        }
    }

    /// Calls visit(a, b), a < b, for every edge that is there when its turn comes.
    template <class Visit>
    void for_each_edge(Visit visit)
    {
        for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t)
            for (int k = 0; k < 3 && alive(t); ++k) {
                const std::uint32_t a = mesh_.triangles[t][k], b = mesh_.triangles[t][(k + 1) % 3];
                if (a < b) visit(a, b);
            }
    }

    /// Collapses edges that cost less, no two that touch. Where most edges are such, that is faster than taking the cheapest.
    void sweep(double cost, std::uint32_t least_count)
    {
        std::vector<std::uint8_t> touched(mesh_.vertices.size());
        for_each_edge([&](std::uint32_t a, std::uint32_t b) {
            if (touched[a] || touched[b] || count_ <= least_count) return;
            const Collapse c = collapse_of(a, b);
            if (c.cost >= cost || !collapse(c)) return;
            touched[a] = 1;
            for_each_neighbour(a, [&](std::uint32_t u) { touched[u] = 1; });
        });
    }

    [[nodiscard]] Collapse collapse_of(std::uint32_t a, std::uint32_t b) const
    {
        PlaneSum sum = planes_[a];
        sum += planes_[b];
        const Vec3d pa = mesh_.vertices[a], pb = mesh_.vertices[b], middle = 0.5 * (pa + pb);
        Vec3d best = (input_ != nullptr ? least_point : damped_least_point)(sum, middle, k_free_share);
        if (norm_sq(best - middle) > norm_sq(pb - pa)) best = middle;
        for (const Vec3d& p : {middle, pa, pb})
            if (sum.at(p) < sum.at(best)) best = p;
        const double error = std::max(sum.at(best), 0.0);
        if (error > k_far * k_far * max_error_ * max_error_ * (sum.a[0] + sum.a[1] + sum.a[2])) return {a, b, best, k_never};
        return {a, b, best, error + k_length * norm_sq(pb - pa)};
    }

    void push(std::uint32_t a, std::uint32_t b)
    {
        const double cost = collapse_of(a, b).cost;
        if (cost < k_never) heap_.push({static_cast<float>(cost), a, b, stamp_[a] + stamp_[b]});
    }

    /// Calls visit(u) once for each vertex u that shares a triangle with v; seen_ has the number of this call there.
    template <class Visit>
    void for_each_neighbour(std::uint32_t v, Visit&& visit)
    {
        const std::uint32_t call = ++calls_;
        for (const std::uint32_t t : around_[v])
            for (const std::uint32_t u : mesh_.triangles[t]) {
                if (u == v || seen_[u] == call) continue;
                seen_[u] = call;
                visit(u);
            }
    }

    /// True if the surface stays a manifold: the two vertices share no neighbours but those opposite to their edge.
    [[nodiscard]] bool may_join(std::uint32_t a, std::uint32_t b)
    {
        if (!locked_.empty() && (locked_[a] != 0 || locked_[b] != 0)) return false;
        const std::size_t size = around_[a].size() + around_[b].size();
        if (size <= 6 || size > k_max_ring) return false;
        ring_of_a_.clear();
        for_each_neighbour(a, [&](std::uint32_t u) { ring_of_a_.push_back(u); });
        for_each_neighbour(b, [](std::uint32_t) {});
        return std::count_if(ring_of_a_.begin(), ring_of_a_.end(), [&](std::uint32_t u) { return seen_[u] == calls_; }) == 2;
    }

    /// Triangles about the edge that stay, as they will be; false where one turns over or gets too thin.
    bool make_ring(const Collapse& c)
    {
        ring_.clear();
        for (const std::uint32_t v : {c.a, c.b}) {
            for (const std::uint32_t t : around_[v]) {
                const Triangle& tri = mesh_.triangles[t];
                const bool both =
                    std::count_if(tri.begin(), tri.end(), [&](std::uint32_t u) { return u == c.a || u == c.b; }) == 2;
                if (both) continue;
                std::array<Vec3d, 3> after{};
                for (int k = 0; k < 3; ++k) after[k] = tri[k] == v ? c.target : mesh_.vertices[tri[k]];
                if (!is_fair({corner(t, 0), corner(t, 1), corner(t, 2)}, after)) return false;
                ring_.emplace_back(t, after);
            }
        }
        return true;
    }

    static bool is_fair(const std::array<Vec3d, 3>& before, const std::array<Vec3d, 3>& after)
    {
        const auto normal = [](const std::array<Vec3d, 3>& t) { return cross(t[1] - t[0], t[2] - t[0]); };
        const auto shape = [&](const std::array<Vec3d, 3>& t) {
            const double longest = std::max({norm_sq(t[1] - t[0]), norm_sq(t[2] - t[1]), norm_sq(t[0] - t[2])});
            return longest > 0 ? norm(normal(t)) / longest : 0;
        };
        const double after_shape = shape(after), before_shape = shape(before);
        if (after_shape < k_shape && after_shape <= before_shape) return false;
        if (after_shape < 1e-4) return false;
        if (before_shape < 1e-6) return true;
        const Vec3d n = normal(before), m = normal(after);
        return dot(n, m) >= k_turn * norm(n) * norm(m);
    }

    /// As contains(), without branches: a box that does not hold a sample fails on any of its sides.
    static bool holds(const Box& box, Vec3d p)
    {
        return ((p.x >= box.lo.x) & (p.x <= box.hi.x) & (p.y >= box.lo.y) & (p.y <= box.hi.y) & (p.z >= box.lo.z) &
                (p.z <= box.hi.z)) != 0;
    }

    /// Finds the nearest triangle of the ring for every sample that the edge's triangles carry; false where one is too far.
    bool carry_samples(const Collapse& c)
    {
        carried_.clear();
        const double limit = max_error_ * max_error_, rim = k_box_rim * max_error_;
        reach_.clear();
        for (const auto& [r, corners] : ring_) {
            Box box = box_of(corners);
            box.lo -= Vec3d{rim, rim, rim};
            box.hi += Vec3d{rim, rim, rim};
            reach_.push_back(box);
        }
        for (const std::uint32_t v : {c.a, c.b}) {
            for (const std::uint32_t t : around_[v]) {
                if (v == c.b && std::find(around_[c.a].begin(), around_[c.a].end(), t) != around_[c.a].end()) continue;
                for (std::uint32_t s = first_sample_[t], next; s != k_none; s = next) {
                    const Vec3d p = samples_[s].point;
                    next = samples_[s].next;
                    if (next != k_none) __builtin_prefetch(&samples_[next]);  // it is rarely in the cache
                    double best = limit;
                    std::uint32_t carrier = k_none;
                    for (std::size_t i = 0; i < ring_.size(); ++i) {
                        if (!holds(reach_[i], p)) continue;
                        const auto& [r, corners] = ring_[i];
                        const double d = norm_sq(closest_point_on_triangle(p, corners[0], corners[1], corners[2]) - p);
                        if (d <= best) {
                            best = d;
                            carrier = r;
                        }
                        if (best < 1e-4 * limit) break;
                    }
                    if (carrier == k_none) return false;
                    carried_.emplace_back(s, carrier);
                }
            }
        }
        return true;
    }

    /// True if the ring may take the target's position, which may be moved; the ring and its samples are made.
    bool fits(Collapse& c)
    {
        const auto fits_here = [&] { return bring_to_surface(c) && make_ring(c) && carry_samples(c); };
        if (enclosed_ == nullptr) return fits_here();
        const Vec3d outward = k_outward * max_error_ * normal_about(c);
        for (int i = 0; i < 2; ++i, c.target += outward) {
            if (!bring_to_surface(c) || !make_ring(c)) return false;
            if (keeps_enclosed(c)) return carry_samples(c);
        }
        return false;
    }

    [[nodiscard]] Vec3d normal_about(const Collapse& c) const
    {
        Vec3d sum;
        for (const std::uint32_t v : {c.a, c.b})
            for (const std::uint32_t t : around_[v]) sum += cross(corner(t, 1) - corner(t, 0), corner(t, 2) - corner(t, 0));
        return norm_sq(sum) > 0 ? normalized(sum) : Vec3d{};
    }

    /// True if no triangle of the ring meets what is enclosed, and none passes over it on its way there: a goes, then b.
    bool keeps_enclosed(const Collapse& c)
    {
        Box box;
        extend(box, c.target);
        for (const std::uint32_t v : {c.a, c.b})
            for (const std::uint32_t t : around_[v])
                for (int k = 0; k < 3; ++k) extend(box, corner(t, k));
        near_.clear();
        enclosed_->collect(box, near_);
        if (near_.empty()) return true;
        for (const auto& [t, corners] : ring_) {
            const Box about = box_of(corners);
            for (const std::uint32_t s : near_)
                if (!enclosed_->are_apart(s, corners, about)) return false;
        }
        for (const std::uint32_t v : {c.a, c.b})
            for (const std::uint32_t t : around_[v]) {
                const Triangle& tri = mesh_.triangles[t];
                if (v == c.b && std::find(tri.begin(), tri.end(), c.a) != tri.end()) continue;
                const auto k = static_cast<int>(std::find(tri.begin(), tri.end(), v) - tri.begin());
                const std::array<Vec3d, 4> swept{mesh_.vertices[v], c.target, corner(t, (k + 1) % 3), corner(t, (k + 2) % 3)};
                for (const std::uint32_t s : near_)
                    if (enclosed_->is_swept(s, swept)) return false;
            }
        return true;
    }

    /// Joins b to a; false, and nothing done, where that is not allowed.
    bool collapse(Collapse c)
    {
        if (c.cost >= k_never || !may_join(c.a, c.b) || !fits(c)) return false;
        for (const std::uint32_t v : {c.a, c.b})
            for (const std::uint32_t t : around_[v]) first_sample_[t] = k_none;
        for (const auto& [s, carrier] : carried_) attach(s, carrier);
        for (const std::uint32_t t : around_[c.b]) {
            Triangle& tri = mesh_.triangles[t];
            if (std::find(tri.begin(), tri.end(), c.a) == tri.end()) {
                std::replace(tri.begin(), tri.end(), c.b, c.a);
                around_[c.a].push_back(t);
                continue;
            }
            for (const std::uint32_t u : tri)
                if (u != c.b) around_[u].erase(std::find(around_[u].begin(), around_[u].end(), t));
            tri[0] = k_none;
            --count_;
        }
        around_[c.b].clear();
        mesh_.vertices[c.a] = c.target;
        planes_[c.a] += planes_[c.b];
        ++stamp_[c.a];
        ++stamp_[c.b];
        return true;
    }

    /// Moves the target to the input where both ends lie on it; false where it is too far from there, or from the surface.
    bool bring_to_surface(Collapse& c) const
    {
        if (c.target == mesh_.vertices[c.a] || c.target == mesh_.vertices[c.b]) return true;
        const auto on_input = [&](std::uint32_t v) {
            if (enclosed_ != nullptr || input_ == nullptr) return false;
            return input_->closest_point(mesh_.vertices[v], k_on_input).distance < k_on_input;
        };
        if (on_input(c.a) && on_input(c.b)) {
            const ClosestPoint nearest = input_->closest_point(c.target, max_error_);
            if (!(nearest.distance < max_error_)) return false;
            c.target = nearest.point;
            return true;
        }
        for (const std::uint32_t v : {c.a, c.b})
            for (const std::uint32_t t : around_[v])
                if (norm(closest_point_on_triangle(c.target, corner(t, 0), corner(t, 1), corner(t, 2)) - c.target) <= max_error_)
                    return true;
        return false;
    }

    ClosedMesh& mesh_;
    const Bvh* input_;
    const Enclosed* enclosed_;
    std::span<const std::uint8_t> locked_;
    std::vector<std::uint32_t> near_;
    std::vector<PlaneSum> planes_;
    std::vector<std::vector<std::uint32_t>> around_;
    std::vector<std::uint32_t> stamp_, first_sample_;
    /// A sample of the surface, and the next one on the same triangle.
    struct Sample {
        Vec3d point;
        std::uint32_t next;
    };
    std::vector<Sample> samples_;
    std::vector<std::uint32_t> seen_;  ///< #vertices: the last call of for_each_neighbour that came there
    std::vector<std::uint32_t> ring_of_a_;
    std::uint32_t calls_ = 0;
    std::uint32_t count_;
    double max_error_ = 0;
    std::priority_queue<Waiting> heap_;
    std::vector<std::pair<std::uint32_t, std::array<Vec3d, 3>>> ring_;
    std::vector<Box> reach_;  ///< #ring_: what lies within max_error_ of the triangle
    std::vector<std::pair<std::uint32_t, std::uint32_t>> carried_;
};

}  // namespace

double decimate(ClosedMesh& mesh, const Bvh& bvh, const DecimateLimits& limits)
{
    constexpr int k_doublings = 12;
    Decimator decimator(mesh, &bvh, limits);
    double error = limits.max_error;
    decimator.run(error, 0);
    for (int i = 0; i < k_doublings && decimator.count() > limits.max_triangles; ++i) {
        error *= 2;
        decimator.run(error, limits.max_triangles);
    }
    decimator.compact();
    return error;
}

Simplified simplified(const Mesh& mesh, std::uint32_t triangles)
{
    double area = 0;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) area += triangle_area(mesh, t);
    const double side = std::sqrt(area / triangles);
    ClosedMesh coarse{{}, mesh.triangles, std::vector<std::uint8_t>(mesh.triangles.size()), {}, {}};
    for (const Vec3d& v : mesh.vertices) coarse.vertices.push_back(v / side);
    coarse.samples = coarse.vertices;
    coarse.carrier.resize(coarse.samples.size());
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
        for (const std::uint32_t v : mesh.triangles[t]) coarse.carrier[v] = t;
    Decimator decimator(coarse, nullptr, {});
    decimator.sweep_down(k_coarse_error, k_max_coarse_error, triangles);
    decimator.compact();
    for (Vec3d& v : coarse.vertices) v = side * v;
    return {{std::move(coarse.vertices), std::move(coarse.triangles)}, std::move(coarse.carrier)};
}

}  // namespace sqmap::mesh
