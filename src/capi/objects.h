// The objects behind the handles of the C interface. An object lives as long as anything made of it.
#pragma once

#include "sqmap/io/model_file.h"
#include "sqmap/mesh/bvh.h"
#include "sqmap/paper/model.h"
#include "sqmap/query/contacts.h"
#include "sqmap/query/overlap.h"
#include "sqmap/query/probe.h"
#include "sqmap/query/separating.h"
#include "structs.h"

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace sqmap::capi {

/// Refuses a handle that is not open, and says whether it is missing, of another kind or closed. @throw Failure
[[noreturn]] void refuse_handle(std::uint64_t id, std::uint8_t kind, const char* element);

/// Objects by handle. find() takes no lock; open() and close() do.
/// Layout of a handle: generation, 40 bits; kind, 8; slot + 1, 16.
template <class T, std::uint8_t Kind>
class Handles {
public:
    /// @throw Failure where as many are open as there are slots
    std::uint64_t open(std::shared_ptr<T> object)
    {
        const std::lock_guard lock(mutex_);
        if (free_.empty() && used_ == k_slots)
            throw Failure{SQMAP_E_MEMORY, "handle", std::to_string(k_slots) + " are open", "close those that are done with"};
        if (free_.empty()) free_.push_back(used_++);
        const std::uint32_t index = free_.back();
        free_.pop_back();
        Slot& slot = slots_[index];
        slot.object = std::move(object);
        const std::uint64_t id = (++generation_ << 24) | (std::uint64_t{Kind} << 16) | (index + 1);
        slot.id.store(id, std::memory_order_release);
        return id;
    }
    /// element: the argument that holds the handle. @throw Failure where it is not open
    const std::shared_ptr<T>& find(std::uint64_t id, const char* element) const
    {
        const std::uint64_t index = (id & 0xffff) - 1;
        if (index >= k_slots || slots_[index].id.load(std::memory_order_acquire) != id) refuse_handle(id, Kind, element);
        return slots_[index].object;
    }
    /// Passes over 0. @throw Failure where it is not open
    void close(std::uint64_t id, const char* element)
    {
        if (id == 0) return;
        std::shared_ptr<T> last;  // dies behind the lock
        const std::lock_guard lock(mutex_);
        find(id, element);
        const auto index = static_cast<std::uint32_t>((id & 0xffff) - 1);
        slots_[index].id.store(0, std::memory_order_release);
        last = std::move(slots_[index].object);
        free_.push_back(index);
    }

private:
    static constexpr std::uint32_t k_slots = 0xfffe;
    struct Slot {
        std::atomic<std::uint64_t> id{0};
        std::shared_ptr<T> object;
    };
    std::unique_ptr<Slot[]> slots_ = std::make_unique<Slot[]>(k_slots);
    std::mutex mutex_;
    std::vector<std::uint32_t> free_;
    std::uint32_t used_ = 0;
    std::uint64_t generation_ = 0;
};

/// The model's triangles in mesh units with a tree over them.
struct Surface {
    explicit Surface(const model::ModelView& view);
    mesh::Mesh mesh;
    mesh::Bvh bvh;
    std::span<const std::uint32_t> source;  ///< numbers of its triangles in the input; may be empty
};

/// A model over bytes that stay where they are. opened.cpp says which kinds of models each library opens.
struct Opened {
    model::ModelView view;
    bool is_paper = false;
    std::shared_ptr<const void> kept{};  ///< what view points to beside the bytes
};
/// element: names the bytes. @throw Failure for bytes that are no model, or one whose kernels the library leaves out
[[nodiscard]] Opened open_model(std::span<const std::byte> bytes, const std::string& element);
/// The model read so; whatever it was opened from outlives it. @throw Failure for options that change none of its answers
[[nodiscard]] Opened read_paper(const Opened& opened, const paper::QueryOptions& how, const query::QueryOptions& query);
/// Says why bytes are no model. @throw Failure
[[noreturn]] void refuse_bytes(model::ParseStatus status, const std::string& element);
/// As io::model_json, of the kinds that the library opens. bytes: the model's.
[[nodiscard]] std::string json_of(const model::ModelView& view, std::span<const std::byte> bytes);
/// The notes in a model's bytes, of the kinds that the library opens.
[[nodiscard]] std::span<const model::NoteRecord> notes_in(std::span<const std::byte> bytes);

/// A model, mapped from a file or owned.
class Model {
public:
    /// @throw Failure
    explicit Model(const char* path);
    /// element: names the file. @throw Failure
    Model(io::MappedBytes file, const std::string& element);
    /// @throw Failure
    explicit Model(std::vector<std::byte> bytes, std::int32_t words = SQMAP_WORDS_C);

    [[nodiscard]] const model::ModelView& view() const { return opened_.view; }
    [[nodiscard]] bool is_paper() const { return opened_.is_paper; }
    [[nodiscard]] const Opened& opened() const { return opened_; }
    [[nodiscard]] std::span<const std::byte> bytes() const { return file_ ? file_->bytes() : std::span(bytes_); }
    /// The words of the bake that made it: sqmap_words.
    [[nodiscard]] std::int32_t words() const { return words_; }
    /// Built by the first call. @throw Failure without the exact layer
    [[nodiscard]] const Surface& surface() const;

private:
    std::optional<io::MappedBytes> file_;
    std::vector<std::byte> bytes_;
    std::int32_t words_ = SQMAP_WORDS_C;
    Opened opened_;
    mutable std::once_flag once_;
    mutable std::unique_ptr<Surface> surface_;
};

/// Memory in which pairs are computed. The space of complete contacts, overlaps and separations is made when it is
/// needed first.
class Workspace {
public:
    explicit Workspace(std::size_t contacts) : size_(contacts), pair_(contacts) {}

    [[nodiscard]] query::PairWorkspace& pair() { return pair_; }
    [[nodiscard]] query::ContactWorkspace& contacts()
    {
        if (!contacts_) contacts_.emplace(size_);
        return *contacts_;
    }
    /// For probes as large as these.
    [[nodiscard]] query::OverlapWorkspace& overlap(const query::Probe& a, const query::Probe& b)
    {
        if (!overlap_ || !overlap_->holds(a, b)) overlap_.emplace(a, b);
        return *overlap_;
    }
    /// For probes as large as these.
    [[nodiscard]] query::SeparatingWorkspace& separating(const query::Probe& a, const query::Probe& b)
    {
        if (!separating_ || !separating_->holds(a, b)) separating_.emplace(a, b);
        return *separating_;
    }

private:
    std::size_t size_;
    query::PairWorkspace pair_;
    std::optional<query::ContactWorkspace> contacts_;
    std::optional<query::OverlapWorkspace> overlap_;
    std::optional<query::SeparatingWorkspace> separating_;
};

/// The library's own contacts cross the interface.
static_assert(sizeof(sqmap_surface_contact) == sizeof(query::SurfaceContact));

/// One table for each kind of handle; made by the first call and never destroyed, so that threads may outlive main().
template <class T, std::uint8_t Kind>
Handles<T, Kind>& table()
{
    static auto& table = *new Handles<T, Kind>;
    return table;
}
inline Handles<Model, 1>& models() { return table<Model, 1>(); }
inline Handles<query::Probe, 2>& probes() { return table<query::Probe, 2>(); }
/// @throw Failure for a probe of points alone
void check_triangles(const query::Probe& probe, const char* element);
inline Handles<Workspace, 3>& workspaces() { return table<Workspace, 3>(); }

/// Opens what make() returns, so that the caller's handle stands for it; the handle is zero after an error.
template <class Handle, class T, std::uint8_t Kind, class Make>
sqmap_code opened(Handle* handle, const char* name, Handles<T, Kind>& table, Make&& make)
{
    return guarded([&] {
        Handle& out = needed(handle, name);
        out = {};
        out.id = table.open(make());
    });
}

/// The open model. @throw Failure
inline const std::shared_ptr<Model>& model_of(sqmap_model handle, const char* element = "model")
{
    return models().find(handle.id, element);
}

}  // namespace sqmap::capi
