#include "queried_model.h"

#include "sqmap/query/distance.h"
#include "sqmap/query/point.h"
#include "sqmap/query/probe.h"
#include "support/baked_shapes.h"

#include <gtest/gtest.h>

namespace sqmap::io {

using model::ModelData;
using model::ModelView;
using model::ParseStatus;

const ModelData& torus_model()
{
    static const ModelData k_model = [] {
        ModelData data =
            test::baked(mesh::torus({.major_radius = 1, .minor_radius = 0.3, .major_segments = 44, .minor_segments = 20}))
                .result.model;
        data.made_by = "test";
        data.source = "torus.obj";
        data.options = "none";
        return data;
    }();
    return k_model;
}

namespace {

/// A probe the size of the object, posed over it and beside it, in every layer that frames have. Answers must be numbers of
/// contacts, indices of points and existing parts.
void interrogate_frames(const ModelView& view, test::Random& random)
{
    std::vector<Vec3d> points(77);
    const double size = view.header.unit * static_cast<double>(view.header.sphere[3]);
    for (Vec3d& p : points) p = size * random.in_box({-1, -1, -1}, {1, 1, 1});
    const query::Probe probe(points);
    const Vec3d middle = model::to_mesh_units(view.header, model::vec3(view.header.sphere));
    query::Contact contacts[80];
    for (const double away : {0.0, 0.8})
        for (const query::Layer layer : {query::Layer::One, query::Layer::Two, query::Layer::Three, query::Layer::Exact}) {
            const sqmap::Pose pose{{}, middle + away * size * random.direction()};
            const query::ProbeResult result =
                query::query_probe({.model = &view}, {.probe = &probe, .pose = pose}, {.layer = layer}, contacts);
            ASSERT_LE(result.contacts, points.size());
            for (std::size_t i = 0; i < result.contacts; ++i) {
                EXPECT_LT(contacts[i].index, points.size());
                EXPECT_LT(contacts[i].part, static_cast<std::int32_t>(view.parts.size()));
            }
        }
}

/// Distances singly, in a batch and of a posed probe, within the band and all over the tree. Answers must be of existing parts.
void interrogate_distances(const ModelView& view, test::Random& random)
{
    const double size = view.header.unit * static_cast<double>(view.header.sphere[3]);
    const Vec3d middle = model::to_mesh_units(view.header, model::vec3(view.header.sphere));
    std::vector<Vec3d> points(40);
    for (std::size_t i = 0; i < points.size(); ++i)
        points[i] = middle + (i % 4 == 0 ? 4 : 1.2) * size * random.in_box({-1, -1, -1}, {1, 1, 1});
    std::vector<query::SignedDistance> answers(points.size());
    for (const double band : {query::k_baked_band, 2 * size}) {
        query::distances(view, points, answers, band);
        answers.push_back(query::distance(view, points[0], band));
        for (const query::SignedDistance& a : answers) EXPECT_LT(a.part, static_cast<std::int32_t>(view.parts.size()));
        answers.pop_back();
    }
    query::exact_distances(view, points, answers);
    for (const query::SignedDistance& a : answers) {
        EXPECT_LT(a.part, static_cast<std::int32_t>(view.parts.size()));
        EXPECT_LT(a.triangle, static_cast<std::int32_t>(view.triangle_part.size()));
    }
    const query::Probe probe(points);
    (void)query::is_nearer({&view}, {nullptr, &probe}, 0.1 * size);
}

}  // namespace

void interrogate(const ModelView& view, std::uint64_t seed)
{
    test::Random random(seed);
    const float r = view.header.sphere[3];
    for (int i = 0; i < 60; ++i) {
        Vec3f p = cast<float>(random.in_box({-1.2, -1.2, -1.2}, {1.2, 1.2, 1.2}));
        p = r * p + model::vec3(view.header.sphere);
        if (i % 4 == 0) p = model::vec3(view.parts[random.below(view.parts.size())].chart_centre);
        if (i % 8 == 1) p = 1e30f * p;
        for (const query::Layer layer :
             {query::Layer::One, query::Layer::Two, query::Layer::Three, query::Layer::Exact, query::Layer::Auto}) {
            const query::PointResult c = query::query_point(model::normalized(view), cast<double>(p), {.layer = layer});
            EXPECT_LT(c.part, static_cast<std::int32_t>(view.parts.size()));
        }
        const auto part = static_cast<std::uint32_t>(random.below(view.parts.size()));
        (void)query::distance_along_projection(model::normalized(view), part, cast<double>(p), query::Layer::Three);
    }
    interrogate_frames(view, random);
    interrogate_distances(view, random);
}

ParseStatus parse_and_query(std::span<const std::byte> bytes, std::uint64_t seed)
{
    Bytes copy(bytes);
    ModelView view;
    const ParseStatus status = model::parse(copy.span(), view);
    if (status == ParseStatus::Ok)
        interrogate(view, seed);
    else
        EXPECT_TRUE(view.parts.empty()) << "a refused model left a view behind";
    return status;
}

ParseStatus parse_changed(const std::function<void(ModelData&)>& change)
{
    ModelData data = torus_model();
    change(data);
    return parse_and_query(serialize(data));
}

}  // namespace sqmap::io
