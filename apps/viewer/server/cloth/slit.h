// Cutting a garment along a line that was drawn on it: through its triangles, not only along its seams.
#pragma once

#include "sqmap/sim/garment.h"
#include "viewer/server/protocol/messages.h"

#include <optional>
#include <span>
#include <vector>

namespace sqmap::viewer {

struct Slit {
    sim::Garment garment;             ///< with one seam more, open: its pairs were one vertex each, so that it can be sewn again
    std::vector<Vec3d> positions;     ///< where its vertices are now
    std::vector<std::uint32_t> from;  ///< of each new vertex, from the old count on: the one that it was
};

/// The cut follows a path of edges near the line, whose vertices are first moved onto it, in the pattern and in the folds alike,
/// as far as no triangle becomes too small: rest lengths are the pattern's, so nothing is stretched by it.
/// positions: of the garment's vertices now. It ends where the line comes to another panel. Nothing where the line cuts nothing
/// apart or names no triangle of the garment.
[[nodiscard]] std::optional<Slit> slit(const sim::Garment& garment, std::span<const Vec3d> positions,
                                       std::span<const ClothPoint> line, const std::string& name);

}  // namespace sqmap::viewer
