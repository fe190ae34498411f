// The skinned hand that contacts are measured on: posed, as one closed mesh, and as rigid solids. Joints named as the WebXR
// hand's.
#pragma once

#include "sqmap/io/read_skin.h"
#include "sqmap/mesh/skin.h"
#include "sqmap/query/probe.h"
#include "sqmap/query/skin.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

namespace sqmap::bench {

/// A file's skin; where it does not read, none, and why on standard error.
[[nodiscard]] std::optional<io::SkinnedSoup> read_skin(const char* file);

/// World of each joint times its inverse bind. curl: 0 open, 1 a fist; pointing: the index finger stays straight.
[[nodiscard]] std::vector<Affine> maps_of(const io::SkinnedSoup& skin, double curl, bool pointing);

/// The skin as one closed mesh: vertices along texture seams are doubled in the file.
struct Bound {
    mesh::Mesh mesh;
    mesh::Influences influences;
};
[[nodiscard]] Bound welded(const io::SkinnedSoup& skin);

/// A skin baked for queries: the model of its bound mesh, and the lattice that carries points back to that mesh.
struct BakedSkin {
    /// cell: of the lattice, a share of R_max. @throw std::runtime_error where the bound model does not parse
    BakedSkin(const io::SkinnedSoup& skin, double cell);

    Bound bound;
    double r_max;
    std::vector<std::byte> bytes;
    model::ModelView model;
    query::SkinLattice lattice;
    std::optional<query::PosedSkin> posed;
    double bake_seconds = 0, lattice_seconds = 0;  ///< CPU time
};

/// Rigid solids of the joints, united.
class Solids {
public:
    Solids(const Bound& bound, std::size_t joints, double least_weight);
    /// depth: of each point, -1 where free.
    void query_depths(const std::vector<Affine>& maps, const std::vector<Vec3d>& points, query::Layer layer,
                      std::vector<double>& depth) const;
    [[nodiscard]] std::size_t size() const { return models_.size(); }

private:
    struct Model {
        std::uint16_t joint;
        std::vector<std::byte> bytes;
        model::ModelView view;
    };
    std::vector<Model> models_;
};

}  // namespace sqmap::bench
