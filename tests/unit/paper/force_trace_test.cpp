// Section 6 tick by tick: the servo's force of a whole impact zone on paper models against eqs. 21, 22, 26, 32 and 33, worked out
// here in double from the stored arrays.
#include "../haptic/touching.h"
#include "force_by_equations.h"
#include "math/random.h"
#include "math/triangle.h"
#include "sqmap/bake_mesh.h"
#include "sqmap/paper/force.h"
#include "sqmap/query/point.h"
#include "support/paper_model.h"
#include "support/shared_folder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

namespace sqmap::haptic::test {
namespace {

using paper::ProjectionOptions;
using paper::Projector;
using paper::by_equations::Spring;
using query::Layer;

constexpr double k_stiffness = 300;
/// Ticks of one path; the next one begins elsewhere, with another friction.
constexpr int k_path = 40;

/// How a trace is computed.
struct Traced {
    Layer layer = Layer::Three;
    Projector projector = Projector::Newton;
    bool smoothed = true;
    bool one_point = false;  ///< else a zone
    int nearest_steps = 0;
};

/// Rounding of a spring's depth times normal: of positions, which are floats of the solid's size, and of the normal, whose
/// weights are positions in a cell of a grid of up to some hundred columns, so that 8 of a float's 24 bits count the cell.
double rounding_of(const Spring& s, double r_max) { return 1e-5 * s.depth + 2.5e-7 * r_max + s.rounding; }

/// An impact zone: points of a ball, each with an area of its own, within an impact sphere.
struct BallZone {
    explicit BallZone(double size, bool one_point)
    {
        points = mesh::sphere(size, 1).vertices;
        if (one_point) points = {{}};
        SplitMix64 random(3);
        for (std::size_t i = 0; i < points.size(); ++i) weights.push_back(static_cast<float>(random.between(0.5, 2)));
        radius = one_point ? INFINITY : 1.4 * size;
    }
    [[nodiscard]] double weight(std::size_t i) const
    {
        const double s = 1 - norm_sq(points[i]) / (radius * radius);
        return double(weights[i]) * s * s;
    }

    std::vector<Vec3d> points;
    std::vector<float> weights;
    double radius;
};

/// The mean of a zone's springs, and how far rounding may take it.
struct Mean {
    Vec3d force{};  ///< over the stiffness
    double depth = 0, rounding = 0;
    int springs = 0, decided = 0;  ///< of the springs those that the equations alone give
};

Mean mean_spring(const model::ModelView& view, const BallZone& zone, Vec3d at, const Traced& traced)
{
    const ProjectionOptions options{.layer = traced.layer, .projector = traced.projector, .nearest_steps = traced.nearest_steps};
    const auto r = static_cast<double>(view.header.r_max);
    Mean out;
    double weights = 0;
    for (std::size_t i = 0; i < zone.points.size(); ++i) {
        const Vec3f p = cast<float>(zone.points[i]) + cast<float>(at);
        std::optional<Spring> spring = paper::by_equations::spring_by_equations(view, p, options, traced.smoothed);
        const bool decided = spring.has_value();
        if (!decided) {
            // The point's own query says which sample or part was read where rounding decides that.
            const query::PointResult found =
                query::query_point(view, cast<double>(p), {.layer = traced.layer, .smoothed_map = traced.smoothed});
            spring = Spring{};
            if (found.contact && (found.status & query::k_no_surface) == 0) spring = Spring{found.depth, found.normal};
        }
        if (!(spring->depth > 0)) continue;
        const double w = zone.weight(i);
        weights += w;
        out.force += (w * spring->depth) * spring->normal;
        out.depth += w * spring->depth;
        out.rounding += w * rounding_of(*spring, r);
        ++out.springs;
        out.decided += decided;
    }
    if (weights > 0) {
        out.force = out.force / weights;
        out.depth /= weights;
        out.rounding /= weights;
    }
    return out;
}

/// Friction as documented: eq. 33 against the motion since the last tick, or a spring that sticks and slips.
class FrictionByEquations {
public:
    explicit FrictionByEquations(const Material& material) : material_(material) {}

