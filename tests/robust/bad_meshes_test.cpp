// The expected verdict of every damaged mesh of the shared folder, written down from the policy table before the gate
// was. What each file holds is described in the folder's README; a file this table does not know fails the test.
#include "sqmap/bake_mesh.h"
#include "support/shared_folder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

namespace sqmap::app {
namespace {

namespace fs = std::filesystem;

struct Expectation {
    const char* file;
    const char* verdict;     // under --repair safe
    const char* code;        // of a refusal, else ""
    const char* repair;      // one repair that must be in the list, else ""
    const char* warning;     // one warning that must be in the list, else ""
    const char* cured = "";  // the verdict by default where it differs
};

constexpr Expectation k_expectations[] = {
    // Three coincident points: the box is a point. E_RANGE comes before any repair.
    {"all_same_point.obj", "REFUSED", "E_RANGE", "", ""},
    // One face without area in a box that has a size: nothing is left after the repair, and nothing has no volume.
    {"collinear.obj", "REFUSED", "E_FLAT", "", ""},
    {"empty.obj", "REFUSED", "E_FORMAT", "", ""},
    {"flat_sheet.obj", "REFUSED", "E_FLAT", "", ""},
    {"hand_cut_open.obj", "REFUSED", "E_OPEN", "", "", "CLOSED"},
    {"hand_degenerate.obj", "REPAIRED", "", "degenerate_faces", ""},
    {"hand_duplicate_faces.obj", "REPAIRED", "", "duplicate_faces", ""},
    {"hand_far_copies.obj", "ACCEPT", "", "", ""},
    {"hand_holes50.obj", "REFUSED", "E_OPEN", "", "", "CLOSED"},
    // 1.5e6 units wide at 1e8, written with 7 digits.
    {"hand_huge_coords.obj", "ACCEPT", "", "", "W_UNIT"},
    {"hand_index_out_of_range.obj", "REFUSED", "E_INDEX", "", ""},
    {"hand_inverted.obj", "REPAIRED", "", "flipped", "W_FLIPPED"},
    {"hand_isolated_vertices.obj", "REPAIRED", "", "unused_vertices", ""},
    {"hand_nan_vertex.obj", "REFUSED", "E_NONFINITE", "", ""},
    {"hand_negative_indices.obj", "ACCEPT", "", "", ""},
    // A fin is a third face on an edge: no way of splitting vertices closes it.
    {"hand_nonmanifold_fins.obj", "REFUSED", "E_NONMANIFOLD", "", "", "CLOSED"},
    {"hand_one_missing.obj", "REFUSED", "E_OPEN", "", "", "CLOSED"},
    {"hand_overlapping_copies.obj", "ACCEPT", "", "", "W_SELFX"},
    {"hand_random_flips.obj", "REPAIRED", "", "reoriented", ""},
    {"hand_slashes_crlf.obj", "ACCEPT", "", "", ""},
    {"hand_soup_unwelded.obj", "REPAIRED", "", "welded_vertices", ""},
    {"hand_tiny_coords.obj", "ACCEPT", "", "", ""},
    {"only_vertices.obj", "REFUSED", "E_EMPTY", "", ""},
    {"real_bones_26components.obj", "ACCEPT", "", "", ""},
    // Every face twice, back to back: one of each pair stays, and single sheets that meet three at an edge remain.
    {"real_chair_doublesided_nonmanifold.obj", "REFUSED", "E_NONMANIFOLD", "", "", "WRAPPED"},
    // One vertex where two fans touch; both fans are parts of closed shells.
    {"real_cow_selfintersecting.obj", "REPAIRED", "", "split_vertices", "W_SELFX"},
    {"real_dragon_nonmanifold.obj", "REFUSED", "E_NONMANIFOLD", "", "", "CLOSED"},
    {"real_elephant_with_holes.obj", "REFUSED", "E_OPEN", "", "", "CLOSED"},
    {"real_horse_quads.obj", "REPAIRED", "", "triangulated", ""},
    {"real_linked_knots_2components.obj", "ACCEPT", "", "", ""},
    {"real_lion_head_open.obj", "REFUSED", "E_OPEN", "", "", "CLOSED"},
    {"real_self_intersecting.obj", "ACCEPT", "", "", "W_SELFX"},
    {"real_teapot_open_duplicates.obj", "REFUSED", "E_OPEN", "", "", "CLOSED"},
    // Order of the codes: flat comes before open.
    {"single_triangle.obj", "REFUSED", "E_FLAT", "", ""},
    {"tetrahedron.obj", "ACCEPT", "", "", ""},
    // Ends within a face line.
    {"truncated.obj", "REFUSED", "E_TRUNCATED", "", ""},
};

const fs::path k_meshes = test::shared_folder() / "meshes";

std::vector<std::string> obj_files(const fs::path& folder)
{
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder))
        if (entry.path().extension() == ".obj") names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
}

