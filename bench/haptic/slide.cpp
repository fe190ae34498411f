#include "slide.h"

#include "../frames.h"
#include "haptic/stencil.h"
#include "math/random.h"
#include "sqmap/haptic/safety.h"
#include "sqmap/haptic/tool.h"
#include "sqmap/paper/force.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace sqmap::bench {

namespace {

constexpr double k_sphere = 0.005;  ///< m

/// A tool of one zone, frictionless, and how it is queried.
class Tool {
public:
    Tool(const TouchObject& object, const SlideOptions& options, Force force = Force::Full)
        : tool_(description(options, force)), state_(tool_.state())
    {
        solid_.model = force == Force::Full ? &object.central : &object.paper;
        solid_.material.friction = Friction::None;
        per_depth_ = options.stiffness;
    }

    Vec3d force(Vec3d at, bool fresh = false)
    {
        if (fresh) state_.reset();
        const Pose pose{{}, at};
        haptic::Wrench w;
        (void)haptic::step(state_, {.touched = std::span(&solid_, 1), .poses = std::span(&pose, 1)}, std::span(&w, 1));
        return w.force;
    }
    void reset() { state_.reset(); }
    void rub(Friction friction) { solid_.material.friction = friction; }
    double depth_of(Vec3d force) const { return norm(force) / per_depth_; }
    [[nodiscard]] double stiffness() const { return per_depth_; }

private:
    static haptic::ToolDescription description(const SlideOptions& options, Force force)
    {
        haptic::ZoneOptions o = options.zone;
        o.stiffness = options.stiffness;
        const haptic::ToolShape shape = options.sphere ? haptic::ToolShape::Ball : haptic::ToolShape::Point;
        if (force == Force::Full) return {.force = o, .shape = shape, .ball_radius = k_sphere};
        o.blend_time = 0;
        o.layer = query::Layer::Three;
        o = paper::with_paper_force(o);
        o.smoothed_map = force != Force::Unsmoothed;
        const bool is_single = force == Force::Unsmoothed || force == Force::Smoothed;
        return {.force = o, .points = is_single ? std::vector<Vec3d>(1) : haptic::stencil_points(o.smoothing)};
    }

    haptic::Tool tool_;
    haptic::State state_;
    haptic::TouchedBody solid_;
    double per_depth_ = 0;
};

struct TouchPoint {
    Vec3d point, normal;
};
/// Random points of the surface, by area, on the boundary of the solid.
std::vector<TouchPoint> random_points(const TouchObject& object, int count)
{
    std::vector<double> sum;
    double total = 0;
    for (std::uint32_t t = 0; t < object.mesh.triangles.size(); ++t) sum.push_back(total += mesh::triangle_area(object.mesh, t));
    SplitMix64 random(5);
    std::vector<TouchPoint> positions;
    while (positions.size() < static_cast<std::size_t>(count)) {
        const auto t =
            static_cast<std::uint32_t>(std::lower_bound(sum.begin(), sum.end(), total * random.uniform()) - sum.begin());
        if (t >= sum.size()) continue;
        double u = random.uniform(), v = random.uniform();
        if (u + v > 1) u = 1 - u, v = 1 - v;
        const auto& k = object.mesh.triangles[t];
        const Vec3d a = object.mesh.vertices[k[0]];
        const Vec3d p = a + u * (object.mesh.vertices[k[1]] - a) + v * (object.mesh.vertices[k[2]] - a);
        if (object.solid->boundary()[t] == mesh::Boundary::Whole) positions.push_back({p, object.face_normals[t]});
    }
    return positions;
}

}  // namespace