    /// N. slips: what the servo has decided, where rounding does.
    Vec3d force(const Mean& mean, Vec3d motion, double tangential, bool slips)
    {
        if (mean.springs == 0) stretch_ = {}, mu_ = off_ = 0;
        if (mean.springs == 0 || material_.friction == Friction::None) return {};
        if (material_.friction == Friction::Paper)
            return (norm(motion) > 0 ? -material_.f_c * (1 + material_.k_f * mean.depth) / norm(motion) : 0.) * motion;
        const Vec3d n = normalized(mean.force);
        if (mu_ == 0) mu_ = material_.mu_static;
        stretch_ += motion;
        stretch_ -= dot(stretch_, n) * n;
        off_ += norm(motion) * mean.rounding / norm(mean.force);
        const double pull = tangential * norm(stretch_), load = k_stiffness * norm(mean.force), limit = mu_ * load;
        if (std::abs(pull - limit) > 1e-4 * limit) slips = pull > limit;
        mu_ = slips ? material_.mu_dynamic : material_.mu_static;
        if (slips) stretch_ = (mu_ * load / pull) * stretch_;
        return -tangential * stretch_;
    }

    /// How far rounding may take the stretch.
    [[nodiscard]] double off() const { return off_; }

private:
    const Material& material_;
    Vec3d stretch_{};
    double off_ = 0;  ///< of the stretch, by what rounding turned the normals of all ticks so far
    double mu_ = 0;   ///< 0: free
};

struct Counts {
    int touching = 0, springs = 0, decided = 0;
};

/// Paths about the surface that a part's map shows: along its superquadric, a few hundredths of R_max deep or above.
class Paths {
public:
    Paths(const model::ModelView& view, std::uint64_t seed) : view_(view), random_(seed) {}

    Vec3d next(int tick)
    {
        if (tick % k_path == 0) start();
        eta_ = std::clamp(eta_ + 0.0015 * turn_eta_, -1.5, 1.5);
        omega_ += 0.0015 * turn_omega_;
        const double share = double(tick % k_path) / k_path;
        const paper::MapView map = paper::map_of(view_, part_);
        const auto at = shape::surface_point(shape::cast<double>(map.superquadric), shape::SurfaceAngles<double>{eta_, omega_});
        return at.point - (above_ + double(view_.header.r_max) * ((1 - share) * from_ + share * to_)) * at.normal;
    }

private:
    void start()
    {
        paper::MapSample found;
        do {
            part_ = static_cast<std::size_t>(random_.between(0, double(view_.parts.size()) - 1e-9));
            eta_ = random_.between(-1.4, 1.4), omega_ = random_.between(-2.9, 2.9);
            found = paper::sample_map(paper::map_of(view_, part_), {static_cast<float>(eta_), static_cast<float>(omega_)}, {});
        } while ((found.flags & (paper::k_projection_cap | paper::k_projection_miss)) != 0);
        above_ = double(found.distance);
        turn_eta_ = random_.between(-1, 1), turn_omega_ = random_.between(-1, 1);
        from_ = random_.between(-0.02, 0.04), to_ = random_.between(-0.02, 0.04);
    }

