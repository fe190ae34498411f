// Cells of a locator for the triangles of a paper model: without planes, without seeds.
#pragma once

#include "sqmap/model/model_data.h"

namespace sqmap::paper {

/// Gives a paper model the bricks, the cells and the candidate lists of another model of the same parts and triangles; of a cell
/// only which kind it is, as its planes and seeds are of central charts.
void take_cells(model::ModelData& from, model::ModelData& to);

}  // namespace sqmap::paper
