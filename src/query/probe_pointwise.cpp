// K. Moustakas, D. Tzovaras, M. G. Strintzis, SQ-Map, IEEE TVCG 13(1), 2007, sections 4.1 (eq. 12) and 4.2.
#include "query/probe_pointwise.h"

#include "query/exact/exact_layer.h"
#include "query/layer.h"
#include "query/margin.h"

#include <algorithm>

namespace sqmap::query {

namespace {

class PointwiseProbe {
public:
    PointwiseProbe(const ProbeJob& job, const QueryOptions& options)
        : job_(job),
          reach_(offset_reach(job.model, options)),
          options_{.layer = job.layer, .gate = options.gate, .offset = options.offset, .margin = options.margin}
    {
        result_.anchor = job.caller.anchor;
    }

    ProbeResult run()
    {
        for (std::size_t g = 0; g < job_.groups; ++g) {
            if (is_far({job_.group_x[g], job_.group_y[g], job_.group_z[g]}, job_.group_radius[g])) continue;
            for (std::size_t c = g * Probe::k_cluster; c < std::min(job_.clusters, (g + 1) * Probe::k_cluster); ++c) {
                if (is_far({job_.centre_x[c], job_.centre_y[c], job_.centre_z[c]}, job_.radius[c])) continue;
                // The last cluster is filled up with its last point.
                for (std::size_t slot = c * Probe::k_cluster; slot < std::min(job_.points, (c + 1) * Probe::k_cluster); ++slot) {
                    compute(slot);
                    if (job_.first_only && result_.contacts > 0) return result_;
                }
            }
        }
        return result_;
    }

private:
    /// True where no point of a sphere (of the probe) is within reach of a part.
    bool is_far(Vec3f centre, float radius) const
    {
        const Vec3f c = job_.in_model_space(centre);
        const float margin = radius * job_.scale + reach_;
        const auto apart = [&](const float* sphere) {
            const float within = (margin + sphere[3]) * 1.0001f;
            return !(norm_sq(c - model::vec3(sphere)) <= within * within);
        };
        return apart(job_.model.header.sphere) || std::all_of(job_.model.parts.begin(), job_.model.parts.end(),
                                                              [&](const model::Part& part) { return apart(part.sphere); });
    }

    void compute(std::size_t slot)
    {
        const ModelContact c =
            query_with_margin(job_.model, job_.in_model_space({job_.x[slot], job_.y[slot], job_.z[slot]}), options_);
        if (!c.contact) return;
        const std::size_t at = result_.contacts++;
        if (at < job_.out.size())
            job_.out[at] = job_.caller.convert(contact_of(c, job_.point[slot]));
        else
            result_.status |= k_full;
    }

    const ProbeJob& job_;
    float reach_;
    QueryOptions options_;
    ProbeResult result_;
};

}  // namespace

float offset_reach(const model::ModelView& model, const QueryOptions& options) noexcept
{
    if (model.answers != nullptr) return model.answers->reach(model, options);
    float reach = margin_in_model(model, options);
    if (!options.offset) return reach;
    for (const model::Part& part : model.parts) reach = std::max(reach, 255.f * part.offset_step);
    return reach;
}

ProbeResult run_probe_pointwise(const ProbeJob& job, const QueryOptions& options) noexcept
{
    return PointwiseProbe(job, options).run();
}

bool goes_by_points(const ProbeJob& job, const QueryOptions& options) noexcept
{
    return options.offset || options.margin > 0 || !model::has_locator(job.model);
}

ProbeResult run_exact_layer(const ProbeJob& job, const QueryOptions& options) noexcept
{
    return goes_by_points(job, options) ? run_probe_pointwise(job, options) : run_probe_exact(job);
}

}  // namespace sqmap::query
