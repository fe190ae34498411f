// Meshes inside archives. libarchive runs in a process of its own: an archive that makes it crash or hang ends that process
// alone.
#pragma once

#include "batch/child.h"
#include "batch/manifest.h"

#include <filesystem>
#include <string>
#include <vector>

namespace sqmap::batch {

/// A message of a reading process: a member's name or bytes, why it cannot read a member, or why the archive ends early.
struct Frame {
    enum class Kind : char { Name = 'N', Bytes = 'M', Fault = 'F', Broken = 'E' };
    Kind kind = Kind::Name;
    std::string name, bytes;  ///< bytes of a Fault: an outcome; of Broken: a message
};

/// Collects bytes of a channel and cuts them into frames.
class Frames {
public:
    /// Reads the bytes that have arrived, waiting for the first; false at the end.
    [[nodiscard]] bool read(int channel);
    /// Moves the next frame that has arrived whole into frame; false where none has.
    [[nodiscard]] bool next(Frame& frame);

private:
    std::string bytes_;
    std::size_t taken_ = 0;  // of bytes_
};

/// Replaces each entry that names an archive by an entry for each mesh in the archive, in the archive's order. An archive that is
/// broken or holds no mesh keeps an entry with that outcome. The function unpacks nothing.
[[nodiscard]] std::vector<Entry> expanded(std::vector<Entry> entries, const std::filesystem::path& root, const Caps& caps);

/// Sends the wanted members' bytes, in the archive's order; among members of one name the first. Runs in a process of its own.
void send_members(const std::filesystem::path& archive, const std::vector<std::string>& wanted, std::uint64_t max_bytes,
                  int channel);

}  // namespace sqmap::batch
