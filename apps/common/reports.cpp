#include "common/reports.h"

#include "common/program_words.h"

#include <cstdio>

namespace sqmap::app {

using nlohmann::ordered_json;

namespace {

ordered_json distribution_json(const bake::Distribution& d)
{
    return {{"count", d.count}, {"mean", d.mean}, {"median", d.median}, {"p95", d.p95}, {"p99", d.p99}, {"max", d.max}};
}

}  // namespace

ordered_json evaluation_json(const bake::Evaluation& e)
{
    return {
        {"points", e.points},
        {"inside", e.inside},
        {"missed", e.missed},
        {"false_contacts", e.false_contacts},
        {"missed_at_any_distance", e.missed_any},
        {"false_at_any_distance", e.false_any},
        {"certain", e.certain},
        {"certain_wrong", e.certain_wrong},
        {"contradictions", e.contradictions},
        {"layer1_missed", e.layer1_missed},
        {"eq35_percent", distribution_json(e.eq35)},
        {"eq35_left_out_percent", e.eq35_left_out},
        {"eq35_one_sided_percent", e.eq35_one_sided},
        {"no_surface_percent", e.no_surface},
        {"depth_percent", distribution_json(e.depth)},
        {"normal_degrees", distribution_json(e.normal)},
        // A probe answers as its points do.
        {"frame", {{"missed", e.missed}, {"false_contacts", e.false_contacts}, {"depth_percent", distribution_json(e.depth)}}}};
}

void print_doubt(const model::ModelView& model)
{
    if (const std::optional<Note> doubt = doubt_of(model)) std::printf("%s\n", words(*doubt, k_program_settings).c_str());
}

const char* rung_suffix(const model::Cure& c)
{
    switch (c.rung) {
        case model::Rung::Closed:
            return ", CLOSED";
        case model::Rung::Wrapped:
            return ", WRAPPED";
        case model::Rung::AsItIs:
            break;
    }
    return "";
}

void print_cure(const model::Cure& c)
{
    if (c.rung == model::Rung::AsItIs) return;
    std::printf("  moved: from the file mean %.3g, p99 %.3g, max %.3g; to the file mean %.3g, p99 %.3g, max %.3g\n", c.from_mean,
                c.from_p99, c.from_max, c.to_mean, c.to_p99, c.to_max);
    std::printf("  made up: %.3g %% of the area\n", 100 * c.made_up_share);
}

void print_measured(const model::Measured& m)
{
    if (m.points == 0) return;
    std::printf("  layer 3 on %u points: %u missed, %u false (beyond 0.5 %% of R_max from the surface)\n", m.points, m.missed,
                m.false_contacts);
    std::printf("  along the projection (eq. 35): mean %.4f %%, p99 %.3f %%, max %.2f %% of R_max\n", m.eq35_mean, m.eq35_p99,
                m.eq35_max);
    std::printf("  depth: median %.4f %%, p95 %.3f %%, p99 %.3f %%, max %.2f %% of R_max; normal: median %.2f degrees\n",
                m.depth_median, m.depth_p95, m.depth_p99, m.depth_max, m.normal_median);
    std::printf("  surface that its part does not see first (Q2): %.2f %%\n", m.q2_share);
}

}  // namespace sqmap::app
