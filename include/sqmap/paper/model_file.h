// The files of paper models, and opening models of either kind.
#pragma once

#include "sqmap/io/model_file.h"
#include "sqmap/paper/model.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace sqmap::paper {

/// The file's bytes: those of a central model where there are no paper maps. The same data and notes give the same bytes.
/// @throw std::bad_alloc
[[nodiscard]] std::vector<std::byte> serialize(const ModelData& data, std::span<const model::NoteRecord> notes = {});

/// As model::notes_of, whichever kind the bytes are of.
[[nodiscard]] std::span<const model::NoteRecord> notes_of(std::span<const std::byte> bytes) noexcept;

/// As io::model_json, whichever kind it is. total: bytes of the model's file. @throw std::bad_alloc
[[nodiscard]] std::string model_json(const model::ModelView& view, std::size_t total,
                                     std::span<const model::NoteRecord> notes = {});

/// A model of either kind over bytes that someone else owns. Movable. Thread safety: as Reading.
class AnyModel {
public:
    /// Verifies 8-byte aligned bytes that outlive this. Failures: any status but Ok, this as it was. Allocates.
    [[nodiscard]] model::ParseStatus parse(std::span<const std::byte> bytes);

    /// Answers queries whichever kind it is. Valid as long as this, wherever it is moved. @pre parse was Ok (not checked)
    [[nodiscard]] const model::ModelView& view() const { return reading_ ? reading_->view() : central_; }
    /// The paper model; null for a central one.
    [[nodiscard]] const ModelView* paper() const { return reading_ ? &reading_->model() : nullptr; }
    /// How a paper model is read; a central one passes over it. Between queries.
    void set_options(const QueryOptions& options);

private:
    model::ModelView central_;
    std::unique_ptr<Reading> reading_;  ///< null: central
};

/// A model file of either kind, mapped and verified. Movable. Thread safety: as io::MappedModel.
class MappedModel : public AnyModel {
public:
    /// @throw io::ModelFileError where the file cannot be opened or does not verify
    explicit MappedModel(const std::filesystem::path& path) : MappedModel(io::MappedBytes(path), path) {}
    /// As io::ModelArchive::map maps a model of an archive. path: names the file in errors.
    MappedModel(io::MappedBytes file, const std::filesystem::path& path);

    /// The file's bytes. Valid as long as this.
    [[nodiscard]] std::span<const std::byte> bytes() const { return file_.bytes(); }
    /// How many bytes the file has.
    [[nodiscard]] std::size_t size() const { return file_.bytes().size(); }

private:
    io::MappedBytes file_;
};

}  // namespace sqmap::paper
