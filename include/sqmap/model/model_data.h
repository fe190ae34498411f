// A model as owned arrays: what bake makes and io writes. The runtime never uses it.
#pragma once

#include "sqmap/model/model.h"

#include <string>
#include <vector>

namespace sqmap::model {

/// An array of a model that is being made.
template <class T>
using ArrayData = std::vector<T>;

/// As ModelView. Several threads may read one at a time; changing it needs it alone.
struct ModelData : CentralArrays<ArrayData>,
                   MeshArrays<ArrayData>,
                   LocatorArrays<ArrayData>,
                   CandidateArrays<ArrayData>,
                   BoundArrays<ArrayData> {
    Header header{};
    ArrayData<Part> parts;
    DistanceArrays<ArrayData> distance;
    InputArrays<ArrayData> input;
    Measured measured;
    Cure cure;
    ArrayData<std::uint32_t> made_up_cells;
    std::string made_by, source, options;
    std::uint64_t mesh_hash = 0;

    /// Valid until the data changes.
    [[nodiscard]] ModelView view() const
    {
        ModelView view;
        const auto look = [](const char*, auto& span, const auto& array) { span = array; };
        each_surface_array(look, view, *this);
        each_cell_array(look, view, *this);
        BoundArrays<ArrayView>::each(look, view, *this);
        DistanceArrays<ArrayView>::each(look, view.distance, distance);
        view.distance.header = distance.header;
        InputArrays<ArrayView>::each(look, view.input, input);
        view.header = header;
        view.locator = locator;
        view.measured = measured;
        view.cure = cure;
        view.made_up_cells = made_up_cells;
        view.made_by = made_by;
        view.source = source;
        view.options = options;
        view.mesh_hash = mesh_hash;
        return view;
    }
};

}  // namespace sqmap::model
