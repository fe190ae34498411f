#include "viewer/server/scene/object.h"

#include "sqmap/fit/fit.h"
#include "sqmap/haptic/step.h"
#include "sqmap/io/model_file.h"
#include "sqmap/mesh/gate.h"
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

Judgement judge_read(const io::ReadResult& read, const mesh::GateOptions& options)
{
    Judgement out;
    out.verdict = "REFUSED";
    if (read.error) {
        out.code = read.error->code;
        out.element = read.error->element;
        out.message = read.error->message;
        out.cure = read.error->cure;
        return out;
    }
    const io::PolygonSoup& soup = read.soup;
    mesh::GateResult gate = mesh::admit({soup.positions, soup.polygon_offsets, soup.indices}, options);
    for (const mesh::RepairNote& r : gate.repairs)
        out.notes.push_back(std::string("repaired: ") + mesh::name_of(r.kind) + " (" + std::to_string(r.count) + ")");
    for (const mesh::Warning& w : gate.warnings) out.notes.push_back(std::string(mesh::name_of(w.kind)) + ": " + w.message);
    if (gate.verdict == mesh::Verdict::Refused) {
        out.code = mesh::name_of(gate.diagnosis.code);
        out.element = gate.diagnosis.element;
        out.message = gate.diagnosis.message;
        out.cure = gate.diagnosis.cure;
        return out;
    }
    out.accepted = true;
    out.verdict = gate.verdict == mesh::Verdict::Accept ? "ACCEPT" : "REPAIRED";
    out.mesh = std::move(gate.mesh);
    out.solid = gate.solid;
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

std::shared_ptr<Object> object_of(std::vector<std::byte> bytes, const std::string& name, double metres_per_unit, double size,
                                  const Words& words)
{
    auto object = std::make_shared<Object>();
    object->name = std::filesystem::path(name).stem().string();
    object->blob = std::move(bytes);
    if (const model::ParseStatus status = model::parse(object->blob, object->view); status != model::ParseStatus::Ok)
        throw std::runtime_error(name + ": not a model: " + model::to_string(status));
    complete(*object, metres_per_unit, size, words);
    return object;
}

nlohmann::ordered_json vector_json(Vec3d v) { return {v.x, v.y, v.z}; }

}  // namespace

sqmap::Pose Object::pose() const { return {{}, place - metres_per_unit * centre}; }

Frame Object::frame() const
{
    const model::Header& h = view.header;
    return {{h.origin[0], h.origin[1], h.origin[2]}, h.unit};
}

Vec3f Object::world(Vec3d p) const
{
    const model::Header& h = view.header;
    const Vec3d in_mesh = h.unit * p + Vec3d{h.origin[0], h.origin[1], h.origin[2]};
    return cast<float>(metres_per_unit * (in_mesh - centre) + place);
}

Judgement judge(std::span<const std::byte> bytes, const std::string& name, const io::ReadLimits& limits,
                const mesh::GateOptions& gate)
{
    const std::map<std::string, io::MeshFormat> formats{{".off", io::MeshFormat::Off},   {".obj", io::MeshFormat::Obj},
                                                        {".stl", io::MeshFormat::Stl},   {".ply", io::MeshFormat::Ply},
                                                        {".gltf", io::MeshFormat::Gltf}, {".glb", io::MeshFormat::Glb}};
    std::string extension = std::filesystem::path(name).extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    const auto format = formats.find(extension);
    if (format == formats.end()) {
        Judgement out;
        out.verdict = "REFUSED";
        out.code = "E_FORMAT";
        out.element = "name";
        out.message = "the name does not end in .off, .obj, .stl, .ply, .gltf or .glb";
        out.cure = "save the mesh in one of these formats";
        return out;
    }
    return judge_read(io::read_mesh_bytes(bytes, format->second, limits), gate);
}

Judgement judge(const std::filesystem::path& path) { return judge_read(io::read_mesh_file(path), {}); }

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

std::shared_ptr<Object> object_from_mesh(const Judgement& judgement, const std::string& name, double size,
                                         const bake::BakeOptions& options)
{
    bake::BakeResult baked = bake::bake(judgement.mesh, judgement.solid, options);
    baked.model.made_by = "sqmap view";
    baked.model.source = name;
    auto object = object_of(io::serialize(baked.model), name, 0, size, {});
    object->verdict = judgement.verdict;
    object->notes = judgement.notes;
    if (!baked.report.target_met) object->notes.push_back("the target error was not reached: the best model found is shown");
    return object;
}

std::shared_ptr<Object> rebaked(const Object& object, const Parts& parts, const bake::BakeOptions& options, const Words& words)
{
    mesh::Mesh mesh;
    mesh.triangles = object.mesh.triangles;
    for (const Vec3d& v : object.mesh.vertices) mesh.vertices.push_back(model::to_mesh_units(object.view.header, cast<float>(v)));
    bake::BakeOptions as_given = options;
    as_given.partition = &parts.partition;
    bake::BakeResult baked = bake::bake(mesh, object.view.header.solid != 0, as_given);
    baked.model.made_by = "sqmap view";
    baked.model.source = object.name;
    auto out = object_of(io::serialize(baked.model), object.name, object.metres_per_unit, 0, words);
    out->place = object.place;
    out->names_file = object.names_file;
    out->verdict = object.verdict;
    out->notes = object.notes;
    return out;
}

void place_beside(Object& object, std::span<const ObjectPtr> others)
{
    constexpr std::size_t k_a_row = 3;
    object.place = {};
    if (others.empty()) return;
    const std::size_t row = others.size() / k_a_row;
    // On one ground, the lowest point of the first object; the second row stands behind the first.
    const double size = object.metres.header.r_max * object.metres.header.unit;
    object.place.y = others.front()->place.y - others.front()->half.y + object.half.y;
    object.place.z = -1.1 * size * static_cast<double>(row);
    double edge = others.front()->place.x - others.front()->half.x - 0.03;
    for (const ObjectPtr& other : others)
        if (std::abs(other->place.z - object.place.z) < 0.5 * size) edge = std::max(edge, other->place.x + other->half.x);
    object.place.x = edge + 0.03 + object.half.x;
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
    out["place"] = vector_json(object.place);
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
