// Preconditions that are checked: SQMAP_ASSERT. On in builds for debugging and sanitizers (CMake: SQMAP_ASSERTS), off in others,
// where the condition is compiled and never evaluated.
#pragma once

namespace sqmap {

/// Handles a broken precondition, given its text, file and line. The program ends when the handler returns.
using AssertHandler = void (*)(const char* condition, const char* file, int line);

/// Replaces the handler; nullptr: a line to the standard error. Returns the handler before; nullptr: that line.
/// Any thread, any time; asserts of other threads take the one or the other.
AssertHandler set_assert_handler(AssertHandler handler) noexcept;

namespace detail {
[[noreturn]] void assert_failed(const char* condition, const char* file, int line) noexcept;
}

}  // namespace sqmap

#ifdef SQMAP_ASSERTS
#define SQMAP_ASSERT(condition) \
    ((condition) ? static_cast<void>(0) : ::sqmap::detail::assert_failed(#condition, __FILE__, __LINE__))
#else
#define SQMAP_ASSERT(condition) static_cast<void>(sizeof(!(condition)))
#endif
