// A baked model as the runtime gets it: written to bytes and parsed back, with the exact solid it is about.
#pragma once

#include "sqmap/io/model_file.h"
#include "sqmap/mesh/self_intersection.h"
#include "sqmap/mesh/solid.h"
#include "sqmap/model/parse.h"
#include "support/baked_shapes.h"

#include <stdexcept>

namespace sqmap::test {

class Parsed {
public:
    explicit Parsed(const mesh::Mesh& mesh, bool solid = true, const bake::BakeOptions& options = {})
        : mesh_(bake::model_space(mesh)),
          solid_(mesh_, mesh::find_self_intersections(mesh_).crossed),
          bytes_(io::serialize(bake::bake(mesh, solid, options).model))
    {
        if (model::parse(bytes_, view_) != model::ParseStatus::Ok) throw std::logic_error("a baked model does not parse");
    }
    Parsed(const Parsed&) = delete;
    Parsed& operator=(const Parsed&) = delete;

    [[nodiscard]] const model::ModelView& view() const { return view_; }
    [[nodiscard]] const mesh::Solid& solid() const { return solid_; }  ///< model space
    [[nodiscard]] const mesh::Mesh& mesh() const { return mesh_; }     ///< model space
    [[nodiscard]] double r_max() const { return view_.header.r_max; }
    [[nodiscard]] Vec3d to_model(Vec3d p) const
    {
        const double* o = view_.header.origin;
        return (p - Vec3d{o[0], o[1], o[2]}) / view_.header.unit;
    }

private:
    mesh::Mesh mesh_;
    mesh::Solid solid_;
    std::vector<std::byte> bytes_;
    model::ModelView view_;
};

}  // namespace sqmap::test
