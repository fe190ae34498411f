// What the offline side throws. Judging a mesh never throws: see mesh/gate.h.
#pragma once

#include <stdexcept>
#include <string>
#include <utility>

namespace sqmap::mesh {

/// Why a mesh is not taken.
struct Diagnosis {
    std::string code;     ///< stable, such as E_OPEN; empty: nothing is wrong
    std::string element;  ///< where, counted from 1 in the order of the file: "face 12", "edge 7-9", "vertex 3", "mesh"
    std::string message;  ///< what was found
    std::string cure;     ///< what a user can do
};

/// Base of everything that mesh, decompose, fit and bake throw.
class Error : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

/// A mesh or an option that the algorithm cannot work on.
class InvalidInput : public Error {
public:
    using Error::Error;
};

/// A mesh that the gate refused.
class RefusedMesh : public Error {
public:
    explicit RefusedMesh(Diagnosis d) : Error(d.code + " at " + d.element + ": " + d.message), diagnosis_(std::move(d)) {}
    [[nodiscard]] const Diagnosis& diagnosis() const noexcept { return diagnosis_; }

private:
    Diagnosis diagnosis_;
};

}  // namespace sqmap::mesh
