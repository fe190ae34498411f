// A model with every kind of cell and list, and queries of all kinds of what parses.
#pragma once

#include "sqmap/io/model_file.h"
#include "sqmap/model/parse.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <new>
#include <span>

namespace sqmap::io {

/// Bytes at an 8-byte boundary with nothing behind them, so that a sanitizer sees every overrun.
class Bytes {
public:
    explicit Bytes(std::span<const std::byte> from)
        : size_(from.size()), data_(new (std::align_val_t{8}) std::byte[std::max<std::size_t>(size_, 1)])
    {
        std::copy(from.begin(), from.end(), data_);
    }
    ~Bytes() { ::operator delete[](data_, std::align_val_t{8}); }
    Bytes(const Bytes&) = delete;
    Bytes& operator=(const Bytes&) = delete;
    [[nodiscard]] std::span<std::byte> span() { return {data_, size_}; }

private:
    std::size_t size_;
    std::byte* data_;
};

/// A torus of a few parts: it has every kind of cell and list.
const model::ModelData& torus_model();

/// Asks a model everything, about points on, in, around and far from its object. Answers must be numbers.
void interrogate(const model::ModelView& view, std::uint64_t seed);

/// Parses a copy of the bytes; what verifies must also be safe to ask.
model::ParseStatus parse_and_query(std::span<const std::byte> bytes, std::uint64_t seed = 1);

/// Parses what a writer with a valid hash would have made of changed data.
model::ParseStatus parse_changed(const std::function<void(model::ModelData&)>& change);

}  // namespace sqmap::io
