// Decimal text to a number, correctly rounded: std::from_chars, or fast_float where a standard library lacks it for doubles
// (libc++ to 19).
// Any number of threads.
#pragma once

#include <charconv>

#if defined(__cpp_lib_to_chars)
namespace sqmap {
using std::from_chars;
}
#else
#include <fast_float/fast_float.h>
namespace sqmap {
using fast_float::from_chars;
}
#endif