Slide slide(const TouchObject& object, const SlideOptions& options)
{
    Slide out;
    Tool tool(object, options);
    const bool has_maps = !object.paper.parts.empty();
    std::optional<Tool> unsmoothed, smoothed, averaged;
    if (has_maps) {
        unsmoothed.emplace(object, options, Force::Unsmoothed);
        smoothed.emplace(object, options, Force::Smoothed);
        averaged.emplace(object, options, Force::Averaged);
    }
    // A sphere's centre is outside, `depth` nearer than its radius.
    const double below = options.sphere ? options.depth - k_sphere : options.depth;
    const double reach = options.sphere ? k_sphere : options.depth + options.zone.smoothing.radius;
    Vec3d lo = object.mesh.vertices.front(), hi = lo;
    for (const Vec3d& v : object.mesh.vertices)
        for (int k = 0; k < 3; ++k) lo[k] = std::min(lo[k], v[k]), hi[k] = std::max(hi[k], v[k]);
    for (int axis = 0; axis < 3; ++axis)
        for (int plane = 1; plane <= options.planes; ++plane) {
            Vec3d n{0.0123, 0.0217, 0.0171};  // askew, so that no plane holds a face
            n[axis] = 1;
            const double share = static_cast<double>(plane) / (options.planes + 1);
            const std::vector<Vec3d> path = slide_path(object, n, dot(n, lo + share * (hi - lo)), below);
            if (path.empty()) continue;
            out.first.push_back(out.ticks.size());
            tool.reset();
            for (const Vec3d& at : path) {
                const TouchObject::Exact e = object.exact(at);
                SlideTick t;
                t.at = at;
                t.true_depth = std::max(options.sphere ? k_sphere - e.distance : -e.distance, 0.);
                t.mesh = (options.stiffness * t.true_depth) * e.face_normal;
                t.shaded = (options.stiffness * t.true_depth) * e.shaded_normal;
                t.ours = tool.force(at);
                t.effective_depth = tool.depth_of(t.ours);
                if (has_maps) {
                    t.unsmoothed = unsmoothed->force(at);
                    t.smoothed = smoothed->force(at);
                    t.averaged = averaged->force(at);
                }
                t.sharp = object.near_sharp_edge(e.point, reach);
                out.ticks.push_back(t);
            }
        }
    // Ticks about a flip of the mesh's own normal without a sharp edge, as at thin parts, are no smooth ground.
    const auto turns = [&](const SlideTick& a, const SlideTick& b) {
        return norm(a.mesh) > 0 && norm(b.mesh) > 0 && dot(normalized(a.mesh), normalized(b.mesh)) < std::cos(std::acos(-1.) / 4);
    };
    const auto around = static_cast<std::ptrdiff_t>(2 * reach / 1e-4);
    const auto size = static_cast<std::ptrdiff_t>(out.ticks.size());
    for (std::ptrdiff_t i = 1; i < size; ++i)
        if (turns(out.ticks[static_cast<std::size_t>(i - 1)], out.ticks[static_cast<std::size_t>(i)]))
            for (std::ptrdiff_t j = std::max<std::ptrdiff_t>(0, i - around); j < std::min(size, i + around); ++j)
                out.ticks[static_cast<std::size_t>(j)].sharp = true;
    return out;
}

Steps steps_of(const Slide& slide, std::optional<bool> sharp)
{
    std::vector<double> steps[6];
    for (std::size_t w = 0; w < slide.first.size(); ++w) {
        const std::size_t end = w + 1 < slide.first.size() ? slide.first[w + 1] : slide.ticks.size();
        for (std::size_t i = slide.first[w] + 1; i < end; ++i) {
            const SlideTick &a = slide.ticks[i - 1], &b = slide.ticks[i];
            if (sharp && (a.sharp || b.sharp) != *sharp) continue;
            const Vec3d steps_of_tick[] = {b.mesh - a.mesh,         b.shaded - a.shaded,
                                           b.ours - a.ours,         b.unsmoothed - a.unsmoothed,
                                           b.smoothed - a.smoothed, b.averaged - a.averaged};
            for (std::size_t k = 0; k < 6; ++k) steps[k].push_back(norm(steps_of_tick[k]));
        }
    }
    Steps out;
    out.count = steps[0].size();
    if (out.count == 0) return out;
    for (std::size_t k = 0; k < 6; ++k) {
        out.max[k] = *std::max_element(steps[k].begin(), steps[k].end());
        out.p99[k] = percentile(steps[k], 0.99);
    }
    return out;
}

Onset onset(const TouchObject& object, const SlideOptions& options, int positions)
{
    Tool tool(object, options);
    std::vector<double> found;
    for (const TouchPoint& p : random_points(object, positions)) {
        const double radius = options.sphere ? k_sphere : 0;
        // A sphere that would be in the solid elsewhere does not touch here first.
        if (options.sphere && object.exact(p.point + radius * p.normal).distance < radius * (1 - 1e-6)) continue;
        double out = radius + 0.002, in = radius - 0.002;
        if (norm(tool.force(p.point + out * p.normal, true)) > 0 || norm(tool.force(p.point + in * p.normal, true)) == 0)
            continue;
        while (out - in > 1e-6) {
            const double middle = 0.5 * (out + in);
            (norm(tool.force(p.point + middle * p.normal, true)) > 0 ? in : out) = middle;
        }
        // From the nearest surface: in a fold that may be another than the point's.
        found.push_back(std::abs(object.exact(p.point + 0.5 * (out + in) * p.normal).distance - radius));
    }
    if (found.empty()) return {};
    return {percentile(found, 0.5), percentile(found, 0.99), *std::max_element(found.begin(), found.end())};
}