    const model::ModelView& view_;
    SplitMix64 random_;
    std::size_t part_ = 0;
    double eta_ = 0, omega_ = 0, turn_eta_ = 0, turn_omega_ = 0, above_ = 0, from_ = 0, to_ = 0;
};

/// Ticks of a tool along paths: each force against the equations.
Counts follow(sqmap::test::PaperModel& baked, const Traced& traced, int ticks)
{
    baked.set_options({.projector = traced.projector, .nearest_steps = traced.nearest_steps});
    const model::ModelView& view = baked.in_model_space();
    const auto r = static_cast<double>(view.header.r_max);
    ZoneOptions options = paper::with_paper_force({.layer = traced.layer, .stiffness = k_stiffness});
    options.smoothed_map = traced.smoothed;
    const BallZone ball(0.02 * r, traced.one_point);
    const query::Probe probe(ball.points);
    const Zone zone{.probe = &probe, .weights = ball.weights, .radius = ball.radius, .options = options};
    State state(std::span(&zone, 1));
    Paths paths(view, 7);
    Counts count;
    Vec3d before{};
    TouchedBody body{.model = &view};
    std::optional<FrictionByEquations> friction;
    for (int tick = 0; tick < ticks; ++tick) {
        const Vec3d at = paths.next(tick);
        const bool starts = tick % k_path == 0;
        if (starts) {
            constexpr Friction k_kinds[] = {Friction::Paper, Friction::None, Friction::Coulomb};
            body.material.friction = k_kinds[tick / k_path % 3];
            state.reset();
            friction.emplace(body.material);
        }
        const Pose pose = shifted(at);
        Wrench wrench;
        const StepResult result = step(state, {.touched = {&body, 1}, .poses = {&pose, 1}}, {&wrench, 1}, {});
        EXPECT_EQ(result.status & ~(k_step_contact | k_step_slipping | k_step_no_surface), 0u) << tick;
        const Vec3d motion = starts ? Vec3d{} : at - before;
        const Mean mean = mean_spring(view, ball, at, traced);
        const Vec3d rub = friction->force(mean, motion, options.tangential_stiffness, (result.status & k_step_slipping) != 0);
        const double error = norm(wrench.force - (k_stiffness * mean.force + rub)),
                     allowed = k_stiffness * (1 + body.material.mu_static) * mean.rounding +
                               options.tangential_stiffness * friction->off() + 1e-9;
        before = at;
        count.touching += mean.springs > 0;
        count.springs += mean.springs;
        count.decided += mean.decided;
        EXPECT_LE(error, allowed) << "tick " << tick << ", layer " << static_cast<int>(traced.layer) << ", projector "
                                  << static_cast<int>(traced.projector) << ", steps " << traced.nearest_steps
                                  << (traced.smoothed ? ", smoothed" : ", plain") << ", springs " << mean.springs << ", of which "
                                  << mean.decided << " decided, friction " << static_cast<int>(body.material.friction);
    }
    return count;
}

/// Every projector and layer, and both maps, felt by a point and by a zone.
void follow_all(sqmap::test::PaperModel& baked, int ticks)
{
    constexpr Traced k_kinds[] = {{.layer = Layer::Two, .projector = Projector::Printed},
                                  {.layer = Layer::Three, .projector = Projector::Printed},
                                  {.layer = Layer::Three, .projector = Projector::Pyramid},
                                  {.layer = Layer::Three, .projector = Projector::Newton},
                                  {.layer = Layer::Three, .projector = Projector::Newton, .nearest_steps = 2}};
    for (const Traced& kind : k_kinds) {
        int springs = 0, decided = 0;
        for (const bool one_point : {true, false})
            for (const bool smoothed : {true, false}) {
                Traced traced = kind;
                traced.one_point = one_point;
                traced.smoothed = smoothed;
                const int n = smoothed ? ticks : ticks / 4;
                const Counts count = follow(baked, traced, n);
                EXPECT_GT(count.touching, n / 20);
                springs += count.springs;
                decided += count.decided;
            }
        // Rounding decides more often where closest-point steps start from every part: of the camel's springs in 11 %.
        EXPECT_GT(decided, (kind.nearest_steps > 0 ? 0.88 : 0.98) * springs)
            << "the equations alone give nearly all, projector " << static_cast<int>(kind.projector) << ", steps "
            << kind.nearest_steps;
    }
}

/// With triangles: these take the place of the maps on the exact layer alone.
sqmap::test::PaperModel& small_hand_model()
{
    static sqmap::test::PaperModel baked(sqmap::test::small_hand());
    return baked;
}

TEST(PaperForceTrace, EveryTickIsEqs21To33OnTheStoredMap) { follow_all(small_hand_model(), 400); }

TEST(PaperForceTrace, OnTheExactLayerItIsTheMeanOverNearestPointsOfTheMesh)
{
    const mesh::Mesh& mesh = sqmap::test::small_hand();
    const model::ModelView& view = small_hand_model().view();
    const double r = view.header.r_max * view.header.unit;
    const BallZone ball(0.02 * r, false);
    const query::Probe probe(ball.points);
    const ZoneOptions options = paper::with_paper_force({.layer = Layer::Exact, .stiffness = k_stiffness});
    const Zone zone{.probe = &probe, .weights = ball.weights, .radius = ball.radius, .options = options};
    State state(std::span(&zone, 1));
    TouchedBody body{.model = &view};
    body.material.friction = Friction::None;
    SplitMix64 random(11);
    int springs = 0;
    for (int tick = 0; tick < 30; ++tick) {
        const auto& corners = mesh.triangles[static_cast<std::size_t>(random.between(0, double(mesh.triangles.size()) - 1e-9))];
        const Pose pose = shifted(mesh.vertices[corners[0]]);
        Wrench wrench;
        state.reset();
        (void)step(state, {.touched = {&body, 1}, .poses = {&pose, 1}}, {&wrench, 1}, {});
        Vec3d sum{};
        double weights = 0;
        for (std::size_t i = 0; i < ball.points.size(); ++i) {
            const Vec3d p = ball.points[i] + pose.translation;
            if (!query::query_point(view, p, {.layer = Layer::Exact}).contact) continue;
            Vec3d out{INFINITY, 0, 0};
            for (const auto& t : mesh.triangles) {
                const Vec3d c = closest_point_on_triangle(p, mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]) - p;
                if (norm_sq(c) < norm_sq(out)) out = c;
            }
            weights += ball.weight(i);
            sum += ball.weight(i) * out;
            ++springs;
        }
        const Vec3d expected = weights > 0 ? (k_stiffness / weights) * sum : Vec3d{};
        EXPECT_LT(norm(wrench.force - expected), k_stiffness * 1e-6 * r) << tick;
    }
    EXPECT_GT(springs, 150);
}

class PaperForceTraceOfAnimals : public testing::TestWithParam<const char*> {
protected:
    /// Follows traces on the animal's model.
    static void follow_ticks(int ticks, bool doubtful = false)
    {
        const std::filesystem::path file = sqmap::test::real_mesh_file(GetParam());
        if (file.empty()) GTEST_SKIP() << "there is no " << GetParam();
        const AdmittedMesh admitted = admit_mesh(file);
        ASSERT_FALSE(admitted.refused());
        sqmap::test::PaperModel baked(admitted.mesh);
        if (doubtful) ASSERT_TRUE(model::is_doubtful(baked.view().measured)) << "take a mesh whose model is in doubt";
        follow_all(baked, ticks);
    }
};
/// Models whose layers below the exact one are in doubt, with triangles: the maps answer all the same.
class PaperForceTraceOfDoubtfulModels : public PaperForceTraceOfAnimals {};

TEST_P(PaperForceTraceOfAnimals, EveryTickIsEqs21To33OnTheStoredMap) { follow_ticks(10000); }
TEST_P(PaperForceTraceOfDoubtfulModels, EveryTickIsEqs21To33OnTheStoredMap) { follow_ticks(400, true); }

INSTANTIATE_TEST_SUITE_P(Meshes, PaperForceTraceOfAnimals,
                         testing::Values("cat_8108.obj", "horse_5946.obj", "elephant_10272.obj", "camel_4512.obj",
                                         "bull_7154.obj", "hand_9344.obj"),
                         [](const auto& param) {
                             const std::string name = param.param;
                             return name.substr(0, name.find('_')) + name.substr(name.find('_') + 1, 4);
                         });

INSTANTIATE_TEST_SUITE_P(Meshes, PaperForceTraceOfDoubtfulModels, testing::Values("bull_7154.obj"));

}  // namespace
}  // namespace sqmap::haptic::test
