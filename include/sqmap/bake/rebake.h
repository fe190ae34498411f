// A baked model whose mesh has moved in some regions: only what that reaches is baked anew.
#pragma once

#include "sqmap/bake/bake_types.h"

#include <span>
#include <vector>

namespace sqmap::bake {

/// How rebake() works.
struct RebakeOptions {
    double target_error = 0.5;  ///< as it was baked: percent of R_max
    double fineness = 1;        ///< BakeReport::fineness of that bake
    unsigned threads = 0;       ///< 0: one a core; the result does not depend on it
    fit::FitOptions fit{};
};

/// The parts that were made anew.
struct RebakeReport {
    std::size_t changed_triangles = 0;
    std::vector<std::uint32_t> remade;                    ///< parts whose map is new: those whose chart reaches changed triangles
    std::vector<std::uint32_t> refitted;                  ///< of these, parts whose superquadric did not hold them any more
    std::vector<fit::Certificate> certificates;           ///< of all parts
    std::vector<std::pair<std::string, double>> seconds;  ///< CPU time a stage
};

/// The model after its vertices moved, and what of it is new.
struct RebakeResult {
    model::ModelData model;
    RebakeReport report;
};

/// before: a closed solid baked with central maps, the exact layer and a locator, by bake or by this. vertices: all of them, in
/// mesh units and in the order of before.vertices (bake's input); triangles and their parts stay. What comes out answers as bake
/// would for the same parts and superquadrics: parts whose superquadric, with its certificate, still holds their patch and caps
/// keep it, others are fitted again; model space and the locator's grid stay; the model's figures are not measured
/// (measured.points is 0).
/// @pre the moved mesh is one that mesh::admit would accept: no triangle without area, not turned inside out (not checked)
/// @throw mesh::InvalidInput where before is not of that kind, or a vertex is not finite; mesh::RefusedMesh as bake. Thread-safe
/// Cost: grows with the parts that are reached and the surface that has moved; see docs/algorithms/articulated.md.
[[nodiscard]] RebakeResult rebake(const model::ModelData& before, std::span<const Vec3d> vertices,
                                  const RebakeOptions& options = {});

/// The mesh that a model was baked from, model space; empty where the model was baked without its triangles. Linear.
[[nodiscard]] mesh::Mesh baked_mesh(const model::ModelView& view);

}  // namespace sqmap::bake
