#include "query/caller_frame.h"
#include "query/chart/central_query.h"
#include "query/exact/exact_layer.h"
#include "query/layer.h"
#include "query/margin.h"
#include "sqmap/math/assert.h"
#include "sqmap/query/point.h"

#include <algorithm>

namespace sqmap::query {

namespace {

using model::ModelView;

/// A point in the mesh's frame, before it is rounded to float.
Vec3d in_mesh(const Body& touched, Vec3d point) { return apply(inverse(touched.pose), point); }

PointResult in_caller_frame(const CallerFrame& frame, Vec3d point, const ModelContact& answer)
{
    PointResult result{answer.contact, answer.certain, answer.status, answer.part, 0, point, {}};
    if (!answer.contact) return result;
    const Contact contact = frame.convert(contact_of(answer, 0));
    result.depth = static_cast<double>(contact.depth);
    result.witness = frame.anchor + cast<double>(contact.witness);
    result.normal = cast<double>(contact.normal);
    return result;
}

/// The answer without a model, and for points that are not finite.
PointResult free_result(Vec3d point)
{
    PointResult result;
    result.witness = point;
    if (!is_finite(point)) result.status = k_not_finite;
    return result;
}

PointResult answer(const Body& touched, const CallerFrame& frame, Vec3d point, const QueryOptions& options)
{
    if (!is_finite(point)) return free_result(point);
    const Vec3f at = model::to_model_space(touched.model->header, in_mesh(touched, point));
    return in_caller_frame(frame, point, query_with_margin(*touched.model, at, options));
}

}  // namespace

PointResult query_point(const Body& touched, Vec3d point, const QueryOptions& options) noexcept
{
    if (touched.model == nullptr) return free_result(point);
    return answer(touched, {touched.model->header, touched.pose}, point, options);
}

PointResult query_point(const ModelView& model, Vec3d point, const QueryOptions& options) noexcept
{
    return query_point(Body{&model, nullptr, {}}, point, options);
}

std::size_t query_points(const Body& touched, std::span<const Vec3d> points, const QueryOptions& options,
                         std::span<PointResult> results) noexcept
{
    std::size_t count = 0;
    const CallerFrame frame = touched.model == nullptr ? CallerFrame{} : CallerFrame{touched.model->header, touched.pose};
    for (std::size_t i = 0; i < std::min(points.size(), results.size()); ++i) {
        results[i] = touched.model == nullptr ? free_result(points[i]) : answer(touched, frame, points[i], options);
        count += results[i].contact ? 1u : 0u;
    }
    return count;
}

std::optional<SurfacePoint> nearest_surface(const Body& touched, Vec3d point, const SurfacePoint& from) noexcept
{
    SQMAP_ASSERT(touched.model != nullptr && model::has_exact(*touched.model));
    const model::Header& header = touched.model->header;
    const auto in_model = [&](Vec3d p) { return model::to_model_space(header, in_mesh(touched, p)); };
    ModelContact start;
    start.witness = in_model(from.point);
    start.normal = cast<float>(transpose_mul(touched.pose.rotation, from.normal));
    const ModelContact nearest = nearest_in_model(*touched.model, in_model(point), start);
    if (!nearest.contact) return std::nullopt;
    const PointResult found = in_caller_frame({header, touched.pose}, point, nearest);
    return SurfacePoint{found.witness, found.normal, found.depth, found.part};
}

std::optional<double> distance_along_projection(const ModelView& model, std::uint32_t part, Vec3d point, Layer layer) noexcept
{
    SQMAP_ASSERT(part < model.parts.size());
    const Vec3f at = model::to_model_space(model.header, point);
    float distance = 0;
    const bool found = model.answers != nullptr ? model.answers->along(model, part, at, layer, distance)
                                                : distance_along_central(model, part, at, layer, distance);
    if (!found) return std::nullopt;
    return model.header.unit * static_cast<double>(distance);
}

}  // namespace sqmap::query
