// What a swept query sets up outside the frame: the allocating half.
#include "sqmap/query/swept.h"

namespace sqmap::query {

SweptRoom::SweptRoom(std::size_t points) : at_(points), fast_(points), contact_(points), found_(points) {}

}  // namespace sqmap::query
