// A glTF file as JSON and buffers: what its readers share.
#pragma once

#include "parse.h"
#include "sqmap/io/read_skin.h"

#include <nlohmann/json.hpp>

#include <array>
#include <cstring>
#include <string>
#include <vector>

namespace sqmap::io {

using nlohmann::json;

/// "mesh 3": an element as errors call it.
std::string name_of(const char* array, std::uint64_t index);

/// Element index of one of the file's top-level arrays.
const json& item(const json& root, const char* array, std::uint64_t index);

/// A whole number that is not negative; fallback where the key is missing.
std::uint64_t whole(const json& object, const char* key, const std::string& where, std::optional<std::uint64_t> fallback = {});

/// The array of that key; null where the key is missing.
const json* array_or_null(const json& object, const char* key, const std::string& where);

/// A node's own pose: translation, rotation and scale, each the neutral one where it is missing.
JointPose pose_of(const json& node, const std::string& where);

/// Map of a pose, and of a node by its matrix or its pose: to the frame of the node above.
Affine affine_of(const JointPose& pose);
Affine affine_of(const json& node, const std::string& where);

/// Numbers of an accessor, bounds checked once.
struct Accessor {
    std::span<const std::byte> bytes;
    std::size_t count = 0, stride = 0;
    std::uint64_t component = 0;
    bool is_normalized = false;
    std::string type;

    [[nodiscard]] double real(std::size_t element, std::size_t k) const
    {
        switch (component) {
            case 5120:
                return scaled(raw<std::int8_t>(element, k), 127);
            case 5121:
                return scaled(raw<std::uint8_t>(element, k), 255);
            case 5122:
                return scaled(raw<std::int16_t>(element, k), 32767);
            case 5123:
                return scaled(raw<std::uint16_t>(element, k), 65535);
            case 5125:
                return raw<std::uint32_t>(element, k);
            default:
                return raw<float>(element, k);
        }
    }
    [[nodiscard]] std::int64_t index(std::size_t element) const
    {
        switch (component) {
            case 5121:
                return raw<std::uint8_t>(element, 0);
            case 5123:
                return raw<std::uint16_t>(element, 0);
            default:
                return raw<std::uint32_t>(element, 0);
        }
    }

private:
    template <class T>
    [[nodiscard]] T raw(std::size_t element, std::size_t k) const
    {
        T value;
        std::memcpy(&value, bytes.data() + element * stride + k * sizeof(T), sizeof(T));
        return value;
    }
    [[nodiscard]] double scaled(int value, int largest) const
    {
        return is_normalized ? std::max(double(value) / largest, -1.0) : value;
    }
};

/// The file's JSON and its buffers, which are read when first wanted.
class GltfFile {
public:
    /// @throw ReadFailure where the bytes are no glTF file of version 2
    GltfFile(std::span<const std::byte> bytes, std::filesystem::path folder, const ReadLimits& limits);

    [[nodiscard]] const json& root() const { return root_; }
    [[nodiscard]] const ReadLimits& limits() const { return limits_; }

    /// @throw ReadFailure where it is not of a kind that is read, or reaches beyond its buffer
    Accessor accessor(std::uint64_t index);

    /// Nodes and channels may unfold to much more than the file: takes that many bytes from a budget that its size sets.
    /// @throw ReadFailure where the budget is spent
    void spend(std::uint64_t bytes, const std::string& where, const char* what, const char* cure);

private:
    std::span<const std::byte> buffer(std::uint64_t index);

    struct Buffer {
        std::vector<std::byte> owned;
        std::span<const std::byte> bytes;
    };

    json root_;
    std::span<const std::byte> binary_;
    std::filesystem::path folder_;
    ReadLimits limits_;
    std::vector<std::optional<Buffer>> buffers_;
    std::uint64_t budget_ = 0;
};

/// Collects the triangles of a file's meshes.
class GltfTriangles {
public:
    explicit GltfTriangles(GltfFile& file) : file_(file) {}

    /// Adds the triangles of all primitives of a mesh.
    void add_mesh(std::uint64_t index, const Affine& map);

    PolygonSoup soup;

private:
    void add_primitive(const json& primitive, std::uint64_t mode, const Affine& map, const std::string& where);

    GltfFile& file_;
};

}  // namespace sqmap::io
