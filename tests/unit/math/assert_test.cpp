#ifndef SQMAP_ASSERTS
#define SQMAP_ASSERTS 1  // in this file, whatever the libraries were built with
#endif
#include "sqmap/math/assert.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>

namespace sqmap {
namespace {

TEST(Assert, PassesWhatHolds)
{
    int evaluated = 0;
    SQMAP_ASSERT(++evaluated == 1);
    EXPECT_EQ(evaluated, 1);
}

TEST(AssertDeathTest, EndsTheProgramWhereAConditionIsBroken) { EXPECT_DEATH(SQMAP_ASSERT(1 + 1 == 3), ""); }

TEST(AssertDeathTest, TellsTheHandlerWhatIsBrokenAndWhere)
{
    const auto broken = [] {
        set_assert_handler([](const char* condition, const char* file, int line) {
            std::fprintf(stderr, "[%s] [%s] %d", condition, file, line);
            std::_Exit(7);
        });
        SQMAP_ASSERT(1 + 1 == 3);
    };
    EXPECT_EXIT(broken(), testing::ExitedWithCode(7), "\\[1 \\+ 1 == 3\\] \\[.*assert_test.cpp\\] [0-9]+");
}

TEST(AssertDeathTest, EndsTheProgramThoughTheHandlerReturns)
{
    const auto broken = [] {
        set_assert_handler([](const char*, const char*, int) {});
        SQMAP_ASSERT(false);
    };
    EXPECT_DEATH(broken(), "");
}

TEST(Assert, GivesTheHandlerThatItReplaces)
{
    const AssertHandler handler = [](const char*, const char*, int) {};
    EXPECT_EQ(set_assert_handler(handler), nullptr);
    EXPECT_EQ(set_assert_handler(nullptr), handler);
}

}  // namespace
}  // namespace sqmap
