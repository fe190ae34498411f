// How the steps of the gate end with a refusal.
#pragma once

#include "sqmap/mesh/error.h"

#include <cstdint>
#include <string>
#include <utility>

namespace sqmap::mesh {

/// Thrown within the gate and caught there.
struct Refused {
    Diagnosis diagnosis;
};

[[noreturn]] inline void refuse(Refusal code, std::string element, std::string message, std::string cure)
{
    throw Refused{{code, std::move(element), std::move(message), std::move(cure)}};
}

inline std::string number(std::uint64_t n) { return std::to_string(n); }
/// "face 12", counted from 1.
inline std::string element(const char* kind, std::uint64_t zero_based) { return kind + (" " + number(zero_based + 1)); }

}  // namespace sqmap::mesh
