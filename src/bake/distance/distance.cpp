#include "bake/distance/distance.h"

namespace sqmap::bake {

namespace {

std::size_t other_bytes(const model::ModelView& v)
{
    using model::ArrayView;
    return v.parts.size_bytes() + model::bytes_of<model::CentralArrays<ArrayView>>(v) +
           model::bytes_of<model::MeshArrays<ArrayView>>(v) + model::bytes_of<model::LocatorArrays<ArrayView>>(v) +
           model::bytes_of<model::CandidateArrays<ArrayView>>(v);
}

}  // namespace

void bake_distance(const mesh::Solid& solid, const DistanceOptions& options, model::ModelData& data)
{
    data.distance = {};
    data.distance.header.band = static_cast<float>(0.01 * options.band * data.header.r_max);
    bake_hierarchy(data);
    bake_bounds(solid, other_bytes(data.view()) + options.beside, options.threads, data);
    if (data.triangle_part.empty()) bake_samples(solid, data);
}

}  // namespace sqmap::bake
