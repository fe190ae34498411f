#include "viewer/server/cloth/slit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <queue>
#include <set>

namespace sqmap::viewer {
namespace {

using Edge = std::array<std::uint32_t, 2>;
using Triangle = std::array<std::uint32_t, 3>;

constexpr double k_least_area = 0.3;  // of what a triangle had
constexpr double k_max_shift = 0.5;   // of the way to the opposite edge

Edge edge(std::uint32_t a, std::uint32_t b) { return {std::min(a, b), std::max(a, b)}; }

Vec3d nearest_on(Vec3d a, Vec3d b, Vec3d p)
{
    const Vec3d d = b - a;
    const double along = norm_sq(d) > 0 ? std::clamp(dot(p - a, d) / norm_sq(d), 0.0, 1.0) : 0;
    return a + along * d;
}

Vec3d nearest_on(std::span<const Vec3d> line, Vec3d p)
{
    Vec3d best = line.front();
    for (std::size_t i = 0; i + 1 < line.size(); ++i)
        if (const Vec3d q = nearest_on(line[i], line[i + 1], p); norm_sq(q - p) < norm_sq(best - p)) best = q;
    return best;
}

struct Net {
    explicit Net(const sim::Garment& garment)
        : triangles(garment.triangles), at(garment.start.size()), beside(garment.start.size())
    {
        for (std::uint32_t t = 0; t < triangles.size(); ++t)
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t a = triangles[t][k], b = triangles[t][(k + 1) % 3];
                at[a].push_back(t);
                if (uses[edge(a, b)]++ == 0) beside[a].push_back(b), beside[b].push_back(a);
            }
    }
    [[nodiscard]] bool on_border(std::uint32_t v) const
    {
        return std::any_of(beside[v].begin(), beside[v].end(), [&](std::uint32_t w) { return uses.at(edge(v, w)) == 1; });
    }

