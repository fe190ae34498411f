// A brick's candidate lists before they are packed.
#pragma once

#include "model/candidate_lists.h"
#include "sqmap/model/model.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace sqmap::bake {

/// See model::CandidateRecord.
class BrickRecord {
public:
    /// A record without lists. wide: triangles take two values each.
    explicit BrickRecord(bool wide = false) : wide_(wide) {}
    /// As it was in a model, whose arrays outlive it.
    BrickRecord(const model::ModelView& model, std::size_t brick);

    /// Numbers of a brick's triangles in the order in which they were added.
    class Numbers {
    public:
        /// Forgets the brick before; the memory is kept. triangles: of the mesh.
        void begin(std::size_t triangles)
        {
            for (const std::uint32_t t : numbered_) of_[t] = k_none;
            numbered_.clear();
            of_.resize(triangles, k_none);
        }

    private:
        friend class BrickRecord;
        static constexpr std::uint32_t k_none = 0xffffffffu;
        std::vector<std::uint32_t> of_, numbered_;  ///< #triangles of the mesh; those that have one
    };

    /// The list of a cell of the brick; cells in ascending order. Where a brick's lists are too long, the rest of its cells tries
    /// all of the brick's triangles.
    void add(std::uint32_t cell, std::span<const std::uint32_t> triangles, Numbers& numbers);

    /// Some cell has a list.
    [[nodiscard]] bool is_occupied() const { return occupied_ != 0; }
    [[nodiscard]] std::size_t triangle_count() const { return triangles_.size(); }
    [[nodiscard]] double bytes() const;

    /// Each cell tries all of the brick's triangles.
    void drop_lists();
    /// Each cell tries all triangles of the mesh.
    void drop_triangles();

    /// Appends the record as stored.
    void pack(std::vector<std::uint16_t>& out) const;

private:
    [[nodiscard]] model::UnpackedCandidates contents() const { return {occupied_, starts_, triangles_, refs_}; }

    bool wide_;
    std::uint64_t occupied_ = 0;
    std::vector<std::uint32_t> starts_{0}, triangles_, refs_;
    std::size_t list_values_ = 0;              ///< at most so many
    std::span<const std::uint16_t> packed_{};  ///< instead of the vectors
};

/// If the records take more bytes than that, the longest lose their lists; if that does not suffice, their triangles.
void keep_within(double bytes, std::vector<BrickRecord>& records);

}  // namespace sqmap::bake
