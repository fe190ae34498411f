// The locator, read for one point.
#pragma once

#include "model/locator_cells.h"
#include "sqmap/model/model.h"

#include <cstddef>
#include <cstdint>

namespace sqmap::query {

/// The cell under a point.
struct LocatedCell {
    bool is_free = true;       ///< outside the grid, or in a free brick or cell
    std::size_t brick = 0;     ///< its index
    std::uint32_t within = 0;  ///< of the undivided cell in its brick, 0 of a deep one
    std::size_t index = 0;     ///< of the word, where one is stored
    model::LocatorCell cell{};
    Vec3f offset{};  ///< of the point from the cell's centre, in cells
};

/// LocatorLanes with one lane. Cost: two look-ups, or three. @pre the model has a locator
[[nodiscard]] LocatedCell locate(const model::ModelView& model, Vec3f point) noexcept;

/// True where the surface nearest to a point in its cell may be made up. Cost: as locate. @pre model.made_up_cells is not empty
[[nodiscard]] bool is_made_up_at(const model::ModelView& model, Vec3f point) noexcept;

}  // namespace sqmap::query
