// A paper model as the runtime gets it: written to bytes and parsed back.
#pragma once

#include "sqmap/mesh/self_intersection.h"
#include "sqmap/mesh/solid.h"
#include "sqmap/paper/bake.h"
#include "sqmap/paper/model_file.h"
#include "support/baked_shapes.h"

#include <stdexcept>
#include <utility>

namespace sqmap::test {

class PaperModel {
public:
    explicit PaperModel(const mesh::Mesh& mesh, const bake::BakeOptions& options = {}, const paper::MapOptions& maps = {})
        : data_(paper::bake(mesh, true, options, maps).model), bytes_(paper::serialize(data_))
    {
        if (model_.parse(bytes_) != model::ParseStatus::Ok) throw std::logic_error("a baked paper model does not parse");
        in_model_space_ = model::normalized(model_.view());
    }
    PaperModel(const PaperModel&) = delete;
    PaperModel& operator=(const PaperModel&) = delete;

    [[nodiscard]] const model::ModelView& view() const { return model_.view(); }
    /// The same, queried in model space.
    [[nodiscard]] const model::ModelView& in_model_space() const { return in_model_space_; }
    [[nodiscard]] const paper::ModelData& data() const { return data_; }
    [[nodiscard]] const std::vector<std::byte>& bytes() const { return bytes_; }
    void set_options(const paper::QueryOptions& options) { model_.set_options(options); }

private:
    paper::ModelData data_;
    std::vector<std::byte> bytes_;
    paper::AnyModel model_;
    model::ModelView in_model_space_;
};

}  // namespace sqmap::test
