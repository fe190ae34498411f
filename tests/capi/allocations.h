// Counts what is allocated by operator new, here and in the libraries that import it.
#pragma once

#include <cstddef>

namespace sqmap::test {

/// Since the start, of all threads.
std::size_t allocations();

}  // namespace sqmap::test
