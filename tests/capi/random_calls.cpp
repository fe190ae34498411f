// Random calls of the C interface, so many or for so many seconds: every one returns a code, and no force leaves its limits.
// Pointers point to what they should or are null; numbers, sizes, bytes and handles are anything.
//
// usage: capi_random_calls CALLS|SECONDSs [SEED]
#include "sqmap.h"

#include "bake/bake.h"
#include "sqmap/io/model_file.h"
#include "sqmap/mesh/shapes.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <random>
#include <string>
#include <vector>

namespace {

using Random = std::mt19937_64;

std::size_t below(Random& random, std::size_t n) { return random() % n; }

double any_number(Random& random)
{
    constexpr double k_infinity = std::numeric_limits<double>::infinity();
    constexpr double k_special[] = {0,      -0.0,  1,      -1,  k_infinity, -k_infinity, std::numeric_limits<double>::quiet_NaN(),
                                    1e-320, 1e300, -1e300, 1e-3};
    return below(random, 3) == 0 ? k_special[below(random, std::size(k_special))]
                                 : std::uniform_real_distribution<double>(-2, 2)(random);
}

template <class T>
T struct_of(Random& random)
{
    T out{};
    out.size = below(random, 20) == 0 ? below(random, 10'000) : sizeof(T);
    // A size beyond the struct would have the library read what is not there: the caller's breach, not its input.
    if (out.size > sizeof(T) && out.size <= 4096) out.size = sizeof(T);
    return out;
}

sqmap_pose any_pose(Random& random)
{
    sqmap_pose pose{{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};
    for (double& t : pose.translation) t = any_number(random) * 0.1;
    if (below(random, 4) == 0) pose.rotation[below(random, 9)] = any_number(random);
    return pose;
}

struct Calls {
    explicit Calls(std::uint64_t seed)
        : random(seed), bytes(sqmap::io::serialize(sqmap::bake::bake(sqmap::mesh::torus(), true, {}).model))
    {
        for (double& v : numbers) v = 0;
    }

    Random random;
    std::vector<std::byte> bytes;
    std::vector<sqmap_model> models{{0}};
    std::vector<sqmap_probe> probes{{0}};
    std::vector<sqmap_workspace> workspaces{{0}};
    std::vector<sqmap_session> sessions{{0}};
    static constexpr std::size_t k_rows = 300;
    double numbers[3 * k_rows]{}, out_a[3 * k_rows]{}, out_b[3 * k_rows]{}, out_c[3 * k_rows]{}, out_d[3 * k_rows]{};
    std::uint8_t flags[k_rows]{};
    std::int32_t parts[k_rows]{};
    sqmap_contact contacts[k_rows]{};
    std::size_t counts[16]{};

    template <class T>
    T handle(std::vector<T>& open)
    {
        if (below(random, 20) == 0) return {random()};
        return open[below(random, open.size())];
    }
    template <class T>
    T* maybe(T& value)
    {
        return below(random, 30) == 0 ? nullptr : &value;
    }
    sqmap_points points(const sqmap_pose& pose)
    {
        for (double& v : numbers) v = any_number(random);
        sqmap_points out = struct_of<sqmap_points>(random);
        out.xyz = maybe(numbers[0]);
        out.count = below(random, k_rows + 1);
        out.pose = below(random, 2) == 0 ? nullptr : &pose;
        return out;
    }
    sqmap_query_options options()
    {
        sqmap_query_options out = struct_of<sqmap_query_options>(random);
        out.layer = static_cast<std::int32_t>(below(random, 8)) - 1;
        out.threads =
            below(random, 10) == 0 ? static_cast<std::uint32_t>(random()) : static_cast<std::uint32_t>(below(random, 4));
        if (below(random, 2) == 0) out.tolerance = any_number(random);
        if (below(random, 4) == 0) out.margin = any_number(random);
        if (below(random, 2) == 0) out.band = any_number(random);
        out.is_smooth = static_cast<std::int32_t>(below(random, 2));
        out.is_first_only = static_cast<std::int32_t>(below(random, 2));
        return out;
    }

    sqmap_code open_or_close()
    {
        if (below(random, 2) == 0 && models.size() > 1) {
            const std::size_t i = 1 + below(random, models.size() - 1);
            const sqmap_model closed = models[i];
            if (models.size() > 4) models.erase(models.begin() + static_cast<std::ptrdiff_t>(i));  // else it stays, closed
            return sqmap_close_model(closed);
        }
        std::vector<std::byte> changed = bytes;
        if (below(random, 2) == 0) {
            if (below(random, 2) == 0) changed.resize(below(random, changed.size()));
            for (std::size_t k = below(random, 4); k-- > 0 && !changed.empty();)
                changed[below(random, changed.size())] = static_cast<std::byte>(random());
        }
        sqmap_model model{};
        const sqmap_code code = sqmap_open_bytes(changed.data(), changed.size(), maybe(model));
        if (model.id != 0) models.push_back(model);
        return code;
    }
    sqmap_code bake()
    {
        std::int64_t corners[60];
        for (std::int64_t& c : corners) c = static_cast<std::int64_t>(below(random, 8)) - (below(random, 50) == 0 ? 1 : 0);
        for (double& v : numbers)
            v = below(random, 50) == 0 ? any_number(random) : std::uniform_real_distribution<double>(-1, 1)(random);
        sqmap_mesh mesh = struct_of<sqmap_mesh>(random);
        mesh.vertices = maybe(numbers[0]);
        mesh.vertex_count = below(random, 9);
        mesh.triangles = maybe(corners[0]);
        mesh.triangle_count = below(random, 21);
        sqmap_bake_options how = struct_of<sqmap_bake_options>(random);
        how.repair = static_cast<std::int32_t>(below(random, 7)) - 1;
        how.threads = 1;
        if (below(random, 3) == 0) how.target_error = any_number(random);
        if (how.target_error > 0 && how.target_error < 0.5) how.target_error = 0.5;  // less is taken too, but takes minutes
        if (below(random, 3) == 0) how.band = any_number(random);
        if (below(random, 3) == 0) how.thickness = any_number(random);
        how.accepts_surface = static_cast<std::int32_t>(below(random, 2));
        how.progress = [](void* context, const char*, double) {
            return static_cast<std::int32_t>((*static_cast<Random*>(context))() % 4 == 0);
        };
        how.progress_context = &random;
        sqmap_model model{};
        const sqmap_code code = sqmap_bake(&mesh, &how, maybe(model));
        if (model.id != 0) models.push_back(model);
        return code;
    }
    sqmap_code batch(std::size_t kind)
    {
        const sqmap_pose pose = any_pose(random);
        const sqmap_points in = points(pose);
        const sqmap_query_options how = options();
        sqmap_contacts c = struct_of<sqmap_contacts>(random);
        sqmap_distances d = struct_of<sqmap_distances>(random);
        sqmap_closest n = struct_of<sqmap_closest>(random);
        c.contact = c.certain = c.status = maybe(flags[0]);
        c.depth = maybe(out_a[0]);
        c.normal = maybe(out_b[0]);
        c.closest = maybe(out_c[0]);
        c.part = d.part = maybe(parts[0]);
        d.distance = n.distance = maybe(out_a[0]);
        d.gradient = maybe(out_b[0]);
        d.closest = n.closest = maybe(out_c[0]);
        d.known = d.status = maybe(flags[0]);
        n.triangle = reinterpret_cast<std::uint32_t*>(maybe(parts[0]));
        const sqmap_model model = handle(models);
        if (kind == 0) return sqmap_query_points(model, maybe(in), maybe(how), maybe(c));
        if (kind == 1) return sqmap_signed_distances(model, maybe(in), maybe(how), maybe(d));
        if (kind == 3) return sqmap_exact_distances(model, maybe(in), maybe(how), maybe(d));
        return sqmap_closest_points(model, maybe(in), maybe(how), maybe(n));
    }
    sqmap_code bodies(bool as_pair)
    {
        const sqmap_pose a = any_pose(random), b = any_pose(random);
        sqmap_bodies both = struct_of<sqmap_bodies>(random);
        both.a = {handle(models), handle(probes), maybe(a)};
        both.b = {handle(models), handle(probes), maybe(b)};
        const sqmap_query_options how = options();
        if (as_pair) {
            sqmap_pair_list list = struct_of<sqmap_pair_list>(random);
            return sqmap_query_pair(maybe(both), maybe(how), handle(workspaces), maybe(list));
        }
        sqmap_contact_list list = struct_of<sqmap_contact_list>(random);
        list.contacts = contacts;
        list.capacity = below(random, k_rows + 1);
        return sqmap_query_probe(maybe(both), maybe(how), maybe(list));
    }
    sqmap_code make()
    {
        const sqmap_pose pose = any_pose(random);
        if (below(random, 3) == 0) {
            sqmap_points in = points(pose);
            for (double& v : numbers)
                if (!std::isfinite(v) && below(random, 100) != 0) v = 0.5;
            sqmap_probe probe{};
            const sqmap_code code = sqmap_make_probe(maybe(in), maybe(probe));
            if (probe.id != 0) probes.push_back(probe);
            return code;
        }
        if (below(random, 2) == 0) {
            sqmap_workspace workspace{};
            const sqmap_code code = sqmap_make_workspace(below(random, 100), maybe(workspace));
            if (workspace.id != 0) workspaces.push_back(workspace);
            return code;
        }
        sqmap_session_options how = struct_of<sqmap_session_options>(random);
        how.pose = maybe(pose);
        double* const members[] = {&how.metres_per_unit,  &how.radius,    &how.stiffness, &how.damping,
                                   &how.friction,         &how.side_path, &how.max_force, &how.force_limit,
                                   &how.continuous_force, &how.f_c,       &how.k_f};
        for (double* member : members)
            if (below(random, 4) == 0) *member = any_number(random);
        how.mode = static_cast<std::int32_t>(below(random, SQMAP_MODE_COUPLED + 2));
        how.force = static_cast<std::int32_t>(below(random, SQMAP_FORCE_PAPER + 2));
        how.friction_law = static_cast<std::int32_t>(below(random, SQMAP_FRICTION_NONE + 2));
        how.projector = static_cast<std::int32_t>(below(random, SQMAP_PROJECTOR_PRINTED + 2));
        how.nearest_steps = static_cast<std::int32_t>(below(random, 4)) - 1;
        sqmap_session session{};
        const sqmap_code code = sqmap_make_session(handle(models), maybe(how), maybe(session));
        if (session.id != 0) sessions.push_back(session);
        return code;
    }
    sqmap_code touch()
    {
        sqmap_tick tick = struct_of<sqmap_tick>(random);
        tick.time = any_number(random);
        tick.sample_time = any_number(random);
        tick.sequence = random();
        tick.pose = any_pose(random);
        tick.acts = static_cast<std::uint32_t>(below(random, 64));
        sqmap_force force = struct_of<sqmap_force>(random);
        const bool whole = force.size == sizeof force;
        force.force[0] = 1e9;
        const sqmap_code code = sqmap_tick_session(handle(sessions), maybe(tick), &force);
        const double size = std::hypot(force.force[0], force.force[1], force.force[2]);
        if (whole && !(size <= 2 + 1e-9)) {
            std::printf("a force of %g N\n", size);
            std::exit(1);
        }
        return code;
    }
    sqmap_code simulate()
    {
        for (double& v : numbers) v = below(random, 500) == 0 ? any_number(random) : 0.01 * any_number(random);
        sqmap_simulation run = struct_of<sqmap_simulation>(random);
        run.targets = maybe(numbers[0]);
        run.count = below(random, k_rows + 1);
        run.positions = maybe(out_a[0]);
        run.forces = maybe(out_b[0]);
        run.depths = maybe(out_c[0]);
        run.tools = maybe(out_d[0]);
        return sqmap_simulate(handle(sessions), maybe(run));
    }
    sqmap_code describe()
    {
        char space[200];
        sqmap_text text = struct_of<sqmap_text>(random);
        text.text = below(random, 4) == 0 ? nullptr : space;
        text.capacity = below(random, sizeof space + 1);
        sqmap_facts facts = struct_of<sqmap_facts>(random);
        const sqmap_model model = handle(models);
        if (below(random, 2) == 0) return sqmap_model_facts(model, maybe(facts));
        return below(random, 2) == 0 ? sqmap_info(model, maybe(text)) : sqmap_notes(model, maybe(text));
    }
    template <class T>
    sqmap_code close(std::vector<T>& open, sqmap_code (*closes)(T))
    {
        const T one = handle(open);
        if (open.size() > 8) open.erase(open.begin() + 1 + static_cast<std::ptrdiff_t>(below(random, open.size() - 1)));
        return closes(one);
    }

    sqmap_code any()
    {
        switch (below(random, 12)) {
            case 0:
                return open_or_close();
            case 1:
                return below(random, 10) == 0 ? bake() : describe();
            case 2:
            case 3:
            case 4:
                return batch(below(random, 4));
            case 5:
                return bodies(false);
            case 6:
                return bodies(true);
            case 7:
                return make();
            case 8:
                return touch();
            case 9:
                return simulate();
            case 10:
                return below(random, 2) == 0 ? close(probes, sqmap_close_probe) : close(workspaces, sqmap_close_workspace);
            default:
                return close(sessions, sqmap_close_session);
        }
    }
};

}  // namespace

int main(int argc, char** argv)
{
    const std::string length = argc > 1 ? argv[1] : "1000";
    const bool is_time = length.back() == 's';
    const auto seed = static_cast<std::uint64_t>(argc > 2 ? std::atoll(argv[2]) : 1);
    Calls calls(seed);
    const auto begin = std::chrono::steady_clock::now();
    const auto is_done = [&](std::size_t done) {
        const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - begin;
        return is_time ? passed.count() > std::atof(length.c_str())
                       : done >= static_cast<std::size_t>(std::atoll(length.c_str()));
    };
    for (std::size_t done = 0; !is_done(done); ++done) {
        const sqmap_code code = calls.any();
        if (code < SQMAP_OK || code >= SQMAP_E_INTERNAL) {
            std::printf("code %d: %s (seed %llu)\n", static_cast<int>(code), sqmap_last_error()->message,
                        static_cast<unsigned long long>(seed));
            return 1;
        }
        ++calls.counts[code];
    }
    std::printf("%zu answered", calls.counts[0]);
    for (int code = 1; code < SQMAP_E_INTERNAL; ++code) std::printf(", %zu of code %d", calls.counts[code], code);
    std::printf(" (seed %llu)\n", static_cast<unsigned long long>(seed));
    return calls.counts[SQMAP_OK] > 100 && calls.counts[SQMAP_E_ARGUMENT] > 100 && calls.counts[SQMAP_E_HANDLE] > 100 ? 0 : 1;
}
