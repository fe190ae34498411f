#include "slide.h"

#include "../frames.h"
#include "sqmap/math/random.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace sqmap::bench {

namespace {

constexpr double k_sphere = 0.005;  ///< m

/// A tool of one zone, frictionless, and how it is asked.
class Tool {
public:
    Tool(const TouchObject& object, const SlideOptions& options)
        : probe_(haptic::stencil_points(options.sphere ? haptic::ball_of(k_sphere) : options.zone.smoothing)),
          zone_{.probe = &probe_, .options = zone_options(options)},
          state_(std::span(&zone_, 1), {.most_contacts = 2048, .most_solids = 1})
    {
        solid_.model = &object.view;
        solid_.material.friction = haptic::Friction::None;
        per_depth_ = options.stiffness;
    }

    Vec3d force(Vec3d at, bool fresh = false)
    {
        if (fresh) state_.reset();
        const Pose pose{{}, at};
        haptic::Wrench w;
        (void)haptic::step(state_, {.solids = std::span(&solid_, 1), .poses = std::span(&pose, 1)}, std::span(&w, 1));
        return w.force;
    }
    void reset() { state_.reset(); }
    double depth_of(Vec3d force) const { return norm(force) / per_depth_; }

private:
    static haptic::ZoneOptions zone_options(const SlideOptions& options)
    {
        haptic::ZoneOptions o = options.zone;
        o.averaging = options.sphere ? haptic::Averaging::Ball : haptic::Averaging::Stencil;
        if (options.sphere) o.smoothing.radius = k_sphere;
        o.stiffness = options.stiffness;
        return o;
    }

    using Pose = haptic::Pose;
    query::Probe probe_;
    haptic::Zone zone_;
    haptic::State state_;
    haptic::Solid solid_;
    double per_depth_ = 0;
};

struct Place {
    Vec3d point, normal;
};
/// Random places of the surface, by area, on the boundary of the solid.
std::vector<Place> random_places(const TouchObject& object, int count)
{
    std::vector<double> sum;
    double total = 0;
    for (std::uint32_t t = 0; t < object.mesh.triangles.size(); ++t) sum.push_back(total += mesh::triangle_area(object.mesh, t));
    SplitMix64 random(5);
    std::vector<Place> places;
    while (places.size() < static_cast<std::size_t>(count)) {
        const auto t =
            static_cast<std::uint32_t>(std::lower_bound(sum.begin(), sum.end(), total * random.uniform()) - sum.begin());
        if (t >= sum.size()) continue;
        double u = random.uniform(), v = random.uniform();
        if (u + v > 1) u = 1 - u, v = 1 - v;
        const auto& k = object.mesh.triangles[t];
        const Vec3d a = object.mesh.vertices[k[0]];
        const Vec3d p = a + u * (object.mesh.vertices[k[1]] - a) + v * (object.mesh.vertices[k[2]] - a);
        if (object.solid->boundary()[t] == mesh::Boundary::Whole) places.push_back({p, object.face_normals[t]});
    }
    return places;
}

}  // namespace

Slide slide(const TouchObject& object, const SlideOptions& options)
{
    Slide out;
    Tool tool(object, options);
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
                t.felt_depth = tool.depth_of(t.ours);
                t.sharp = object.near_sharp_edge(e.point, reach);
                out.ticks.push_back(t);
            }
        }
    // Where the mesh's own normal flips without a sharp edge (thin parts), all ticks about it are no smooth ground.
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

