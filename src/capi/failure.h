// Errors behind the C interface and their codes. No exception passes guarded().
#pragma once

#include "sqmap.h"

#include <string>
#include <utility>

namespace sqmap::capi {

/// Thrown inside the library, and by nothing else.
struct Failure {
    sqmap_code code;
    std::string element, message, cure;
    std::string name{};  ///< where it is another than the code's own
};

/// Refuses a null pointer to an element that is required.
[[noreturn]] void refuse_null(const char* element);

/// Makes the exception in flight this thread's error; its code.
sqmap_code caught() noexcept;

/// Runs work; an exception becomes a code.
template <class Work>
sqmap_code guarded(Work&& work) noexcept
{
    try {
        std::forward<Work>(work)();
        return SQMAP_OK;
    } catch (...) {
        return caught();
    }
}

/// The pointee.
template <class T>
T& needed(T* pointer, const char* element)
{
    if (pointer == nullptr) refuse_null(element);
    return *pointer;
}

}  // namespace sqmap::capi
