#include "viewer/server/scene/edits.h"
#include "viewer/server/scene/exports.h"
#include "viewer/server/scene/fields.h"
#include "viewer/server/scene/geometry.h"
#include "viewer/server/scene/load.h"

#include "sqmap/collider/export.h"
#include "sqmap/io/model_file.h"
#include "sqmap/mesh/error.h"
#include "sqmap/mesh/shapes.h"
#include "sqmap/query/point.h"
#include "viewer/objects.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <unistd.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <set>

namespace sqmap::viewer {
namespace {

TEST(Object, IsAsLargeAsAskedAndCentred)
{
    const Object& o = *dumbbell();
    Vec3d lo{1e9, 1e9, 1e9}, hi = -1.0 * lo;
    for (const Vec3d& v : o.mesh.vertices)
        for (int k = 0; k < 3; ++k) {
            lo[k] = std::min(lo[k], static_cast<double>(o.world(v)[k]));
            hi[k] = std::max(hi[k], static_cast<double>(o.world(v)[k]));
        }
    // A dumbbell's largest extent is its length.
    EXPECT_NEAR(hi.z - lo.z, k_dumbbell_size, 1e-6);
    for (int k = 0; k < 3; ++k) {
        EXPECT_NEAR(hi[k] + lo[k], 0, 1e-6);
        EXPECT_NEAR(hi[k] - lo[k], 2 * o.half[k], 1e-6);
    }
}

TEST(Object, TouchAndPictureAgreeOnWhereTheSurfaceIs)
{
    // A point of the drawn surface, pushed in by a millimetre, is a millimetre deep for the query in metres.
    const Object& o = *dumbbell();
    int commanded = 0;
    for (std::uint32_t t = 0; t < o.mesh.triangles.size(); t += 7) {
        const auto& [i, j, k] = o.mesh.triangles[t];
        const Vec3d a = cast<double>(o.world(o.mesh.vertices[i])), b = cast<double>(o.world(o.mesh.vertices[j])),
                    c = cast<double>(o.world(o.mesh.vertices[k]));
        const Vec3d in_world = (1.0 / 3) * (a + b + c) - 1e-3 * normalized(cross(b - a, c - a));
        const Vec3d in_metres = in_world - o.pose().translation;
        const query::PointResult contact = query::query_point(o.metres, in_metres, {.layer = query::Layer::Exact});
        ASSERT_TRUE(contact.contact);
        EXPECT_NEAR(contact.depth, 1e-3, 5e-5);
        ++commanded;
    }
    EXPECT_GT(commanded, 100);
}

TEST(Object, TurnedTouchAndPictureAgreeAndTheBoxFits)
{
    for (const Up up : {Up::X, Up::Z}) {
        Object o = *dumbbell();
        o.put_at(o.metres_per_unit, {0.3, 0.1, -0.2}, up);
        Vec3d lo{1e9, 1e9, 1e9}, hi = -1.0 * lo;
        for (const Vec3d& v : o.mesh.vertices)
            for (int k = 0; k < 3; ++k) {
                lo[k] = std::min(lo[k], static_cast<double>(o.world(v)[k]));
                hi[k] = std::max(hi[k], static_cast<double>(o.world(v)[k]));
            }
        for (int k = 0; k < 3; ++k) {
            EXPECT_NEAR(0.5 * (hi[k] + lo[k]), o.position[k], 1e-6);
            EXPECT_NEAR(hi[k] - lo[k], 2 * o.half[k], 1e-6);
        }
        // The axis of the mesh that is named points upwards.
        const Vec3d axis{up == Up::X ? 1. : 0., 0, up == Up::Z ? 1. : 0.}, origin{};
        const Vec3d along = cast<double>(o.world(axis)) - cast<double>(o.world(origin));
        EXPECT_NEAR(along.y, o.metres_per_model_unit(), 1e-7);
        for (std::uint32_t t = 0; t < o.mesh.triangles.size(); t += 97) {
            const auto& [i, j, k] = o.mesh.triangles[t];
            const Vec3d a = cast<double>(o.world(o.mesh.vertices[i])), b = cast<double>(o.world(o.mesh.vertices[j])),
                        c = cast<double>(o.world(o.mesh.vertices[k]));
            const Vec3d in_world = (1.0 / 3) * (a + b + c) - 1e-3 * normalized(cross(b - a, c - a));
            const query::PointResult contact =
                query::query_point({.model = &o.metres, .pose = o.pose()}, in_world, {.layer = query::Layer::Exact});
            ASSERT_TRUE(contact.contact);
            EXPECT_NEAR(contact.depth, 1e-3, 5e-5);
            EXPECT_NEAR(norm(apply(o.pose(), o.metres_per_unit * o.mesh_units(in_world)) - in_world), 0, 1e-9);
        }
    }
}

TEST(Object, PlacesNextToWhatIsThere)
{
    const auto first = object_from_model({dumbbell()->file->begin(), dumbbell()->file->end()}, "a.sqmap", k_dumbbell_size);
    put_beside(*first, {});
    const auto second = object_from_model({dumbbell()->file->begin(), dumbbell()->file->end()}, "b.sqmap", 2 * k_dumbbell_size);
    const ObjectPtr others[] = {first};
    put_beside(*second, others);
    EXPECT_GT(second->position.x - second->half.x, first->position.x + first->half.x);
    EXPECT_NEAR(second->position.y - second->half.y, first->position.y - first->half.y, 1e-12);
}

TEST(Object, SaysEveryPartsNameOnce)
{
    const auto& names = dumbbell()->parts.names;
    EXPECT_EQ(std::set<std::string>(names.begin(), names.end()).size(), names.size());
    EXPECT_EQ(names.size(), dumbbell()->view.parts.size());
}

TEST(Object, MeshBytesHoldEveryTriangleAndItsPart)
{
    const Object& o = *dumbbell();
    const std::string bytes = mesh_bytes(o, o.parts);
    const std::size_t nv = o.mesh.vertices.size(), nt = o.mesh.triangles.size();
    ASSERT_EQ(bytes.size(), 16 + 12 * nv + 16 * nt);
    EXPECT_EQ(bytes.substr(0, 4), "SQM1");
    EXPECT_EQ(at<std::uint32_t>(bytes, 4), nv);
    EXPECT_EQ(at<std::uint32_t>(bytes, 8), nt);
    for (std::size_t t = 0; t < nt; ++t) {
        for (std::size_t k = 0; k < 3; ++k)
            EXPECT_EQ(at<std::uint32_t>(bytes, 16 + 12 * nv + 12 * t + 4 * k), o.mesh.triangles[t][k]);
        EXPECT_LT(at<std::uint32_t>(bytes, 16 + 12 * nv + 12 * nt + 4 * t), o.view.parts.size());
    }
}

TEST(Object, MapPixelsLieOnTheSurface)
{
    const Object& o = *dumbbell();
    const std::string bytes = map_bytes(o, 0, 16);
    ASSERT_EQ(bytes.size(), 12 + 16 * 64 * 48u);
    int hits = 0;
    for (std::size_t i = 0; i < 64 * 48; ++i) {
        if (!(at<float>(bytes, 12 + 16 * i) >= 0)) continue;
        Vec3d p;
        for (int k = 0; k < 3; ++k)
            p[k] = static_cast<double>(at<float>(bytes, 12 + 16 * i + 4 + 4 * static_cast<std::size_t>(k)));
        double least = 1e9;
        for (const mesh::Triangle& t : o.mesh.triangles) {
            Vec3d middle{};
            for (const std::uint32_t v : t) middle += (1.0 / 3) * cast<double>(o.world(o.mesh.vertices[v]));
            least = std::min(least, norm(middle - p));
        }
        EXPECT_LT(least, 0.012);  // of 24 segments about a ball of 36 mm
        ++hits;
    }
    EXPECT_GT(hits, 300);
}

TEST(Object, ErrorFieldIsSmallAndComplete)
{
    const Object& o = *dumbbell();
    const std::string bytes = field_bytes(o, Field::Error);
    ASSERT_EQ(bytes.size(), 8 + 4 * o.mesh.triangles.size());
    for (std::size_t t = 0; t < o.mesh.triangles.size(); ++t) {
        EXPECT_NE(at<float>(bytes, 8 + 4 * t), -1) << "missed";
        EXPECT_LT(at<float>(bytes, 8 + 4 * t), 1);
    }
}

TEST(Object, GlbIsWhatItsHeaderSays)
{
    const Object& o = *dumbbell();
    const std::string glb = glb_bytes(o, o.parts);
    EXPECT_EQ(glb.substr(0, 4), "glTF");
    EXPECT_EQ(at<std::uint32_t>(glb, 4), 2u);
    EXPECT_EQ(at<std::uint32_t>(glb, 8), glb.size());
    const auto length = at<std::uint32_t>(glb, 12);
    const auto root = nlohmann::json::parse(glb.substr(20, length));
    EXPECT_EQ(at<std::uint32_t>(glb, 20 + length), root["buffers"][0]["byteLength"].get<std::uint32_t>() +
                                                       (4 - root["buffers"][0]["byteLength"].get<std::uint32_t>() % 4) % 4);
    // Read back by the project's own reader: every triangle of the object and of its superquadrics.
    const io::ReadResult read = io::read_mesh_bytes(std::as_bytes(std::span(glb)), io::MeshFormat::Glb);
    ASSERT_FALSE(read.error) << read.error->message;
    EXPECT_EQ(read.soup.polygon_offsets.size() - 1, o.mesh.triangles.size() + o.view.parts.size() * 2 * 48 * 23);
    EXPECT_EQ(root["nodes"].size(), 2 + 2 * o.view.parts.size());
}

TEST(Object, JsonIsThatOfTheProgramsExport)
{
    const Object& o = *dumbbell();
    const auto path = std::filesystem::temp_directory_path() / (o.name + std::to_string(::getpid()) + ".json");
    const collider::Colliders made = collider::export_model(o.view, path, {.shape = {.kind = collider::Kind::Superquadric}});
    auto page = nlohmann::json::parse(json_text(o, o.parts)), program = nlohmann::json::parse(std::ifstream(path));
    std::filesystem::remove(path);
    ASSERT_EQ(page["parts"].size(), made.items.size());
    for (std::size_t p = 0; p < made.items.size(); ++p) {
        EXPECT_EQ(page["parts"][p]["name"], o.parts.names[p]);
        page["parts"][p].erase("name"), program["parts"][p].erase("name");
    }
    page.erase("name"), program.erase("name");
    EXPECT_EQ(page, program);
    // Parts that were cut on the page are exported as they are shown.
    const decompose::Split split = decompose::Cutter(o.mesh).split(o.parts.partition, 0);
    ASSERT_TRUE(split.found);
    const Parts parts = fitted(o, split.partition, &o.parts, {});
    const auto edited = nlohmann::json::parse(json_text(o, parts));
    EXPECT_EQ(edited["parts"].size(), o.view.parts.size() + 1);
    for (const auto& part : edited["parts"]) EXPECT_TRUE(part["certified"]);
    EXPECT_NE(edited["figures"]["volume"], page["figures"]["volume"]);
}

TEST(Object, EditedPartsAreBakedAsGiven)
{
    const Object& o = *dumbbell();
    const decompose::Cutter cutter(o.mesh);
    const decompose::Split split = cutter.split(o.parts.partition, 0);
    ASSERT_TRUE(split.found);
    const Parts parts = fitted(o, split.partition, &o.parts, {});
    EXPECT_EQ(parts.superquadrics.size(), parts.partition.part_count);
    const auto after = rebaked(o, parts, {}, {});
    EXPECT_EQ(after->parts.partition.part_of_triangle, split.partition.part_of_triangle);
    EXPECT_EQ(after->view.parts.size(), split.partition.part_count);
    EXPECT_EQ(after->metres_per_unit, o.metres_per_unit);
    for (const double f : after->parts.largest_f) EXPECT_LE(f, 1);
    EXPECT_LT(after->view.measured.depth_p99, 0.5);
}

TEST(Object, APartitionOfAnotherMeshIsRefused)
{
    const Object& o = *dumbbell();
    Parts parts = o.parts;
    parts.partition.part_of_triangle.pop_back();
    EXPECT_THROW((void)rebaked(o, parts, {}, {}), mesh::InvalidInput);
    parts = o.parts;
    ++parts.partition.part_count;  // an empty part
    EXPECT_THROW((void)rebaked(o, parts, {}, {}), mesh::InvalidInput);
    parts = o.parts;
    parts.partition.part_of_triangle[0] = parts.partition.part_count;
    EXPECT_THROW((void)rebaked(o, parts, {}, {}), mesh::InvalidInput);
}

TEST(Object, AMergeUndoesASplit)
{
    const Object& o = *dumbbell();
    const decompose::Cutter cutter(o.mesh);
    const decompose::Split split = cutter.split(o.parts.partition, 0);
    ASSERT_TRUE(split.found);
    ASSERT_EQ(split.partition.part_count, o.parts.partition.part_count + 1);
    const decompose::Partition merged = cutter.merge(split.partition, 0, o.parts.partition.part_count);
    EXPECT_EQ(merged.part_of_triangle, o.parts.partition.part_of_triangle);
}

TEST(LoadMesh, SaysWhyAFileIsRefused)
{
    const std::string open = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    const AdmittedMesh j = admit_mesh(MeshBytes{std::as_bytes(std::span(open)), "open.OFF"});
    EXPECT_TRUE(j.refused());
    EXPECT_FALSE(j.diagnosis.code == mesh::Refusal::None);
    EXPECT_FALSE(j.diagnosis.message.empty());
    EXPECT_FALSE(j.diagnosis.cure.text().empty());
    EXPECT_EQ(admit_mesh(MeshBytes{std::as_bytes(std::span(open)), "open.exe"}).diagnosis.code, mesh::Refusal::Format);
    const std::string huge = "OFF\n100000000 100000000 0\n0 0 0\n";
    EXPECT_EQ(admit_mesh(MeshBytes{std::as_bytes(std::span(huge)), "huge.off"}).diagnosis.code, mesh::Refusal::Truncated);
    EXPECT_THROW((void)object_from_model({std::byte{1}, std::byte{2}}, "x.sqmap", k_dumbbell_size), std::runtime_error);
}

}  // namespace
}  // namespace sqmap::viewer
