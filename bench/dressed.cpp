// Skin that is seen where cloth should hide it: garments on the walking figure, pulled, pinned and cut, as pictures in two
// colours.
#include "clock.h"
#include "common/dress/avatar.h"
#include "common/dress/costumes.h"
#include "measure.h"
#include "sqmap/math/box.h"
#include "sqmap/sim/cloth.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace sqmap::bench {
namespace {

constexpr double k_height = 1.75, k_rate = app::k_cloth_rate;
constexpr int k_frame = app::k_steps_a_frame, k_every = 10 * k_frame;  ///< steps: a frame of 30 a second, and every tenth
constexpr int k_width = 480, k_rows = 640;                             ///< pixels of a picture
constexpr double k_pixel = 2.1 / k_rows;                               ///< m
constexpr double k_behind = 0.02;                                      ///< m: cloth this far behind the skin should hide it
constexpr double k_max_pull = 30;                                      ///< N
constexpr double k_turn[] = {0, 90, 180, 270};                         ///< degrees: from where the figure is seen
constexpr float k_nothing = -1e9f;

using Triangles = std::span<const std::array<std::uint32_t, 3>>;

/// A view along a level direction: depth grows towards the eye.
struct Camera {
    double cosine = 1, sine = 0;
    [[nodiscard]] Vec3d of(Vec3d p) const
    {
        return {(cosine * p.x - sine * p.z) / k_pixel + 0.5 * k_width, k_rows - (p.y + 0.15) / k_pixel,
                sine * p.x + cosine * p.z};
    }
};

/// Calls at(pixel, depth, triangle, faces) for each pixel whose middle a triangle covers. faces: 1 where its outside is seen,
/// else -1.
template <class At>
void draw(const Camera& camera, std::span<const Vec3d> vertices, Triangles triangles, At&& at)
{
    std::vector<Vec3d> seen(vertices.size());
    for (std::size_t v = 0; v < seen.size(); ++v) seen[v] = camera.of(vertices[v]);
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        const Vec3d a = seen[triangles[t][0]], b = seen[triangles[t][1]], c = seen[triangles[t][2]];
        const double area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
        if (!(std::abs(area) > 1e-12)) continue;
        const int x0 = std::max(0, static_cast<int>(std::ceil(std::min({a.x, b.x, c.x}) - 0.5))),
                  x1 = std::min(k_width - 1, static_cast<int>(std::floor(std::max({a.x, b.x, c.x}) - 0.5))),
                  y0 = std::max(0, static_cast<int>(std::ceil(std::min({a.y, b.y, c.y}) - 0.5))),
                  y1 = std::min(k_rows - 1, static_cast<int>(std::floor(std::max({a.y, b.y, c.y}) - 0.5)));
        for (int y = y0; y <= y1; ++y)
            for (int x = x0; x <= x1; ++x) {
                const double px = x + 0.5, py = y + 0.5;
                const double u = ((px - a.x) * (c.y - a.y) - (py - a.y) * (c.x - a.x)) / area,
                             v = ((b.x - a.x) * (py - a.y) - (b.y - a.y) * (px - a.x)) / area;
                if (u < 0 || v < 0 || u + v > 1) continue;
                at(static_cast<std::size_t>(y) * k_width + static_cast<std::size_t>(x),
                   static_cast<float>(a.z + u * (b.z - a.z) + v * (c.z - a.z)), t, area < 0 ? 1 : -1);
            }
    }
}

struct Seen {
    std::size_t cloth = 0, skin = 0;  ///< pixels of cloth; of skin that cloth just behind it, in the body, should hide
    std::size_t before = 0;  ///< pixels of skin before cloth that is as near behind it, but beyond the body: a hand at a skirt
    [[nodiscard]] double percent() const { return of_cloth(skin); }
    [[nodiscard]] double percent_before() const { return of_cloth(before); }
    [[nodiscard]] double of_cloth(std::size_t pixels) const
    {
        return cloth > 0 ? 100.0 * static_cast<double>(pixels) / static_cast<double>(cloth) : 0;
    }
};

