// Baked models in a tar file, as `sqmap batch` writes it: found by key, mapped in place.
//
// The first member, "index", has a line of k_line bytes for each model, sorted by key:
//     KEY OFFSET SIZE SHA256 PICTURE_OFFSET PICTURE_SIZE
// Numbers are decimal, padded with zeros to 15 digits; offsets count from the start of the tar file. The second member,
// "rows.jsonl", has a line for each item of the library. Models and pictures follow: KEY.sqmap, KEY.png.
#pragma once

#include "sqmap/io/model_file.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace sqmap::io {

/// A file that cannot be read, is no archive, or is damaged.
class ModelArchiveError : public ModelFileError {
public:
    /// what() is "PATH: WHY: CURE".
    ModelArchiveError(const std::filesystem::path& path, std::string why, std::string cure);
    [[nodiscard]] const std::string& why() const { return why_; }    ///< without the path
    [[nodiscard]] const std::string& cure() const { return cure_; }  ///< what helps

private:
    std::string why_, cure_;
};

/// Position of a model in its archive. The texts are valid as long as the archive.
struct ArchivedModel {
    std::string_view key;     ///< 64 hexadecimal digits: of the mesh's bytes, the options and the version
    std::string_view sha256;  ///< of the model's bytes, 64 hexadecimal digits
    std::uint64_t offset = 0, size = 0;
    std::uint64_t picture_offset = 0, picture_size = 0;  ///< a PNG file; size 0: none
};

/// An archive whose index is mapped: only the parts of the file that are looked up are read.
/// Thread safety: any number of threads may read one.
class ModelArchive {
public:
    /// Digits of a number and of a key in the index.
    static constexpr std::size_t k_digits = 15, k_key = 64;
    static constexpr std::size_t k_line = 2 * (k_key + 1) + 4 * (k_digits + 1);  ///< of the index, bytes

    /// @throw ModelArchiveError
    explicit ModelArchive(const std::filesystem::path& path);
    ~ModelArchive();
    ModelArchive(ModelArchive&& other) noexcept;
    ModelArchive& operator=(ModelArchive&&) = delete;

    [[nodiscard]] const std::filesystem::path& path() const { return path_; }  ///< as it was given
    [[nodiscard]] std::size_t size() const { return index_.size() / k_line; }  ///< models in it

    /// The model at that index in the order of keys. @pre i < size() @throw ModelArchiveError for a line that is damaged
    [[nodiscard]] ArchivedModel entry(std::size_t i) const;

    /// Binary search. @throw ModelArchiveError for a line that is damaged
    [[nodiscard]] std::optional<ArchivedModel> find(std::string_view key) const;

    /// Maps the model of that key, of either kind: paper::MappedModel verifies it. @throw ModelFileError if there is none,
    /// ModelArchiveError where the file is shorter
    [[nodiscard]] MappedBytes map(std::string_view key) const;

    /// The lines about items, JSON, as they stand in the file.
    [[nodiscard]] std::string_view rows() const { return rows_; }
    /// Bytes of the file itself, the index among them; for pictures and checks. @throw ModelArchiveError where the file is
    /// shorter
    [[nodiscard]] std::string_view bytes(std::uint64_t offset, std::uint64_t size) const;

private:
    [[nodiscard]] std::string_view member(std::size_t at, std::string_view name) const;
    [[noreturn]] void refuse() const;
    [[noreturn]] void fail(const char* why) const;

    std::filesystem::path path_;
    const char* data_ = nullptr;
    std::size_t size_ = 0;  // of the file
    std::string_view index_, rows_;
};

}  // namespace sqmap::io