Steps steps_of(const Slide& slide, bool sharp)
{
    std::vector<double> steps[3];
    for (std::size_t w = 0; w < slide.first.size(); ++w) {
        const std::size_t end = w + 1 < slide.first.size() ? slide.first[w + 1] : slide.ticks.size();
        for (std::size_t i = slide.first[w] + 1; i < end; ++i) {
            const SlideTick &a = slide.ticks[i - 1], &b = slide.ticks[i];
            if ((a.sharp || b.sharp) != sharp) continue;
            steps[0].push_back(norm(b.mesh - a.mesh));
            steps[1].push_back(norm(b.shaded - a.shaded));
            steps[2].push_back(norm(b.ours - a.ours));
        }
    }
    Steps out;
    out.count = steps[0].size();
    if (out.count == 0) return out;
    for (int k = 0; k < 3; ++k) {
        out.max[k] = *std::max_element(steps[k].begin(), steps[k].end());
        out.p99[k] = percentile(steps[k], 0.99);
    }
    return out;
}

Onset onset(const TouchObject& object, const SlideOptions& options, int places)
{
    Tool tool(object, options);
    std::vector<double> found;
    for (const Place& p : random_places(object, places)) {
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
        found.push_back(std::abs(0.5 * (out + in) - radius));
    }
    if (found.empty()) return {};
    return {percentile(found, 0.5), percentile(found, 0.99), *std::max_element(found.begin(), found.end())};
}

NormalError normal_error(const TouchObject& object, const SlideOptions& options, int places)
{
    Tool tool(object, options);
    std::vector<double> angles;
    for (const Place& p : random_places(object, places)) {
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

Energy energy(const TouchObject& object, const SlideOptions& options, int places)
{
    Tool tool(object, options);
    SplitMix64 random(11);
    std::vector<double> shares;
    for (const Place& p : random_places(object, places)) {
        const Vec3d side = normalized(cross(p.normal, std::abs(p.normal.x) < 0.7 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0}));
        const double tilt = random.between(0, 6.283185307);
        const Vec3d u = std::cos(tilt) * side + std::sin(tilt) * cross(p.normal, side), v = p.normal;
        const double out = options.sphere ? k_sphere : 0;
        constexpr int n = 1500;
        double around = 0, moved = 0;
        Vec3d at{}, before{};
        tool.reset();
        for (int i = 0; i <= n; ++i) {
            const double a = 6.283185307179586 * (i % n) / n;
            const Vec3d next = p.point + (out - 0.001) * p.normal + 0.003 * std::cos(a) * u + 0.001 * std::sin(a) * v;
            const Vec3d f = tool.force(next);
            if (i > 0) {
                around += dot(0.5 * (f + before), next - at);
                moved += 0.5 * norm(f + before) * norm(next - at);
            }
            at = next, before = f;
        }
        if (moved > 0) shares.push_back(around / moved);
    }
    if (shares.empty()) return {};
    Energy e{*std::max_element(shares.begin(), shares.end()), 0, *std::min_element(shares.begin(), shares.end()), shares.size()};
    for (double& s : shares) s = std::abs(s);
    e.median = percentile(shares, 0.5);
    return e;
}

std::string slide_csv(const Slide& slide)
{
    std::string text =
        "way,x,y,z,mesh_x,mesh_y,mesh_z,shaded_x,shaded_y,shaded_z,ours_x,ours_y,ours_z,true_depth,felt_depth,sharp\n";
    std::size_t way = 0;
    for (std::size_t i = 0; i < slide.ticks.size(); ++i) {
        const SlideTick& t = slide.ticks[i];
        while (way < slide.first.size() && slide.first[way] <= i) ++way;
        char row[500];
        std::snprintf(row, sizeof row, "%zu,%.7g,%.7g,%.7g,%.6g,%.6g,%.6g,%.6g,%.6g,%.6g,%.6g,%.6g,%.6g,%.6g,%.6g,%d\n", way,
                      t.at.x, t.at.y, t.at.z, t.mesh.x, t.mesh.y, t.mesh.z, t.shaded.x, t.shaded.y, t.shaded.z, t.ours.x,
                      t.ours.y, t.ours.z, t.true_depth, t.felt_depth, t.sharp ? 1 : 0);
        text += row;
    }
    return text;
}

}  // namespace sqmap::bench