NormalError normal_error(const TouchObject& object, const SlideOptions& options, int positions)
{
    Tool tool(object, options);
    std::vector<double> angles;
    for (const TouchPoint& p : random_points(object, positions)) {
        const double radius = options.sphere ? k_sphere : 0;
        const Vec3d at = p.point + (radius - 0.001) * p.normal;
        const TouchObject::Exact e = object.exact(at);
        // Smooth: all faces about, up to 2 mm away, turn by less than 10 degrees from this one.
        bool smooth = dot(e.face_normal, p.normal) > 0.999;
        const Vec3d side = normalized(cross(p.normal, std::abs(p.normal.x) < 0.7 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0}));
        for (int k = 0; k < 8 && smooth; ++k) {
            const double angle = 0.785398163397 * k;
            const Vec3d d = std::cos(angle) * side + std::sin(angle) * cross(p.normal, side);
            const TouchObject::Exact there = object.exact(p.point + 0.002 * d);
            smooth = dot(there.face_normal, p.normal) > std::cos(0.1745) && std::abs(there.distance) < 0.001;
        }
        if (!smooth) continue;
        const Vec3d force = tool.force(at, true);
        if (norm(force) == 0) continue;
        angles.push_back(57.29577951 * std::acos(std::clamp(dot(normalized(force), p.normal), -1., 1.)));
    }
    if (angles.empty()) return {};
    return {percentile(angles, 0.5), percentile(angles, 0.95), *std::max_element(angles.begin(), angles.end()), angles.size()};
}

namespace {

/// A closed way of 3 mm by 1 mm through the surface.
struct Round {
    Vec3d centre, u, v;
    [[nodiscard]] Vec3d at(double s) const
    {
        const double a = 6.283185307179586 * s;
        return centre + 0.003 * std::cos(a) * u + 0.001 * std::sin(a) * v;
    }
};

/// Work of a force, and of its size, along a piece of a way.
struct Work {
    double done = 0, moved = 0;
    void operator+=(const Work& w) { done += w.done, moved += w.moved; }
};

/// Halved until the trapezium rule does not change: where a sample's foot point passes to another wall the force has a step, and
/// the rule is wrong by half of it times the piece's length.
class Line {
public:
    Line(Tool& tool, const Round& round) : tool_(tool), round_(round) {}

    Work around()
    {
        constexpr int k_pieces = 400;
        Work sum;
        End a = end(0);
        for (int i = 1; i <= k_pieces; ++i) {
            const End b = end(static_cast<double>(i) / k_pieces);
            sum += piece(a, b, 0);
            a = b;
        }
        return sum;
    }

private:
    struct End {
        double s;
        Vec3d at, force;
    };
    End end(double s)
    {
        const Vec3d at = round_.at(s);
        return {s, at, tool_.force(at, true)};
    }
    static Work trapezium(const End& a, const End& b)
    {
        const Vec3d mean = 0.5 * (a.force + b.force), path = b.at - a.at;
        return {dot(mean, path), norm(mean) * norm(path)};
    }
    Work piece(const End& a, const End& b, int halvings)
    {
        constexpr int k_max_halvings = 8;  // 0.2 um: below that depths are floats
        const End m = end(0.5 * (a.s + b.s));
        const Work whole = trapezium(a, b);
        Work halves = trapezium(a, m);
        halves += trapezium(m, b);
        if (halvings == k_max_halvings || std::abs(whole.done - halves.done) <= 1e-5 * halves.moved) return halves;
        Work sum = piece(a, m, halvings + 1);
        sum += piece(m, b, halvings + 1);
        return sum;
    }

