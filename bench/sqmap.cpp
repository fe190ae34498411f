// The project's own method, a layer a name: bake with default options, then one query a frame.
#include "clock.h"
#include "method.h"
#include "sqmap/bake_mesh.h"
#include "sqmap/io/model_file.h"
#include "sqmap/query/probe.h"

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <utility>

namespace sqmap::bench {
namespace {

struct Baked {
    BakedModel model;
    model::ModelView view;
    io::SectionBytes sections;
    double build_s;
};

/// Baked once a setting, however many layers ask.
std::shared_ptr<const Baked> baked_model(const Setting& setting)
{
    static std::map<const Setting*, std::weak_ptr<const Baked>> made;
    if (auto known = made[&setting].lock()) return known;
    const double start = process_seconds();
    auto baked = std::make_shared<Baked>();
    bake::BakeOptions options;
    options.target_error = setting.target_error;
    options.threads = setting.threads;
    baked->model = bake_mesh(setting.object, {.bake = options});
    baked->build_s = process_seconds() - start;
    baked->view = baked->model.view();
    baked->sections = io::section_bytes(baked->view, baked->model.bytes().size());
    made[&setting] = baked;
    return baked;
}

class Sqmap final : public Method {
public:
    Sqmap(const Setting& setting, query::Layer layer, bool first_only)
        : baked_(baked_model(setting)),
          layer_(layer),
          first_only_(first_only),
          probe_(setting.probe.vertices),
          contacts_(probe_.size())
    {
        bytes = baked_->sections.total - baked_->sections.input;  // contacts read none of the caller's doubles and numbers
        if (layer != query::Layer::Exact) bytes -= baked_->sections.exact + baked_->sections.mesh;
        build_s = baked_->build_s;
        probe_bytes = probe_.bytes();
    }

    void run(const Pose& pose) override
    {
        result_ = query::query_probe({.model = &baked_->view}, {.probe = &probe_, .pose = {pose.rotation, pose.translation}},
                                     {.layer = layer_, .first_only = first_only_}, contacts_);
    }

    void read(FrameAnswer& out) const override
    {
        if (first_only_) {
            out.pairs = result_.contacts;
            out.pairs_hash = result_.contacts;
            return;
        }
        read_vertices(result_, out);
    }

    void read_all(const Pose& pose, FrameAnswer& out) override
    {
        if (!first_only_) return read(out);
        read_vertices(query::query_probe({.model = &baked_->view}, {.probe = &probe_, .pose = {pose.rotation, pose.translation}},
                                         {.layer = layer_}, contacts_),
                      out);
    }

private:
    void read_vertices(const query::ProbeResult& result, FrameAnswer& out) const
    {
        for (std::size_t i = 0; i < result.contacts; ++i) out.vertices.push_back({contacts_[i].index, contacts_[i].depth});
        std::sort(out.vertices.begin(), out.vertices.end(),
                  [](const VertexContact& a, const VertexContact& b) { return a.vertex < b.vertex; });
    }

    std::shared_ptr<const Baked> baked_;
    query::Layer layer_;
    bool first_only_;
    query::Probe probe_;
    std::vector<query::Contact> contacts_;
    query::ProbeResult result_;
};

}  // namespace

std::unique_ptr<Method> make_sqmap(const Setting& setting, int layer)
{
    if (layer == 0) return std::make_unique<Sqmap>(setting, query::Layer::One, true);
    constexpr std::array k_layers{query::Layer::One, query::Layer::Two, query::Layer::Three, query::Layer::Exact};
    return std::make_unique<Sqmap>(setting, k_layers[static_cast<std::size_t>(layer - 1)], false);
}

}  // namespace sqmap::bench
