// An object that several tests of the server look at, and what they read from its bytes.
#pragma once

#include "sqmap/mesh/shapes.h"
#include "viewer/server/scene/load.h"

#include <cstring>
#include <memory>
#include <string>

namespace sqmap::viewer {

inline constexpr double k_dumbbell_size = 0.2;  ///< m

/// Two balls on a bar along z: the parts of its ends hold the landmarks at its ends.
inline const std::shared_ptr<Object>& dumbbell()
{
    static const std::shared_ptr<Object> object = [] {
        AdmittedMesh j;
        j.admission = mesh::Admission::Accept;
        j.solid = true;
        j.mesh = mesh::dumbbell({.segments = 24});
        return object_from_mesh(j, "dumbbell.obj", k_dumbbell_size, {});
    }();
    return object;
}

/// The value of type T at a place in bytes.
template <class T>
T at(const std::string& bytes, std::size_t offset)
{
    T value;
    std::memcpy(&value, bytes.data() + offset, sizeof value);
    return value;
}

}  // namespace sqmap::viewer
