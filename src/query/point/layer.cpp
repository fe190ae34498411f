#include "layer.h"

namespace sqmap::query {

Layer chosen_layer(const model::ModelView& model, const QueryOptions& options) noexcept
{
    Layer layer = options.layer;
    if (layer == Layer::Auto) {
        const auto& m = model.measured;
        // In percent of R_max; 0 where it was not measured.
        const double errors[] = {m.layer1_depth_p99, m.layer2_depth_p99, m.depth_p99};
        layer = Layer::Exact;
        for (int k = 2; k >= 0; --k)
            if (errors[k] > 0 && 0.01 * errors[k] * model.header.r_max * model.header.unit <= options.tolerance)
                layer = static_cast<Layer>(k);
    }
    return layer == Layer::Exact && !model::has_exact(model) ? Layer::Three : layer;
}

bool lacks_exact(const model::ModelView& model, const QueryOptions& options) noexcept
{
    if (model::has_exact(model)) return false;
    if (options.layer != Layer::Auto) return options.layer == Layer::Exact;
    const model::Measured& m = model.measured;
    return !(m.depth_p99 > 0 && 0.01 * m.depth_p99 * model.header.r_max * model.header.unit <= options.tolerance);
}

}  // namespace sqmap::query
