#include "sqmap/math/assert.h"

#include <atomic>
#include <cstdlib>
#ifdef SQMAP_ASSERTS
#include <cstdio>
#endif

namespace sqmap {
namespace {

std::atomic<AssertHandler> handler_in_use{nullptr};

}  // namespace

AssertHandler set_assert_handler(AssertHandler handler) noexcept { return handler_in_use.exchange(handler); }

void detail::assert_failed(const char* condition, const char* file, int line) noexcept
{
    if (const AssertHandler handler = handler_in_use.load()) {
        handler(condition, file, line);
    } else {
#ifdef SQMAP_ASSERTS  // elsewhere the runtime writes nothing: see docs/realtime.md
        std::fprintf(stderr, "%s:%d: precondition broken: %s\n", file, line, condition);
#endif
    }
    std::abort();
}

}  // namespace sqmap