    const std::vector<Triangle>& triangles;
    std::vector<std::vector<std::uint32_t>> at;      ///< triangles at a vertex
    std::vector<std::vector<std::uint32_t>> beside;  ///< vertices
    std::map<Edge, int> uses;
};

/// The way along edges from one vertex to another that stays closest to a straight line.
std::vector<std::uint32_t> shortest_path(const Net& net, std::span<const Vec3d> x, std::uint32_t from, std::uint32_t to)
{
    std::vector<double> cost(x.size(), std::numeric_limits<double>::infinity());
    std::vector<std::uint32_t> before(x.size(), from);
    using Entry = std::pair<double, std::uint32_t>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
    cost[from] = 0;
    open.push({0, from});
    while (!open.empty()) {
        const auto [so_far, v] = open.top();
        open.pop();
        if (v == to) break;
        if (so_far > cost[v]) continue;
        for (const std::uint32_t w : net.beside[v]) {
            const double length = norm(x[w] - x[v]);
            const double off = norm(nearest_on(x[from], x[to], x[w]) - x[w]);
            const double c = so_far + length * (1 + 4 * off / std::max(length, 1e-9));
            if (c < cost[w]) cost[w] = c, before[w] = v, open.push({c, w});
        }
    }
    if (!std::isfinite(cost[to])) return {};
    std::vector<std::uint32_t> out{to};
    while (out.back() != from) out.push_back(before[out.back()]);
    std::reverse(out.begin(), out.end());
    return out;
}

double area(const std::vector<Vec3d>& flat, const Triangle& t)
{
    return 0.5 * cross(flat[t[1]] - flat[t[0]], flat[t[2]] - flat[t[0]]).z;
}

/// Moves a vertex towards the line within one of its triangles.
void move_onto(const Net& net, sim::Garment& garment, std::vector<Vec3d>& x, std::span<const Vec3d> line, std::uint32_t v)
{
    const Vec3d d = nearest_on(line, x[v]) - x[v];
    if (!(norm_sq(d) > 1e-12)) return;
    for (const std::uint32_t t : net.at[v]) {
        Triangle c = net.triangles[t];
        while (c[0] != v) std::rotate(c.begin(), c.begin() + 1, c.end());
        // d = s a + u b, least squares in the triangle's plane.
        const Vec3d a = x[c[1]] - x[v], b = x[c[2]] - x[v];
        const double aa = dot(a, a), ab = dot(a, b), bb = dot(b, b), det = aa * bb - ab * ab;
        if (!(det > 0)) continue;
        double s = (dot(d, a) * bb - dot(d, b) * ab) / det, u = (dot(d, b) * aa - dot(d, a) * ab) / det;
        if (s < -1e-9 || u < -1e-9) continue;
        const double scale = std::min(1.0, k_max_shift / std::max(s + u, 1e-9));
        s *= scale, u *= scale;
        const auto moved = [&](const std::vector<Vec3d>& p) { return p[v] + s * (p[c[1]] - p[v]) + u * (p[c[2]] - p[v]); };
        const Vec3d was = garment.flat[v];
        std::vector<double> areas;
        for (const std::uint32_t i : net.at[v]) areas.push_back(area(garment.flat, net.triangles[i]));
        const Vec3d start = moved(garment.start), now = moved(x);
        garment.flat[v] = moved(garment.flat);
        for (std::size_t i = 0; i < areas.size(); ++i)
            if (!(area(garment.flat, net.triangles[net.at[v][i]]) / areas[i] > k_least_area)) {
                garment.flat[v] = was;
                return;
            }
        garment.start[v] = start;
        x[v] = now;
        return;
    }
}

/// A path of edges along what was drawn, and the line itself, m. It ends where the line comes to another panel.
struct Drawn {
    std::vector<std::uint32_t> path;
    std::vector<Vec3d> line;
};

/// Nothing where a triangle is named that the garment does not have.
std::optional<Drawn> follow(const Net& net, const sim::Garment& garment, std::span<const Vec3d> positions,
                            std::span<const ClothPoint> points)
{
    Drawn out;
    for (const ClothPoint& p : points) {
        if (p.triangle >= garment.triangles.size()) return std::nullopt;
        // The corner that is nearest in the triangle: no fold that lies upon it has a part in this.
        const Triangle& t = garment.triangles[p.triangle];
        const double w = 1 - p.u - p.v;
        const std::uint32_t best = w >= p.u && w >= p.v ? t[0] : p.u >= p.v ? t[1] : t[2];
        out.line.push_back(w * positions[t[0]] + p.u * positions[t[1]] + p.v * positions[t[2]]);
        if (out.path.empty()) {
            out.path.push_back(best);
            continue;
        }
        if (best == out.path.back()) continue;
        const std::vector<std::uint32_t> steps = shortest_path(net, positions, out.path.back(), best);
        if (steps.empty()) {  // another panel
            out.line.pop_back();
            break;
        }
        for (std::size_t i = 1; i < steps.size(); ++i)
            if (out.path.size() > 1 && out.path[out.path.size() - 2] == steps[i])
                out.path.pop_back();  // there and back
            else
                out.path.push_back(steps[i]);
    }
    return out;
}

/// The triangles about a vertex, in fans that hang together where the cut does not part them.
std::vector<std::vector<std::uint32_t>> fans_at(const Net& net, std::uint32_t v, const std::set<Edge>& cut)
{
    std::vector<std::vector<std::uint32_t>> fans;
    std::set<std::uint32_t> left(net.at[v].begin(), net.at[v].end());
    while (!left.empty()) {
        std::vector<std::uint32_t>& fan = fans.emplace_back(1, *left.begin());
        left.erase(left.begin());
        for (std::size_t i = 0; i < fan.size(); ++i)
            for (const std::uint32_t w : net.triangles[fan[i]]) {
                if (w == v || cut.count(edge(v, w)) != 0) continue;
                for (auto t = left.begin(); t != left.end();) {
                    const Triangle& c = net.triangles[*t];
                    if (std::find(c.begin(), c.end(), w) == c.end()) {
                        ++t;
                    } else {
                        fan.push_back(*t);
                        t = left.erase(t);
                    }
                }
            }
    }
    return fans;
}

/// Gives a fan a vertex of its own instead of v; its number.
std::uint32_t part_from(Slit& out, std::uint32_t v, const std::vector<std::uint32_t>& fan)
{
    const auto copy = static_cast<std::uint32_t>(out.positions.size());
    for (const std::uint32_t t : fan) std::replace(out.garment.triangles[t].begin(), out.garment.triangles[t].end(), v, copy);
    for (sim::Seam& other : out.garment.seams)
        for (std::size_t i = 0, n = other.pairs.size(); i < n; ++i)
            for (const std::size_t end : {0u, 1u})
                if (other.pairs[i][end] == v) {
                    auto pair = other.pairs[i];
                    pair[end] = copy;
                    other.pairs.push_back(pair);
                }
    std::vector<std::uint32_t>& waist = out.garment.waist;
    if (std::find(waist.begin(), waist.end(), v) != waist.end()) waist.push_back(copy);
    out.garment.start.push_back(out.garment.start[v]);
    out.garment.flat.push_back(out.garment.flat[v]);
    out.positions.push_back(out.positions[v]);
    out.from.push_back(v);
    return copy;
}

}  // namespace

std::optional<Slit> slit(const sim::Garment& garment, std::span<const Vec3d> positions, std::span<const ClothPoint> drawn,
                         const std::string& name)
{
    if (drawn.size() < 2) return std::nullopt;
    Slit out{garment, {positions.begin(), positions.end()}, {}};
    const Net net(garment);
    const std::optional<Drawn> followed = follow(net, garment, positions, drawn);
    if (!followed) return std::nullopt;
    const auto& [path, line] = *followed;
    std::set<std::uint32_t> kept(garment.waist.begin(), garment.waist.end());
    for (const sim::Seam& seam : garment.seams)
        for (const auto& pair : seam.pairs) kept.insert(pair.begin(), pair.end());
    for (std::size_t i = 1; i + 1 < path.size(); ++i)
        if (!net.on_border(path[i]) && kept.count(path[i]) == 0) move_onto(net, out.garment, out.positions, line, path[i]);

    std::set<Edge> cut;
    for (std::size_t i = 0; i + 1 < path.size(); ++i) cut.insert(edge(path[i], path[i + 1]));
    sim::Seam seam{name, {}, false};
    for (const std::uint32_t v : std::set<std::uint32_t>(path.begin(), path.end())) {
        // The first fan keeps the vertex, each other gets its own.
        const std::vector<std::vector<std::uint32_t>> fans = fans_at(net, v, cut);
        for (std::size_t f = 1; f < fans.size(); ++f) seam.pairs.push_back({v, part_from(out, v, fans[f])});
    }
    if (out.from.empty()) return std::nullopt;
    out.garment.seams.push_back(std::move(seam));
    return out;
}

}  // namespace sqmap::viewer
