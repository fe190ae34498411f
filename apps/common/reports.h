// How figures are printed, the same for bake, info and eval.
#pragma once

#include "sqmap/bake/evaluate.h"
#include "sqmap/model/model_data.h"

#include <nlohmann/json.hpp>

namespace sqmap::app {

[[nodiscard]] nlohmann::ordered_json evaluation_json(const bake::Evaluation& evaluation);
/// The line that comes first of a model that may not be relied on below the exact layer; nothing of another.
void print_doubt(const model::ModelView& model);
void print_measured(const model::Measured& measured);
/// ", CLOSED" or ", WRAPPED", for a first line; empty otherwise.
[[nodiscard]] const char* rung_suffix(const model::Cure& cure);
void print_cure(const model::Cure& cure);

}  // namespace sqmap::app
