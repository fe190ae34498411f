// The objects behind the handles of the C interface. An object lives as long as anything made of it.
#pragma once

#include "handles.h"
#include "sqmap/io/model_file.h"
#include "sqmap/mesh/bvh.h"
#include "sqmap/query/pair.h"
#include "sqmap/query/probe.h"

#include <cstddef>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace sqmap::capi {

/// The model's triangles in mesh units with a tree over them.
struct Surface {
    explicit Surface(const model::ModelView& view);
    mesh::Mesh mesh;
    mesh::Bvh bvh;
};

/// Each library has its own: @throw Failure for a model whose kernels it leaves out.
void refuse_unanswered(const model::ModelView& view);

/// A model, mapped from a file or owned.
class Model {
public:
    /// @throw Failure
    explicit Model(const char* path);
    explicit Model(io::MappedModel file);
    /// @throw Failure
    Model(std::vector<std::byte> bytes, std::string notes);

    [[nodiscard]] const model::ModelView& view() const { return view_; }
    [[nodiscard]] std::span<const std::byte> bytes() const { return file_ ? file_->bytes() : std::span(bytes_); }
    [[nodiscard]] const std::string& notes() const { return notes_; }
    /// Built by the first call. @throw Failure without the exact layer
    [[nodiscard]] const Surface& surface() const;

private:
    std::optional<io::MappedModel> file_;
    std::vector<std::byte> bytes_;
    std::string notes_;
    model::ModelView view_;
    mutable std::once_flag once_;
    mutable std::unique_ptr<Surface> surface_;
};

class Session;

/// One table for each kind of handle; made by the first call and never destroyed, so that threads may outlive main().
Handles<Model, 1>& models();
Handles<query::Probe, 2>& probes();
Handles<query::PairWorkspace, 3>& workspaces();
Handles<Session, 4>& sessions();

/// The open model. @throw Failure
inline const std::shared_ptr<Model>& model_of(sqmap_model handle) { return models().find(handle.id); }

}  // namespace sqmap::capi
