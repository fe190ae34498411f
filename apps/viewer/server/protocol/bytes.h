// Bytes for the page: little-endian 32-bit values behind four letters.
#pragma once

#include "sqmap/math/vec.h"

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

namespace sqmap::viewer {

static_assert(std::endian::native == std::endian::little, "bytes are copied as they are");

class Bytes {
public:
    explicit Bytes(const char* magic) : out_(magic, 4) {}
    template <class T>
    void put(T value)
    {
        static_assert(sizeof(T) == 4);
        const auto at = out_.size();
        out_.resize(at + 4);
        std::memcpy(out_.data() + at, &value, 4);
    }
    void count(std::size_t n) { put(static_cast<std::uint32_t>(n)); }
    void point(Vec3f p)
    {
        put(p.x);
        put(p.y);
        put(p.z);
    }
    /// Three indices of each triangle.
    void corners(const std::vector<std::array<std::uint32_t, 3>>& triangles)
    {
        for (const auto& triangle : triangles)
            for (const std::uint32_t vertex : triangle) put(vertex);
    }
    [[nodiscard]] std::string take() { return std::move(out_); }

private:
    std::string out_;
};

}  // namespace sqmap::viewer