bool has_repair(const AdmittedMesh& loaded, const std::string& kind)
{
    return std::any_of(loaded.repairs.begin(), loaded.repairs.end(),
                       [&](const auto& r) { return mesh::name_of(r.kind) == kind; });
}

bool has_warning(const AdmittedMesh& loaded, const std::string& code)
{
    return std::any_of(loaded.warnings.begin(), loaded.warnings.end(),
                       [&](const auto& w) { return mesh::name_of(w.kind) == code; });
}

TEST(BadMeshes, EveryFileGetsItsVerdict)
{
    if (!fs::exists(k_meshes / "bad")) GTEST_SKIP() << "no " << k_meshes << " (SQMAP_SHARED_DIR=FOLDER)";
    for (const std::string& name : obj_files(k_meshes / "bad")) {
        const auto* expected = std::find_if(std::begin(k_expectations), std::end(k_expectations),
                                            [&](const Expectation& e) { return name == e.file; });
        if (expected == std::end(k_expectations)) {
            ADD_FAILURE() << name << " has no expected verdict";
            continue;
        }
        const AdmittedMesh loaded = admit_mesh(k_meshes / "bad" / name, {.admit = {.repair = mesh::Repair::Safe}});
        EXPECT_STREQ(mesh::name_of(loaded.admission), expected->verdict) << name << ": " << loaded.diagnosis.message;
        EXPECT_STREQ(mesh::name_of(loaded.diagnosis.code), expected->code) << name << ": " << loaded.diagnosis.message;
        EXPECT_TRUE(*expected->repair == '\0' || has_repair(loaded, expected->repair)) << name;
        EXPECT_TRUE(*expected->warning == '\0' || has_warning(loaded, expected->warning)) << name;
        if (*expected->code != '\0') {
            EXPECT_FALSE(loaded.diagnosis.element.empty()) << name;
            EXPECT_FALSE(loaded.diagnosis.cure.text().empty()) << name;
            EXPECT_TRUE(loaded.mesh.triangles.empty()) << name;
        }
        const AdmittedMesh cured = admit_mesh(k_meshes / "bad" / name, {});
        EXPECT_STREQ(mesh::name_of(cured.admission), *expected->cured ? expected->cured : expected->verdict)
            << name << " by default: " << cured.diagnosis.message;
        EXPECT_EQ(cured.deviation.has_value(), *expected->cured != '\0') << name;
    }
}

TEST(BadMeshes, EveryGoodMeshIsAcceptedAsItIs)
{
    if (!fs::exists(k_meshes)) GTEST_SKIP() << "no " << k_meshes << " (SQMAP_SHARED_DIR=FOLDER)";
    for (const std::string& name : obj_files(k_meshes)) {
        const AdmittedMesh loaded = admit_mesh(k_meshes / name, {});
        EXPECT_STREQ(mesh::name_of(loaded.admission), "ACCEPT") << name << ": " << loaded.diagnosis.message;
        EXPECT_TRUE(loaded.solid) << name;
        EXPECT_EQ(loaded.facts.self_intersecting_pairs, 0u) << name;
        EXPECT_EQ(loaded.facts.component_count, 1u) << name;
    }
}

}  // namespace
}  // namespace sqmap::app
