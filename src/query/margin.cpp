#include "query/margin.h"

#include "query/dispatch/model_point.h"
#include "query/layer.h"
#include "sqmap/query/distance.h"

namespace sqmap::query {

ModelContact query_with_margin(const model::ModelView& model, Vec3f point, const QueryOptions& options) noexcept
{
    ModelContact contact = query_in_model(model, point, options);
    QueryOptions chosen = options;
    chosen.layer = chosen_layer(model, options);
    if (contact.contact || !is_margin_proven(model, chosen)) return contact;
    const model::Header& header = model.header;
    const SignedDistance found = distance(model, model::to_mesh_units(header, point), options.margin);
    if (found.known == DistanceKind::LowerBound || !(found.distance < options.margin)) return contact;
    contact.contact = true;
    contact.depth = static_cast<float>((options.margin - found.distance) / header.unit);
    contact.normal = cast<float>(found.gradient);
    contact.part = found.part;
    contact.witness =
        model::to_model_space(header, found.witness) + static_cast<float>(options.margin / header.unit) * contact.normal;
    contact.status |= found.status;
    return contact;
}

}  // namespace sqmap::query
