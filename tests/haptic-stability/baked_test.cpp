// Stability on baked models: what the haptic step makes of them, felt by every hand through every delay, at the stiffness that
// check_stiffness offers.
#include "haptic/stencil.h"
#include "loop.h"
#include "open_positions.h"
#include "sqmap/haptic/step.h"
#include "sqmap/query/point.h"
#include "support/parsed.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace sqmap::test {
namespace {

/// A point that touches one baked model, and the extremes of all its runs.
class Runs {
public:
    Runs(std::string name, const model::ModelView& model) : name_(std::move(name)) { solid_.model = &model; }

    void touch(const OpenPosition& position, Action action, const Setting& setting, double share, double speed)
    {
        state_.options(0).stiffness = state_.options(0).tangential_stiffness = setting.stiffness;
        solid_.material.friction = action == Action::Slide ? Friction::Coulomb : Friction::None;
        state_.reset();
        const Visit visit{.position = position.point, .out = position.out, .along = position.along, .speed = speed};
        const Figures f = run(setting, action, visit, [&](const Pose& pose) {
            Wrench w;
            (void)haptic::step(state_, {.touched = std::span(&solid_, 1), .poses = std::span(&pose, 1), .dt = k_tick},
                               std::span(&w, 1));
            return w;
        });
        ++runs_;
        created_ = std::max(created_, f.created);
        left_ = std::max(left_, f.left);
        largest_ = std::max(largest_, f.largest);
        passivity_ += f.filter.passivity;
        pressed_ += f.mean > 0.1;
        const std::string what = name_ + ' ' + test::name(action) + ' ' + setting.hand.name + " delay " +
                                 std::to_string(setting.mechanism.delay_ticks) + " v " + std::to_string(speed);
        if (share < 1) {
            swing_ = std::max(swing_, f.swing / still(setting));
            gained_ = std::max(gained_, f.gained);
            if (f.reversals >= 4) {
                ++swinging_;
                std::printf("%s swings by %.3f N at %.1f of the bound\n", what.c_str(), f.swing, k_share);
            }
            EXPECT_LT(f.gained, 1e-5) << what;
        } else {
            ++at_bound_;
            swinging_at_bound_ += f.reversals >= 4;
        }
        EXPECT_LT(f.created, 3e-3) << what << ": the filter's margin of 1 mJ and what passes before it has acted";
        EXPECT_EQ(f.over, 0u) << what;
        EXPECT_EQ(f.filter.faults, 0u) << what;
    }
    void expect_still_and_print() const
    {
        std::printf(
            "%s: %d runs, %llu pressed at the end; at %.1f of the bound %d of %d swing, at rest at most %.2f of what counts as "
            "swinging, "
            "gained by holding still %.3g J; at the bound %d of %d runs swing; energy created at most %.3g J, left by a contact "
            "%.3g J; greatest force %.3f N; passivity acted in %llu ticks\n",
            name_.c_str(), runs_, static_cast<unsigned long long>(pressed_), k_share, swinging_, runs_ - at_bound_, swing_,
            gained_, swinging_at_bound_, at_bound_, created_, left_, largest_, static_cast<unsigned long long>(passivity_));
        EXPECT_EQ(swinging_, 0);
        EXPECT_EQ(swinging_at_bound_, 0);
        EXPECT_GT(pressed_, static_cast<std::uint64_t>(runs_) / 2) << "the loops touch at all";
    }

private:
    static haptic::Zone zone_of(const query::Probe& probe)
    {
        haptic::Zone zone{.probe = &probe};
        zone.options.averaging = haptic::Averaging::Stencil;
        // As sqmap touch asks for a point. Layer 3's depths jump by tenths of a millimetre in thin parts, from one step of the
        // encoder to the next, and what follows a jump is late: 2 of these runs swing with it at 0.8 of the bound.
        zone.options.layer = query::Layer::Exact;
        return zone;
    }

    std::string name_;
    query::Probe probe_{haptic::stencil_points({})};
    haptic::Zone zone_ = zone_of(probe_);
    haptic::State state_{std::span(&zone_, 1), {.max_contacts = 256, .max_touched = 1}};
    haptic::TouchedBody solid_;
    double swing_ = 0, created_ = -1, left_ = -1, gained_ = -1, largest_ = 0;
    std::uint64_t passivity_ = 0, pressed_ = 0;
    int runs_ = 0, swinging_ = 0, at_bound_ = 0, swinging_at_bound_ = 0;
};

class StabilityOf : public testing::TestWithParam<const char*> {};

TEST_P(StabilityOf, EveryTouchOfABakedModel)
{
    const std::string name = GetParam();
    std::optional<mesh::Mesh> mesh;
    if (name == "torus" || name == "box")
        mesh = name == "torus" ? small_torus() : small_box();
    else
        mesh = shared_mesh(name + ".obj");
    if (!mesh) GTEST_SKIP() << name << " is not in " << test::shared_folder();
    const Parsed parsed(*mesh);
    const model::ModelView model =
        haptic::in_metres(parsed.view(), k_size / (parsed.view().header.r_max * parsed.view().header.unit));
    const std::vector<OpenPosition> positions = open_positions(parsed, model, 2);
    ASSERT_EQ(positions.size(), 2u);

    Runs runs(name, model);
    for (const OpenPosition& position : positions)
        for (const Action action : {Action::Press, Action::Slide, Action::Tap})
            for (const HandProfile& hand : device::k_hand_profiles)
                for (const int delay : {1, 2, 3})
                    for (const double share : {k_share, 1.})
                        for (const double speed : {0.2, 0.5}) {
                            if (share == 1 && speed == 0.5) continue;
                            Setting setting{.mechanism = {.delay_ticks = delay}, .hand = hand};
                            setting.stiffness = share * haptic::check_stiffness(limits_of(setting.mechanism), 0).largest;
                            runs.touch(position, action, setting, share, speed);
                        }
    runs.expect_still_and_print();
}

INSTANTIATE_TEST_SUITE_P(Meshes, StabilityOf,
                         testing::Values("torus", "box", "armadillo_10000", "bull_7154", "bunny_6966", "camel_4512", "cat_8108",
                                         "dragon_100004", "elephant_10272", "fandisk_8000", "fertility_9000", "hand_9344",
                                         "hand_9556", "horse_5946", "knot_6400", "rockerarm_10000", "torus_4608"),
                         [](const testing::TestParamInfo<const char*>& i) { return std::string(i.param); });

}  // namespace
}  // namespace sqmap::test
