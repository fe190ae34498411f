// Meshes inside archives. libarchive runs in a process of its own: what a broken archive does to it, it does to that process
// alone.
#pragma once

#include "batch/child.h"
#include "batch/manifest.h"

#include <filesystem>
#include <string>
#include <vector>

namespace sqmap::batch {

/// What a reading process sends: a member's bytes, why a member cannot be read, or why the archive ends early.
struct Frame {
    enum class Kind : char { Name = 'N', Bytes = 'M', Fault = 'F', Broken = 'E' };
    Kind kind = Kind::Name;
    std::string name, bytes;  ///< bytes of a Fault: an outcome; of Broken: a message
};

/// Takes frames apart as they arrive.
class Frames {
public:
    /// Reads what is there; false at the end.
    [[nodiscard]] bool read(int channel);
    /// Takes the next whole frame; false where there is none yet.
    [[nodiscard]] bool next(Frame& frame);

private:
    std::string bytes_;
    std::size_t taken_ = 0;  // of bytes_
};

/// Each entry that names an archive becomes an entry for each mesh in it, in the archive's order; one that is broken or holds no
/// mesh keeps its own, with the outcome. Nothing is unpacked.
[[nodiscard]] std::vector<Entry> expanded(std::vector<Entry> entries, const std::filesystem::path& root, const Caps& caps);

/// In a process of its own: sends the wanted members' bytes, in the archive's order. Of several of one name the first counts.
void send_members(const std::filesystem::path& archive, const std::vector<std::string>& wanted, std::uint64_t max_bytes,
                  int channel);

}  // namespace sqmap::batch
