// The .sqmap file: writing a baked model, mapping it back, reporting its content.
#pragma once

#include "sqmap/model/model_data.h"
#include "sqmap/model/notes.h"
#include "sqmap/model/parse.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace sqmap::io {

/// A model file that cannot be read or written; what() says why and what to do. Thread safety: a value.
class ModelFileError : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

/// The file's bytes. The same data and notes give the same bytes.
[[nodiscard]] std::vector<std::byte> serialize(const model::ModelData& data, std::span<const model::NoteRecord> notes = {});

/// Bytes of a serialized model by section, for reports.
struct SectionBytes {
    std::size_t total = 0, superquadrics = 0;
    std::size_t polytopes = 0;  ///< with the figures of all bounds
    std::size_t map = 0;        ///< central maps
    std::size_t locator = 0;
    std::size_t exact = 0, mesh = 0, input = 0;
    std::size_t distance = 0;  ///< signed distance on both sides
};
/// Sections of a parsed model whose file has `total` bytes.
[[nodiscard]] SectionBytes section_bytes(const model::ModelView& view, std::size_t total);

/// Format, hashes, parts with superquadric and certificate, bytes by section, cure, notes, measured error, as JSON text; two
/// spaces a level. As `sqmap info --json` prints it. total: bytes of the model's file. @throw std::bad_alloc
[[nodiscard]] std::string model_json(const model::ModelView& view, std::size_t total,
                                     std::span<const model::NoteRecord> notes = {});
/// The figures that bake measured, one object. @throw std::bad_alloc
[[nodiscard]] std::string measured_json(const model::Measured& measured);
/// How tightly the bounds of a part hold it, one object in mesh units; part == #parts: their union and the whole. "null" of a
/// model without polytopes. @throw std::bad_alloc
[[nodiscard]] std::string bounds_json(const model::ModelView& view, std::size_t part);
/// How the mesh was made a solid, one object; "null" if it was taken unchanged. @throw std::bad_alloc
[[nodiscard]] std::string cure_json(const model::Cure& cure);

/// Writes through a temporary file beside path and a rename: path is never partly written.
/// @throw ModelFileError where the folder cannot be written or the disk is full.
void write_model(const model::ModelData& data, const std::filesystem::path& path);

/// A file's bytes mapped into memory, or those of a part of it that begins at a multiple of eight bytes, as members of an archive
/// do. Movable. Thread safety: any number of threads may read them; moving and destroying by the owner alone.
class MappedBytes {
public:
    /// size 0: to the end of the file. @throw ModelFileError where there are no such bytes
    explicit MappedBytes(const std::filesystem::path& path, std::uint64_t offset = 0, std::uint64_t size = 0);
    ~MappedBytes();
    MappedBytes(MappedBytes&& other) noexcept;
    MappedBytes& operator=(MappedBytes&&) = delete;

    /// Valid as long as this, wherever it is moved.
    [[nodiscard]] std::span<const std::byte> bytes() const { return {static_cast<const std::byte*>(mapping_) + skip_, size_}; }

private:
    const void* mapping_ = nullptr;  ///< whole pages
    std::size_t skip_ = 0;           ///< bytes before the part in its first page
    std::size_t size_ = 0;
};

/// @throw ModelFileError that names path and the cure, unless the status is Ok
void check(model::ParseStatus status, const std::filesystem::path& path);

/// A model file mapped into memory, verified. Movable; the view lives as long as the object.
/// Thread safety: any number of threads may read it; moving and destroying it by its owner alone.
class MappedModel {
public:
    /// @throw ModelFileError where the file cannot be opened or does not verify; for a paper model, which sqmap::paper opens
    explicit MappedModel(const std::filesystem::path& path);

    [[nodiscard]] const model::ModelView& view() const { return view_; }     ///< valid as long as this
    [[nodiscard]] std::size_t size() const { return file_.bytes().size(); }  ///< of the model, bytes
    /// The model's own, without what stands before it in the file.
    [[nodiscard]] std::span<const std::byte> bytes() const { return file_.bytes(); }

private:
    MappedBytes file_;
    model::ModelView view_;
};

}  // namespace sqmap::io
