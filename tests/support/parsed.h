// A baked model as the runtime gets it: written to bytes and parsed back, with the exact solid it is about. Tests run each in a
// process of its own and many want the same models, so what is baked with the default options is kept in the build folder
// until one of the libraries is linked anew.
#pragma once

#include "bake/bake.h"
#include "io/replace_file.h"
#include "sqmap/io/model_file.h"
#include "sqmap/math/pose.h"
#include "sqmap/mesh/self_intersection.h"
#include "sqmap/mesh/solid.h"
#include "sqmap/model/parse.h"
#include "support/baked_shapes.h"

#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>
#include <optional>
#include <stdexcept>

namespace sqmap::test {

/// FNV-1a of a mesh's arrays, continued from `hash`.
template <class T>
std::uint64_t hash_of(const std::vector<T>& values, std::uint64_t hash)
{
    std::vector<unsigned char> bytes(values.size() * sizeof(T));
    if (!bytes.empty()) std::memcpy(bytes.data(), values.data(), bytes.size());
    for (const unsigned char byte : bytes) hash = (hash ^ byte) * 0x100000001b3u;
    return hash;
}

/// The bytes of a model baked with the default options: read where some test has baked it before, else baked and kept.
inline std::vector<std::byte> baked_bytes(const mesh::Mesh& mesh, bool solid)
{
    char name[32];
    const std::uint64_t hash =
        hash_of(mesh.triangles, hash_of(mesh.vertices, 0xcbf29ce484222325u ^ static_cast<std::uint64_t>(solid)));
    std::snprintf(name, sizeof name, "%016llx.sqmap", static_cast<unsigned long long>(hash));
    const std::filesystem::path file = std::filesystem::path(SQMAP_BAKED_DIR) / name;
    if (std::ifstream in(file, std::ios::binary); in) {
        const std::vector<char> text{std::istreambuf_iterator<char>(in), {}};
        std::vector<std::byte> bytes(text.size());
        if (!bytes.empty()) std::memcpy(bytes.data(), text.data(), bytes.size());
        return bytes;
    }
    std::vector<std::byte> bytes = io::serialize(bake::bake(mesh, solid, {}).model);
    std::filesystem::create_directories(file.parent_path());
    io::replace_file(file, bytes);
    return bytes;
}

class Parsed {
public:
    /// With the default options: see baked_bytes.
    explicit Parsed(const mesh::Mesh& mesh, bool solid = true) : Parsed(mesh, baked_bytes(mesh, solid)) {}
    Parsed(const mesh::Mesh& mesh, bool solid, const bake::BakeOptions& options)
        : Parsed(mesh, io::serialize(bake::bake(mesh, solid, options).model))
    {
    }
    Parsed(const Parsed&) = delete;
    Parsed& operator=(const Parsed&) = delete;

    [[nodiscard]] const model::ModelView& view() const { return view_; }
    /// The same, queried in model space.
    [[nodiscard]] const model::ModelView& in_model_space() const { return in_model_space_; }
    /// Model space. Made when first wanted: not for several threads at once.
    [[nodiscard]] const mesh::Solid& solid() const
    {
        if (!solid_) solid_.emplace(mesh_, mesh::find_self_intersections(mesh_).crossed);
        return *solid_;
    }
    [[nodiscard]] const mesh::Mesh& mesh() const { return mesh_; }  ///< model space
    [[nodiscard]] double r_max() const { return view_.header.r_max; }
    [[nodiscard]] Vec3d to_model(Vec3d p) const
    {
        const double* o = view_.header.origin;
        return (p - Vec3d{o[0], o[1], o[2]}) / view_.header.unit;
    }
    /// Takes a probe's points to model space, where in_model_space() is queried.
    [[nodiscard]] sqmap::Pose to_model(const sqmap::Pose& pose) const
    {
        sqmap::Pose out{pose.rotation, to_model(pose.translation)};
        for (Vec3d& row : out.rotation.row) row = row / view_.header.unit;
        return out;
    }

private:
    Parsed(const mesh::Mesh& mesh, std::vector<std::byte> bytes) : mesh_(bake::model_space(mesh)), bytes_(std::move(bytes))
    {
        if (model::parse(bytes_, view_) != model::ParseStatus::Ok) throw std::logic_error("a baked model does not parse");
        in_model_space_ = model::normalized(view_);
    }

    mesh::Mesh mesh_;
    mutable std::optional<mesh::Solid> solid_;
    std::vector<std::byte> bytes_;
    model::ModelView view_, in_model_space_;
};

}  // namespace sqmap::test