/// Triangles with a corner on an open edge: necklines, hems, holes, the edges of cuts. Skin beside them is meant to be seen.
std::vector<std::uint8_t> open_triangles(Triangles triangles, std::span<const std::uint32_t> name)
{
    std::multiset<std::pair<std::uint32_t, std::uint32_t>> edges;
    const auto edge = [&](const std::array<std::uint32_t, 3>& t, std::size_t k) {
        const std::uint32_t a = name[t[k]], b = name[t[(k + 1) % 3]];
        return std::pair{std::min(a, b), std::max(a, b)};
    };
    for (const auto& t : triangles)
        for (std::size_t k = 0; k < 3; ++k) edges.insert(edge(t, k));
    std::vector<std::uint8_t> rim(name.size()), out(triangles.size());
    for (const auto& t : triangles)
        for (std::size_t k = 0; k < 3; ++k)
            if (edges.count(edge(t, k)) == 1) rim[name[t[k]]] = rim[name[t[(k + 1) % 3]]] = 1;
    for (std::size_t t = 0; t < out.size(); ++t)
        for (const std::uint32_t v : triangles[t]) out[t] |= rim[name[v]];
    return out;
}

struct Figure {
    app::Avatar avatar;
    std::vector<Pose> poses;
    std::vector<sim::Collider> solids;

    void move(double time, bool first)
    {
        avatar.pose(time, poses);
        for (std::size_t p = 0; p < poses.size(); ++p) {
            solids[p].previous = first ? poses[p] : solids[p].pose;
            solids[p].pose = poses[p];
        }
    }
};

/// The greatest depth in the touched body, its time and position, and the number of frames in which there was any.
struct Depth {
    double deepest = 0, time = 0;
    Vec3d at{};
    std::size_t frames = 0;

    void add(double depth, Vec3d where, double when)
    {
        frames += depth > 0 ? 1 : 0;
        if (depth > deepest) deepest = depth, at = where, time = when;
    }
    [[nodiscard]] std::string text() const
    {
        char out[160];
        std::snprintf(out, sizeof out, "%.4f %% (at %.2f s, %.2f %.2f %.2f m; in %zu frames)", 100 * deepest / k_height, time,
                      at.x, at.y, at.z, frames);
        return out;
    }
};

/// One garment of one fabric through its time.
struct Run {
    std::string garment, fabric;
    std::vector<double> percent;  ///< of skin in each picture
    Seen worst;
    double before = 0;  ///< percent, the most of a picture
    double worst_time = 0, worst_turn = 0, step_ms = 0, pull = 0;
    Depth nodes, interiors;
    std::uint32_t status = 0;
    std::size_t vertices = 0;
};

/// A surface of the body that a pixel's ray crosses: into the body (1) or out of it (-1).
struct Crossing {
    float z;
    int into;
};

/// True for a depth at which a ray is in the body.
bool within(std::span<const Crossing> crossings, float z)
{
    int in = 0;
    for (const Crossing& c : crossings) in += c.z > z ? c.into : 0;
    return in > 0;
}

Seen look(const Camera& camera, std::span<const Vec3d> skin, Triangles skin_triangles, const sim::Cloth& cloth,
          std::span<const std::uint8_t> open)
{
    const std::size_t pixels = static_cast<std::size_t>(k_width) * k_rows;
    std::vector<float> body(pixels, k_nothing), front(pixels, k_nothing);
    std::vector<std::vector<Crossing>> crossings(pixels);
    draw(camera, skin, skin_triangles, [&](std::size_t p, float z, std::size_t, int faces) {
        body[p] = std::max(body[p], z);
        crossings[p].push_back({z, faces});
    });
    enum : std::uint8_t { Beyond = 1, In = 2 };
    std::vector<std::uint8_t> behind(pixels);
    draw(camera, cloth.positions(), cloth.triangles(), [&](std::size_t p, float z, std::size_t t, int) {
        front[p] = std::max(front[p], z);
        if (!(z < body[p]) || !(z > body[p] - static_cast<float>(k_behind)) || open[t] != 0) return;
        behind[p] = static_cast<std::uint8_t>(behind[p] | (within(crossings[p], z) ? In : Beyond));
    });
    Seen seen;
    for (std::size_t p = 0; p < pixels; ++p) {
        if (front[p] > body[p])
            ++seen.cloth;
        else if ((behind[p] & In) != 0)
            ++seen.skin;
        else if (behind[p] != 0)
            ++seen.before;
    }
    return seen;
}

