// A model as a FlatBuffers table, which stands alone in the file of a central model and beside the maps in that of a paper model.
#pragma once

#include "model/schema.h"
#include "sqmap/model/model_data.h"
#include "sqmap/model/notes.h"

#include <cstddef>
#include <span>
#include <vector>

namespace sqmap::io {

/// Offsets of a table's vectors, strings and tables, by field.
class TableWriter {
public:
    TableWriter(flatbuffers::FlatBufferBuilder& builder, const flatbuffers::TypeTable& fields)
        : builder_(builder), fields_(fields), offsets_(fields.num_elems, 0)
    {
    }
    /// A vector: in the visits of model/arrays.h.
    template <class T>
    void operator()(const char* name, const std::vector<T>& values)
    {
        // Numbers too are written as structs are; FlatBuffers' lower functions differ between its versions.
        offsets_.at(model::field_of(fields_, name)) = builder_.CreateVectorOfStructs(values.data(), values.size()).o;
    }
    template <class T>
    void set(const char* name, flatbuffers::Offset<T> offset)
    {
        offsets_.at(model::field_of(fields_, name)) = offset.o;
    }
    /// Adds the fields from the last to the first, the order in which FlatBuffers' generated writers add them. add(field) adds a
    /// field that is no offset.
    template <class Add>
    void add_fields(Add&& add)
    {
        for (std::size_t field = offsets_.size(); field-- > 0;) {
            if (offsets_[field] != 0)
                builder_.AddOffset(model::directory_offset(field), flatbuffers::Offset<void>(offsets_[field]));
            else
                add(model::directory_offset(field));
        }
    }

private:
    flatbuffers::FlatBufferBuilder& builder_;
    const flatbuffers::TypeTable& fields_;
    std::vector<flatbuffers::uoffset_t> offsets_;
};

/// Writes what model::read_model reads. The builder is empty: the table's parts come last in the file.
[[nodiscard]] flatbuffers::Offset<model::fb::Model> write_table(flatbuffers::FlatBufferBuilder& builder,
                                                                const model::ModelData& data,
                                                                std::span<const model::NoteRecord> notes = {});
/// The bytes of a finished buffer.
[[nodiscard]] std::vector<std::byte> bytes_of(const flatbuffers::FlatBufferBuilder& builder);

}  // namespace sqmap::io
