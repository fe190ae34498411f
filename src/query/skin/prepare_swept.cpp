// Constructors of swept queries' workspaces, which allocate: they run outside the frame.
#include "sqmap/query/swept.h"

namespace sqmap::query {

SweptWorkspace::SweptWorkspace(std::size_t points)
    : probe_(std::span<const Vec3d>{}), at_(points), fast_(points), contact_(points), found_(points)
{
}

SweptWorkspace::SweptWorkspace(const Probe& probe)
    : probe_(probe), at_(probe.size()), fast_(probe.size()), contact_(probe.size()), found_(probe.size())
{
}

}  // namespace sqmap::query