/// Hands that take the cloth every three seconds, here and there, and pull it away from the body until it pulls with 30 N.
struct Hands {
    std::uint32_t random = 12345;
    bool holds = false;
    Vec3d at{}, away{};

    void move(sim::Cloth& cloth, int step, double& strongest)
    {
        constexpr int k_second = static_cast<int>(k_rate), k_period = 3 * k_second, k_take = k_second,
                      k_let_go = 5 * k_second / 2;
        const int phase = step % k_period;
        if (phase == k_take) {
            random = random * 1664525u + 1013904223u;
            const auto node = static_cast<std::uint32_t>(random % cloth.size());
            at = cloth.positions()[node];
            away = normalized(Vec3d{at.x, 0.15 * (random >> 30), at.z + 1e-6});
            cloth.grasp(node, 0.02, at);
            holds = true;
        }
        if (holds && phase == k_let_go) cloth.release(), holds = false;
        if (!holds) return;
        const double tension = norm(cloth.tension());
        strongest = std::max(strongest, tension);
        if (tension < k_max_pull) at += (0.6 / k_rate) * away;
        cloth.drag(at);
    }
};

Run play(Figure& figure, const std::string& garment, const std::string& fabric, double seconds, std::uint32_t vertices)
{
    Run run{garment, fabric, {}, {}, 0, 0, 0, 0, 0, {}, {}, 0, 0};
    app::Costume costume = app::costume(garment, vertices);
    figure.move(0, true);
    sim::Cloth cloth(costume.garment, sim::fabric(fabric), {.iterations = app::k_cloth_shares});
    cloth.expect(figure.avatar.skin->lattice);
    run.vertices = cloth.size();
    for (std::uint32_t j = 0; j < figure.avatar.joints.size(); ++j)
        if (figure.avatar.joints[j] == costume.waist_bone) cloth.pin(costume.garment.waist, 1 + j, figure.poses[1 + j]);
    std::vector<std::uint32_t> name(cloth.size());
    for (std::uint32_t v = 0; v < name.size(); ++v) name[v] = v;
    for (const sim::Seam& s : costume.garment.seams)
        for (const auto& pair : s.pairs) name[std::max(pair[0], pair[1])] = name[std::min(pair[0], pair[1])];
    std::vector<std::uint8_t> open = open_triangles(cloth.triangles(), name);
    const int steps = static_cast<int>(std::lround(seconds * k_rate));
    Hands hands;
    double spent = 0;
    for (int step = 1; step <= steps; ++step) {
        const double time = step / k_rate;
        figure.move(time, false);
        hands.move(cloth, step, run.pull);
        if (step == 2 * steps / 3 && cloth.seams() > 1) {
            cloth.cut(1);
            for (std::uint32_t v = 0; v < name.size(); ++v) name[v] = v;
            for (const auto& pair : costume.garment.seams[0].pairs) name[std::max(pair[0], pair[1])] = std::min(pair[0], pair[1]);
            open = open_triangles(cloth.triangles(), name);
        }
        const sim::StepReport r = cloth.step(1 / k_rate, figure.solids);
        run.status |= r.status;
        const sim::StepTime& s = r.seconds;
        spent += s.predict + s.move + s.query + s.response + s.threads + s.self;
        // As the page shows it.
        if (step % k_frame == 0) {
            const double start = bench::thread_seconds();
            (void)cloth.settle(figure.solids);
            spent += bench::thread_seconds() - start;
        }
        // While its seams are drawn together a garment is not worn yet.
        if (step % k_every != 0 || time < 1.5) continue;
        const std::vector<Vec3d> skin = figure.avatar.skin->posed();
        double percent = 0;
        for (const double turn : k_turn) {
            const double angle = turn * std::numbers::pi / 180;
            const Seen seen = look({std::cos(angle), std::sin(angle)}, skin, figure.avatar.parts[0].mesh.triangles, cloth, open);
            percent = std::max(percent, seen.percent());
            run.before = std::max(run.before, seen.percent_before());
            if (seen.percent() > run.worst.percent()) run.worst = seen, run.worst_time = time, run.worst_turn = turn;
        }
        run.percent.push_back(percent);
        const sim::Penetration deep = sim::penetration(cloth.positions(), cloth.triangles(), figure.solids, {.steps = 3});
        run.nodes.add(deep.nodes, deep.node_at, time);
        run.interiors.add(deep.interiors, deep.interior_at, time);
    }
    run.step_ms = 1e3 * spent / steps;
    return run;
}

