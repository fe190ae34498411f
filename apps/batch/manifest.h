// The list of meshes that a library is baked from.
#pragma once

#include "batch/row.h"

#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace sqmap::batch {

/// A manifest that cannot be used at all; what() names the file and the cure.
class ManifestError : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

/// A line of a manifest: an item, or the outcome that says why the line names none.
struct Entry {
    Item item;
    std::optional<Outcome> outcome;
};

struct ManifestOptions {
    std::filesystem::path root;  ///< of relative paths; empty: the manifest's folder
    std::filesystem::path skip;  ///< a folder that is passed over where the manifest is a folder: the library itself
};

/// Reads a manifest, in its order. A folder: every mesh and archive below it, sorted; what cannot be entered is an entry with its
/// outcome. A mesh or an archive: itself. ".csv": the column "path" and, if there is
/// one, "member" of a table with a heading; without one, the first column. ".jsonl", ".ndjson": objects with "path" and "member".
/// ".txt": a path a line. Paths may hold any bytes. A line that names no path is an entry with its outcome.
/// @throw ManifestError where the manifest cannot be read, or names nothing
[[nodiscard]] std::vector<Entry> read_manifest(const std::filesystem::path& manifest, const ManifestOptions& options);

/// Gives the second and later entries of one path the outcome "duplicate".
void mark_duplicates(std::vector<Entry>& entries);

/// A digest of all entries in their order: "13 items, SHA-256 ...". Shards that were made from the same entries belong together.
[[nodiscard]] std::string fingerprint_of(const std::vector<Entry>& entries);

/// Tells by the ending of a name whether bake can read the mesh.
[[nodiscard]] bool has_mesh_name(std::string_view name);
/// Tells by the ending of a name whether it is an archive: tar, also compressed, or zip.
[[nodiscard]] bool has_archive_name(std::string_view name);

/// The file of an item. root: as in ManifestOptions, made absolute.
[[nodiscard]] std::filesystem::path file_of(const Item& item, const std::filesystem::path& root);
/// The folder that relative paths of a manifest count from.
[[nodiscard]] std::filesystem::path root_of(const std::filesystem::path& manifest, const std::filesystem::path& root);

}  // namespace sqmap::batch
