#include "layer.h"

#include "sqmap/model/model.h"

namespace sqmap::query {

namespace {

/// True where bake measured an error, in percent of R_max, and it is within the tolerance. An error of 0 was not measured.
bool is_within(const model::ModelView& model, double error, double tolerance) noexcept
{
    return error > 0 && !model::is_doubtful(model.measured) && 0.01 * error * model.header.r_max * model.header.unit <= tolerance;
}

}  // namespace

Layer chosen_layer(const model::ModelView& model, const QueryOptions& options) noexcept
{
    Layer layer = options.layer;
    if (layer == Layer::Auto) {
        const auto& m = model.measured;
        const double errors[] = {m.layer1_depth_p99, m.layer2_depth_p99, m.depth_p99};
        layer = Layer::Exact;
        for (int k = 2; k >= 0; --k)
            if (is_within(model, errors[k], options.tolerance)) layer = static_cast<Layer>(k);
    }
    return layer == Layer::Exact && !model::has_exact(model) ? Layer::Three : layer;
}

bool lacks_exact(const model::ModelView& model, const QueryOptions& options) noexcept
{
    if (model::has_exact(model)) return false;
    if (options.layer != Layer::Auto) return options.layer == Layer::Exact;
    return !is_within(model, model.measured.depth_p99, options.tolerance);
}

}  // namespace sqmap::query