    Tool& tool_;
    const Round& round_;
};

/// J that a device gives, tick by tick, which holds each force until the next: the most at any time, before and behind the
/// filter.
struct Given {
    double commanded = 0, sent = 0;
};
Given given(Tool& tool, const Round& round, int rounds)
{
    constexpr int k_wait = 700, k_round = 134;  // ticks; 0.1 m/s
    haptic::SafetyFilter filter({.max_force = 4, .continuous_force = 4}, {.softest = tool.stiffness()});
    Given largest;
    double commanded = 0, sent = 0, time = 0;
    haptic::Wrench command{}, safe{};
    tool.reset();
    Vec3d before = round.at(0);
    for (int i = 0; i < k_wait + rounds * k_round; ++i) {
        const Vec3d at = round.at(i < k_wait ? 0 : static_cast<double>((i - k_wait) % k_round) / k_round);
        commanded += dot(command.force, at - before);
        sent += dot(safe.force, at - before);
        before = at;
        largest.commanded = std::max(largest.commanded, commanded);
        largest.sent = std::max(largest.sent, sent);
        command.force = i < k_wait ? Vec3d{} : tool.force(at);
        time += 0.001;
        const Pose pose{{}, at};
        filter.tick({.time = time,
                     .sample_time = time,
                     .sequence = static_cast<std::uint64_t>(i) + 1,
                     .poses = std::span(&pose, 1),
                     .commanded = std::span(&command, 1)},
                    std::span(&safe, 1));
    }
    return largest;
}

}  // namespace

Energy energy(const TouchObject& object, const SlideOptions& options, Force force, int positions)
{
    constexpr std::size_t k_repeated = 10;
    Tool tool(object, options, force);
    SplitMix64 random(11);
    std::vector<std::pair<double, Round>> found;
    for (const TouchPoint& p : random_points(object, positions)) {
        const Vec3d side = normalized(cross(p.normal, std::abs(p.normal.x) < 0.7 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0}));
        const double tilt = random.between(0, 6.283185307);
        const double out = options.sphere ? k_sphere : 0;
        const Round round{p.point + (out - 0.001) * p.normal, std::cos(tilt) * side + std::sin(tilt) * cross(p.normal, side),
                          p.normal};
        const Work w = Line(tool, round).around();
        if (w.moved > 0) found.emplace_back(w.done / w.moved, round);
    }
    if (found.empty()) return {};
    std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
    Energy e{.worst = found.front().first, .least = found.back().first, .paths = found.size()};
    for (std::size_t i = 0; i < std::min(k_repeated, found.size()); ++i) {
        tool.rub(Friction::None);
        const Given g = given(tool, found[i].second, 100);
        e.commanded = std::max(e.commanded, g.commanded);
        e.sent = std::max(e.sent, g.sent);
        if (force == Force::Full) continue;
        tool.rub(Friction::Paper);
        const Given r = given(tool, found[i].second, 100);
        e.rubbed_commanded = std::max(e.rubbed_commanded, r.commanded);
        e.rubbed_sent = std::max(e.rubbed_sent, r.sent);
    }
    std::vector<double> shares;
    for (const auto& [share, round] : found) shares.push_back(std::abs(share));
    e.median = percentile(shares, 0.5);
    return e;
}

std::string slide_csv(const Slide& slide)
{
    std::string text =
        "way,x,y,z,mesh_x,mesh_y,mesh_z,shaded_x,shaded_y,shaded_z,ours_x,ours_y,ours_z,unsmoothed_x,unsmoothed_y,unsmoothed_z,"
        "smoothed_x,smoothed_y,smoothed_z,averaged_x,averaged_y,averaged_z,true_depth,felt_depth,sharp\n";
    std::size_t path = 0;
    for (std::size_t i = 0; i < slide.ticks.size(); ++i) {
        const SlideTick& t = slide.ticks[i];
        while (path < slide.first.size() && slide.first[path] <= i) ++path;
        char cells[100];
        text += std::to_string(path);
        std::snprintf(cells, sizeof cells, ",%.7g,%.7g,%.7g", t.at.x, t.at.y, t.at.z);
        text += cells;
        for (const Vec3d& force : {t.mesh, t.shaded, t.ours, t.unsmoothed, t.smoothed, t.averaged}) {
            std::snprintf(cells, sizeof cells, ",%.6g,%.6g,%.6g", force.x, force.y, force.z);
            text += cells;
        }
        std::snprintf(cells, sizeof cells, ",%.6g,%.6g,%d\n", t.true_depth, t.effective_depth, t.sharp ? 1 : 0);
        text += cells;
    }
    return text;
}

}  // namespace sqmap::bench
