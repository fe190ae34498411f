// Exceptions of the offline side. Judging a mesh never throws: see mesh/admit.h.
#pragma once

#include "sqmap/mesh/words.h"

#include <cstdint>
#include <stdexcept>
#include <string>
#include <utility>

namespace sqmap::mesh {

/// Why a mesh is not taken.
enum class Refusal : std::uint8_t {
    None,         ///< nothing is wrong
    Index,        ///< a corner names a vertex that is not there
    NonFinite,    ///< a coordinate is not a finite number
    Empty,        ///< no faces
    Range,        ///< too large, too small, or both, for double precision
    Limit,        ///< more than the limits allow
    NonManifold,  ///< edges with more than two faces that no split of vertices resolves
    Orient,       ///< faces that cannot be oriented alike
    Flat,         ///< a sheet
    Open,         ///< encloses no volume
    Repair,       ///< needs repairs that are forbidden
    Format,       ///< no mesh file of a format that is read
    Truncated,    ///< the file ends too early
    Internal,     ///< a defect of sqmap
    File,         ///< there is no file that can be read
};

/// As printed, stable: "E_OPEN"; empty for None. Never null.
[[nodiscard]] const char* name_of(Refusal refusal) noexcept;

/// Why and where a mesh is not taken, and what helps.
struct Diagnosis {
    Refusal code = Refusal::None;
    std::string element;  ///< where, counted from 1 in the order of the file: "face 12", "edge 7-9", "vertex 3", "mesh"
    std::string message;  ///< the finding
    Words cure;           ///< the user's remedy
};

/// Base of everything that mesh, decompose, fit and bake throw. Thread safety: a value.
class Error : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

/// A mesh or an option that the algorithm cannot work on. Thread safety: a value.
class InvalidInput : public Error {
public:
    using Error::Error;
};

/// A mesh that was refused. Thread safety: a value.
class RefusedMesh : public Error {
public:
    /// what() is "E_OPEN at edge 7-9: ..."
    explicit RefusedMesh(Diagnosis d)
        : Error(std::string(name_of(d.code)) + " at " + d.element + ": " + d.message), diagnosis_(std::move(d))
    {
    }
    [[nodiscard]] const Diagnosis& diagnosis() const noexcept { return diagnosis_; }  ///< valid as long as this

private:
    Diagnosis diagnosis_;
};

}  // namespace sqmap::mesh
