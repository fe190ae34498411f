// Errors behind the C interface and their codes (no exception passes guarded()), and structs that cross it: a caller's may be
// shorter or longer than the library's, as its header was.
#pragma once

#include "sqmap.h"
#include "sqmap/math/pose.h"
#include "sqmap/mesh/words.h"
#include "sqmap/paper/model.h"
#include "sqmap/query/options.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace sqmap::capi {

/// Thrown inside the library, and by nothing else.
struct Failure {
    sqmap_code code;
    std::string element, message;
    mesh::Words cure;
    std::string name{};                  ///< where it is another than the code's own
    std::int32_t words = SQMAP_WORDS_C;  ///< sqmap_words of sqmap_error::cure
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

inline constexpr std::size_t k_max_struct = 4096;  ///< bytes: more is no struct of this header, but memory that was not set

/// Refuses sizes that no header gives, and members beyond this library's that are not zero.
void check_struct(const void* given, std::size_t known, const char* element);

/// A caller's struct, zero for the members that it does not have; all zero for a null pointer.
template <class T>
T taken(const T* given, const char* element)
{
    T own{};
    if (given != nullptr) {
        check_struct(given, sizeof(T), element);
        std::memcpy(&own, given, std::min(given->size, sizeof(T)));
    }
    own.size = sizeof(T);
    return own;
}

/// Writes a result to a caller's struct, as far as its size goes. @pre taken() has checked it
template <class T>
void give(T* target, T value)
{
    const std::size_t size = target->size;
    value.size = size;
    std::memcpy(static_cast<void*>(target), &value, std::min(size, sizeof(T)));
}

/// The value. @throw Failure for a number that is not finite, or not within [min, max]
double checked(double value, double min, double max, const char* element);

/// A caller's pose for a call that answers whatever it is given: all NaN where pose_of() would refuse it.
Pose pose_or_nan(const sqmap_pose& pose) noexcept;
/// Null stands for the identity. A rotation whose rows are off by 1e-6 to 1e-4 is made orthonormal, a better one keeps its bits.
/// element: names the pose. @throw Failure for a number that is not finite, and for a matrix that is no rotation
Pose pose_of(const sqmap_pose* pose, const char* element);
/// A caller's poses. One with a number that is not finite is all NaN. element: names the array. @throw Failure for null where
/// there are some, and for a matrix that is no rotation
std::vector<Pose> poses_of(const sqmap_pose* poses, std::size_t count, const std::string& element);

/// @throw Failure for a number that names no layer, and for numbers out of range
query::QueryOptions query_options(const sqmap_query_options& options);
/// Reads the options of paper models that queries and sessions have in common. @throw Failure for numbers out of range
template <class Options>
paper::QueryOptions paper_options(const Options& o)
{
    if (o.projector < SQMAP_PROJECTOR_NEWTON || o.projector > SQMAP_PROJECTOR_PRINTED)
        throw Failure{SQMAP_E_ARGUMENT, "options.projector", "is " + std::to_string(o.projector), "take one of sqmap_projector"};
    paper::QueryOptions out;
    out.projector = static_cast<paper::Projector>(o.projector);
    if (o.nearest_steps != 0) out.nearest_steps = std::max(0, o.nearest_steps);
    for (const NumberOption<paper::QueryOptions>& number : paper::k_query_numbers)
        if (!number.fits(out))
            throw Failure{SQMAP_E_ARGUMENT, std::string("options.") + number.name,
                          "is " + std::to_string(std::llround(number.value(out))),
                          "give at most " + std::to_string(std::llround(number.range.max))};
    out.gaps = o.without_gaps == 0;
    out.pruning = o.without_pruning == 0;
    return out;
}
/// Threads of a batch. element: names the number. @throw Failure
unsigned threads_of(std::uint32_t threads, const char* element = "options.threads");
/// @throw Failure
query::Layer layer_of(int layer);

/// Rows of three doubles as they lie in the caller's memory.
std::span<const Vec3d> rows(const sqmap_points& points, const char* element);

/// Refuses a row that is not finite: element names the rows, and "element[3]" the fourth.
void check_finite(std::span<const Vec3d> rows, const char* element, const char* cure = "leave it out");

/// Text to the caller's. element: names the argument.
void give_text(sqmap_text* target, std::string_view text, const char* element);

}  // namespace sqmap::capi
