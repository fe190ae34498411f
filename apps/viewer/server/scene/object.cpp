#include "viewer/server/scene/object.h"

#include "sqmap/fit/fit.h"
#include "sqmap/haptic/step.h"
#include "sqmap/io/model_file.h"
#include "sqmap/io/model_json.h"
#include "sqmap/model/doubt.h"
#include "sqmap/model/made_up.h"
#include "sqmap/model/parse.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <stdexcept>

namespace sqmap::viewer {
namespace {

shape::Superquadricd widened(const shape::Superquadricf& f)
{
    shape::Superquadricd out{.a = cast<double>(f.a), .eps1 = f.eps1, .eps2 = f.eps2, .translation = cast<double>(f.translation)};
    for (int i = 0; i < 3; ++i) out.rotation.row[i] = cast<double>(f.rotation.row[i]);
    out.taper_x = f.taper_x;
    out.taper_y = f.taper_y;
    out.bend = f.bend;
    out.bend_angle = f.bend_angle;
    return out;
}

struct Box {
    Vec3d lo{1e300, 1e300, 1e300}, hi{-1e300, -1e300, -1e300};
    void add(Vec3d p)
    {
        for (int k = 0; k < 3; ++k) {
            lo[k] = std::min(lo[k], p[k]);
            hi[k] = std::max(hi[k], p[k]);
        }
    }
};

/// Parts, box and scale from a view that is set.
void complete(Object& object, double metres_per_unit, double size, const Words& words)
{
    const model::ModelView& view = object.view;
    const model::Header& h = view.header;
    object.metres_per_unit = metres_per_unit > 0 ? metres_per_unit : size / (h.r_max * h.unit);
    object.metres = haptic::in_metres(view, object.metres_per_unit);
    for (std::size_t v = 0; v + 2 < view.vertices.size(); v += 3)
        object.mesh.vertices.push_back(cast<double>(model::vec3(&view.vertices[v])));
    for (std::uint32_t t = 0; t < view.triangle_part.size(); ++t) {
        object.mesh.triangles.push_back(
            {model::triangle_vertex(view, t, 0), model::triangle_vertex(view, t, 1), model::triangle_vertex(view, t, 2)});
        object.parts.partition.part_of_triangle.push_back(model::part_of_triangle(view, t));
    }
    object.parts.partition.part_count = static_cast<std::uint32_t>(view.parts.size());
    for (const model::Part& part : view.parts) {
        object.parts.superquadrics.push_back(widened(model::superquadric_of(part)));
        object.parts.largest_f.push_back(part.largest_f);
        object.parts.spheres.push_back({cast<double>(model::vec3(part.sphere)), static_cast<double>(part.sphere[3])});
    }
    object.dual = mesh::dual_graph(object.mesh);
    object.words = words;
    object.parts.names =
        part_names(object.mesh, object.dual, object.parts.partition, object.parts.superquadrics, words, object.frame());
    Box box;
    for (const Vec3d& v : object.mesh.vertices) box.add(v);
    if (object.mesh.vertices.empty())
        for (int k = 0; k < 3; ++k) {
            box.lo[k] = static_cast<double>(h.sphere[k]) - static_cast<double>(h.sphere[3]);
            box.hi[k] = static_cast<double>(h.sphere[k]) + static_cast<double>(h.sphere[3]);
        }
    const Vec3d middle = 0.5 * (box.lo + box.hi);
    object.centre = h.unit * middle + Vec3d{h.origin[0], h.origin[1], h.origin[2]};
    object.half = 0.5 * object.metres_per_unit * h.unit * (box.hi - box.lo);
}

// Notes that are about a model, not about the mesh that it was baked from.
constexpr const char* k_doubtful = "W_LAYER3: layer 3 has wrong verdicts: touch computes with the exact layer";
constexpr const char* k_off_target = "W_TARGET: the target error was not reached: the best model found is shown";
bool is_of_model(const std::string& note) { return note == k_doubtful || note == k_off_target; }

std::shared_ptr<Object> object_of(std::vector<std::byte> bytes, const std::string& name, double metres_per_unit, double size,
                                  const Words& words)
{
    auto object = std::make_shared<Object>();
    object->name = std::filesystem::path(name).stem().string();
    object->blob = std::move(bytes);
    if (const model::ParseStatus status = model::parse(object->blob, object->view); status != model::ParseStatus::Ok)
        throw std::runtime_error(name + ": not a model: " + model::to_string(status));
    complete(*object, metres_per_unit, size, words);
    if (model::is_doubtful(object->view.measured)) object->notes.emplace_back(k_doubtful);
    return object;
}

/// What the model keeps of the cure of its mesh, for another bake.
bake::Cured cured_as(const model::Cure& c, std::span<const std::uint8_t> made_up)
{
    bake::Cured out{.rung = c.rung, .made_up = made_up};
    out.deviation.input_to_result = {c.from_mean, c.from_p99, c.from_max};
    out.deviation.result_to_input = {c.to_mean, c.to_p99, c.to_max};
    out.deviation.made_up_share = c.made_up_share;
    return out;
}

nlohmann::ordered_json vector_json(Vec3d v) { return {v.x, v.y, v.z}; }

}  // namespace

sqmap::Pose Object::pose() const { return {{}, position - metres_per_unit * centre}; }

Frame Object::frame() const
{
    const model::Header& h = view.header;
    return {{h.origin[0], h.origin[1], h.origin[2]}, h.unit};
}

Vec3f Object::world(Vec3d p) const
{
    const model::Header& h = view.header;
    const Vec3d in_mesh = h.unit * p + Vec3d{h.origin[0], h.origin[1], h.origin[2]};
    return cast<float>(metres_per_unit * (in_mesh - centre) + position);
}

Vec3d Object::mesh_units(Vec3d p) const { return (1 / metres_per_unit) * (p - position) + centre; }

std::shared_ptr<Object> object_from_model(std::vector<std::byte> bytes, const std::string& name, double size, const Words& words)
{
    return object_of(std::move(bytes), name, 0, size, words);
}

std::filesystem::path names_file_of(const std::filesystem::path& model)
{
    std::filesystem::path out = model;
    out.replace_extension(".names.json");
    return out;
}

Words words_beside(const std::filesystem::path& model)
{
    std::ifstream in(names_file_of(model));
    if (!in) return {};
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    return read_names(text).value_or(Words{});
}

std::shared_ptr<Object> object_from_mesh(const app::LoadedMesh& loaded, const std::string& name, double size,
                                         const bake::BakeOptions& options)
{
    bake::BakeOptions with_cure = options;
    with_cure.cured = bake::cured(loaded.verdict, loaded.made_up, loaded.deviation);
    bake::BakeResult baked = bake::bake(loaded.mesh, loaded.solid, with_cure);
    baked.model.made_by = "sqmap view";
    baked.model.source = name;
    auto object = object_of(io::serialize(baked.model), name, 0, size, {});
    object->verdict = app::verdict_name(loaded.verdict);
    if (baked.model.measured.depth_p99 > options.target_error) object->notes.emplace_back(k_off_target);
    const std::vector<std::string> notes = app::notes_of(loaded);
    object->notes.insert(object->notes.end(), notes.begin(), notes.end());
    return object;
}

std::shared_ptr<Object> rebaked(const Object& object, const Parts& parts, const bake::BakeOptions& options, const Words& words)
{
    mesh::Mesh mesh;
    mesh.triangles = object.mesh.triangles;
    for (const Vec3d& v : object.mesh.vertices) mesh.vertices.push_back(model::to_mesh_units(object.view.header, cast<float>(v)));
    bake::BakeOptions as_given = options;
    as_given.partition = &parts.partition;
    const std::vector<std::uint8_t> made_up = made_up_triangles(object);
    as_given.cured = cured_as(object.view.cure, made_up);
    bake::BakeResult baked = bake::bake(mesh, object.view.header.solid != 0, as_given);
    baked.model.made_by = "sqmap view";
    baked.model.source = object.name;
    auto out = object_of(io::serialize(baked.model), object.name, object.metres_per_unit, 0, words);
    out->position = object.position;
    out->names_file = object.names_file;
    out->verdict = object.verdict;
    for (const std::string& note : object.notes)
        if (!is_of_model(note)) out->notes.push_back(note);
    return out;
}

std::vector<std::uint8_t> made_up_triangles(const Object& object)
{
    std::vector<std::uint8_t> out;
    if (object.view.cure.rung == model::Rung::AsItIs) return out;
    for (std::size_t t = 0; t < object.mesh.triangles.size(); ++t) out.push_back(model::is_made_up(object.view, t) ? 1 : 0);
    return out;
}

bool are_of_one_mesh(const Object& a, const Object& b)
{
    if (a.mesh.triangles.empty() || a.mesh.vertices.size() != b.mesh.vertices.size()) return false;
    const Frame at_a = a.frame(), at_b = b.frame();
    const double close = 1e-5 * a.view.header.r_max * at_a.unit;  // rounded to float once more in between
    return std::abs(at_a.unit - at_b.unit) < 1e-5 * at_a.unit && norm(at_a.origin - at_b.origin) < close &&
           a.mesh.triangles == b.mesh.triangles;
}

std::shared_ptr<Object> moved(const Object& object, double metres_per_unit, Vec3d position)
{
    auto out = object_of(object.blob, object.name, metres_per_unit, 0, object.words);
    out->name = object.name;  // which has no extension to lose
    out->position = position;
    out->names_file = object.names_file;
    out->verdict = object.verdict;
    out->notes = object.notes;
    return out;
}

void put_beside(Object& object, std::span<const ObjectPtr> others)
{
    constexpr std::size_t k_a_row = 3;
    object.position = {};
    if (others.empty()) return;
    const std::size_t row = others.size() / k_a_row;
    // On one ground, the lowest point of the first object; the second row stands behind the first.
    const double size = object.metres.header.r_max * object.metres.header.unit;
    object.position.y = others.front()->position.y - others.front()->half.y + object.half.y;
    object.position.z = -1.1 * size * static_cast<double>(row);
    double edge = others.front()->position.x - others.front()->half.x - 0.03;
    for (const ObjectPtr& other : others)
        if (std::abs(other->position.z - object.position.z) < 0.5 * size)
            edge = std::max(edge, other->position.x + other->half.x);
    object.position.x = edge + 0.03 + object.half.x;
}

Parts fitted(const Object& object, decompose::Partition partition, const Parts* keep, const Words& words)
{
    Parts out;
    std::vector<std::vector<std::uint32_t>> triangles(partition.part_count);
    for (std::uint32_t t = 0; t < partition.part_of_triangle.size(); ++t) triangles[partition.part_of_triangle[t]].push_back(t);
    std::map<std::vector<std::uint32_t>, std::uint32_t> known;
    if (keep != nullptr) {
        std::vector<std::vector<std::uint32_t>> before(keep->partition.part_count);
        for (std::uint32_t t = 0; t < keep->partition.part_of_triangle.size(); ++t)
            before[keep->partition.part_of_triangle[t]].push_back(t);
        for (std::uint32_t p = 0; p < before.size(); ++p) known.emplace(std::move(before[p]), p);
    }
    for (const auto& part : triangles) {
        if (const auto same = known.find(part); same != known.end()) {
            out.superquadrics.push_back(keep->superquadrics[same->second]);
            out.largest_f.push_back(keep->largest_f[same->second]);
            out.spheres.push_back(keep->spheres[same->second]);
            continue;
        }
        const fit::FitReport fit = fit::fit_bounding(object.mesh, part, {});
        out.superquadrics.push_back(fit.superquadric);
        out.largest_f.push_back(fit.certificate.largest_f);
        out.spheres.push_back(shape::bounding_sphere(fit.superquadric));
    }
    out.partition = std::move(partition);
    out.names = part_names(object.mesh, object.dual, out.partition, out.superquadrics, words, object.frame());
    return out;
}

Parts refitted(const Object& object, const Parts& parts, std::uint32_t part)
{
    Parts out = parts;
    std::vector<std::uint32_t> triangles;
    for (std::uint32_t t = 0; t < parts.partition.part_of_triangle.size(); ++t)
        if (parts.partition.part_of_triangle[t] == part) triangles.push_back(t);
    const fit::FitReport fit = fit::fit_bounding(object.mesh, triangles, {});
    out.superquadrics[part] = fit.superquadric;
    out.largest_f[part] = fit.certificate.largest_f;
    out.spheres[part] = shape::bounding_sphere(fit.superquadric);
    return out;
}

nlohmann::ordered_json facts_json(const Object& object, const Parts& parts, bool edited)
{
    using nlohmann::ordered_json;
    const model::ModelView& m = object.view;
    const model::Header& h = m.header;
    const io::SectionBytes bytes = io::section_bytes(m, object.blob.size());
    char hash[20];
    std::snprintf(hash, sizeof hash, "%016llx", static_cast<unsigned long long>(model::content_hash(m)));
    ordered_json out;
    out["name"] = object.name;
    out["hash"] = hash;
    out["edited"] = edited;
    out["solid"] = h.solid != 0;
    out["triangles"] = h.triangle_count;
    out["vertices"] = h.vertex_count;
    out["hasTriangles"] = !object.mesh.triangles.empty();
    out["bytes"] = {{"total", bytes.total}, {"superquadrics", bytes.superquadrics},
                    {"map", bytes.map},     {"locator", bytes.locator},
                    {"exact", bytes.exact}, {"mesh", bytes.mesh}};
    out["rMax"] = h.r_max * h.unit * object.metres_per_unit;
    out["metresPerUnit"] = object.metres_per_unit;
    out["central"] = h.projection == static_cast<std::uint32_t>(model::Projection::Central);
    out["exact"] = model::has_exact(m);
    out["position"] = vector_json(object.position);
    out["half"] = vector_json(object.half);
    const model::Measured& e = m.measured;
    out["measured"] = {{"points", e.points},        {"missed", e.missed},
                       {"false", e.false_contacts}, {"eq35Mean", e.eq35_mean},
                       {"eq35P99", e.eq35_p99},     {"depthMedian", e.depth_median},
                       {"depthP95", e.depth_p95},   {"depthP99", e.depth_p99},
                       {"depthMax", e.depth_max},   {"normalMedian", e.normal_median},
                       {"q2", e.q2_share}};
    std::vector<double> area(parts.partition.part_count);
    std::vector<std::uint32_t> count(parts.partition.part_count);
    double whole = 0;
    for (std::uint32_t t = 0; t < parts.partition.part_of_triangle.size(); ++t) {
        const double a = mesh::triangle_area(object.mesh, t);
        area[parts.partition.part_of_triangle[t]] += a;
        ++count[parts.partition.part_of_triangle[t]];
        whole += a;
    }
    const auto sphere_json = [&](Vec3d centre, double radius) {
        const Vec3f c = object.world(centre);
        return ordered_json{c.x, c.y, c.z, h.unit * object.metres_per_unit * radius};
    };
    out["sphere"] = sphere_json(cast<double>(model::vec3(h.sphere)), static_cast<double>(h.sphere[3]));
    const std::vector<std::vector<std::uint32_t>> neighbours = neighbours_of(object, parts.partition);
    out["parts"] = ordered_json::array();
    for (std::uint32_t p = 0; p < parts.partition.part_count; ++p) {
        const shape::Superquadricd& s = parts.superquadrics[p];
        out["parts"].push_back(
            {{"name", parts.names[p]},
             {"sphere", sphere_json(parts.spheres[p].centre, parts.spheres[p].radius)},
             {"neighbours", neighbours[p]},
             {"triangles", count[p]},
             {"area", whole > 0 ? 100 * area[p] / whole : 0},
             {"certified", parts.largest_f[p] <= 1},
             {"largestF", std::isfinite(parts.largest_f[p]) ? ordered_json(parts.largest_f[p]) : ordered_json()},
             {"a", vector_json(h.unit * object.metres_per_unit * s.a)},
             {"eps", {s.eps1, s.eps2}},
             {"taper", {s.taper_x, s.taper_y}},
             {"bend", s.bend}});
    }
    out["cure"] = ordered_json::parse(io::cure_json(m.cure));
    out["verdict"] = object.verdict;
    out["notes"] = object.notes;
    return out;
}

nlohmann::ordered_json superquadrics_json(const Object& object, const Parts& parts)
{
    using nlohmann::ordered_json;
    const model::Header& h = object.view.header;
    const Vec3d origin{h.origin[0], h.origin[1], h.origin[2]};
    ordered_json out;
    out["name"] = object.name;
    out["units"] = "those of the mesh; angles in radians; rotation: rows that turn the mesh's axes into the part's";
    out["parts"] = ordered_json::array();
    for (std::uint32_t p = 0; p < parts.partition.part_count; ++p) {
        const shape::Superquadricd& s = parts.superquadrics[p];
        out["parts"].push_back(
            {{"name", parts.names[p]},
             {"a", vector_json(h.unit * s.a)},
             {"eps1", s.eps1},
             {"eps2", s.eps2},
             {"rotation", {vector_json(s.rotation.row[0]), vector_json(s.rotation.row[1]), vector_json(s.rotation.row[2])}},
             {"translation", vector_json(h.unit * s.translation + origin)},
             {"taper", {s.taper_x, s.taper_y}},
             {"bend", s.bend / h.unit},
             {"bend_angle", s.bend_angle},
             {"certified", parts.largest_f[p] <= 1}});
    }
    return out;
}

}  // namespace sqmap::viewer
