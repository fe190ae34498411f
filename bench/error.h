// The bench's error for its user.
#pragma once

#include <stdexcept>

namespace sqmap::bench {

/// Bad input or a path that cannot be written: what() says where, what was found and what to do.
class BenchError : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

}  // namespace sqmap::bench