void print(Run& run)
{
    std::sort(run.percent.begin(), run.percent.end());
    const double median = run.percent.empty() ? 0 : run.percent[run.percent.size() / 2];
    std::printf(
        "%-7s %-8s %5zu vertices  skin: median %.4f %%, worst %.4f %% (%zu of %zu pixels of cloth, at %.2f s from %.0f degrees), "
        "none in %zu of %zu frames; a part of the body before cloth near behind it: at most %.4f %%\n",
        run.garment.c_str(), run.fabric.c_str(), run.vertices, median, run.worst.percent(), run.worst.skin, run.worst.cloth,
        run.worst_time, run.worst_turn, static_cast<std::size_t>(std::count(run.percent.begin(), run.percent.end(), 0.0)),
        run.percent.size(), run.before);
    std::printf(
        "        depth in the touched body, share of the height: nodes %s, interiors %s; skin lies %.1f mm below it\n"
        "        pulled to %.1f N; a step %.2f ms of CPU time, %.2f of real time; status %u\n",
        run.nodes.text().c_str(), run.interiors.text().c_str(), 1e3 * app::k_skin_below, run.pull, run.step_ms,
        1e3 / (k_rate * run.step_ms), run.status);
    std::fflush(stdout);
}

}  // namespace

int measure_dressed(int argc, char** argv)
{
    double seconds = 6;
    std::uint32_t vertices = 3000;
    std::vector<std::string> garments, fabrics;
    for (int a = 1; a < argc; ++a) {
        const std::string_view word = argv[a];
        if (a + 1 >= argc) return k_wrong_usage;
        const std::string value = argv[++a];
        if (word == "--seconds")
            seconds = std::atof(value.c_str());
        else if (word == "--vertices")
            vertices = static_cast<std::uint32_t>(std::atoi(value.c_str()));
        else if (word == "--garment")
            garments.push_back(value);
        else if (word == "--fabric")
            fabrics.push_back(value);
        else
            return k_wrong_usage;
    }
    if (!(seconds > 0) || vertices < 16) return k_wrong_usage;
    if (garments.empty()) garments = {"shirt", "poncho", "skirt"};
    if (fabrics.empty()) fabrics = {"cotton", "silk", "leather"};
    Figure figure{app::walking_avatar(k_height, {}, app::k_figure_spacing, app::k_figure_error), {}, {}};
    figure.poses.resize(figure.avatar.parts.size() + figure.avatar.joints.size());
    figure.solids.resize(figure.poses.size());
    figure.solids[0].model = &figure.avatar.parts[0].model;
    figure.solids[0].skin = figure.avatar.skin->moving.get();
    for (const std::string& garment : garments)
        for (const std::string& fabric : fabrics) {
            Run run = play(figure, garment, fabric, seconds, vertices);
            print(run);
        }
    return 0;
}

}  // namespace sqmap::bench
