#include "viewer/server/scene/edits.h"

#include "sqmap/fit/fit.h"
#include "sqmap/shape/superquadric.h"
#include "viewer/server/scene/load.h"

#include <algorithm>
#include <map>
#include <variant>

namespace sqmap::viewer {
namespace {

/// #parts: the triangles of each, ascending.
std::vector<std::vector<std::uint32_t>> triangles_of_parts(const decompose::Partition& partition)
{
    std::vector<std::vector<std::uint32_t>> out(partition.part_count);
    for (std::uint32_t t = 0; t < partition.part_of_triangle.size(); ++t) out[partition.part_of_triangle[t]].push_back(t);
    return out;
}

/// A superquadric fitted to triangles, as the last of the parts.
void push_fit(Parts& parts, const Object& object, std::span<const std::uint32_t> triangles)
{
    const fit::FitReport fit = fit::fit_bounding(object.mesh, triangles, {});
    parts.superquadrics.push_back(fit.superquadric);
    parts.largest_f.push_back(fit.certificate.largest_f);
    parts.spheres.push_back(shape::bounding_sphere(fit.superquadric));
}

}  // namespace

Parts fitted(const Object& object, decompose::Partition partition, const Parts* keep, const Words& words)
{
    Parts out;
    std::map<std::vector<std::uint32_t>, std::size_t> known;
    if (keep != nullptr)
        for (auto& triangles : triangles_of_parts(keep->partition)) known.emplace(std::move(triangles), known.size());
    for (const auto& triangles : triangles_of_parts(partition)) {
        if (const auto same = known.find(triangles); same != known.end()) {
            out.superquadrics.push_back(keep->superquadrics[same->second]);
            out.largest_f.push_back(keep->largest_f[same->second]);
            out.spheres.push_back(keep->spheres[same->second]);
        } else {
            push_fit(out, object, triangles);
        }
    }
    out.partition = std::move(partition);
    out.names = part_names(object.mesh, object.dual, out.partition, out.superquadrics, words, object.frame());
    return out;
}

Parts refitted(const Object& object, const Parts& parts, std::uint32_t part)
{
    Parts fresh, out = parts;
    push_fit(fresh, object, triangles_of_parts(parts.partition)[part]);
    out.superquadrics[part] = fresh.superquadrics.front();
    out.largest_f[part] = fresh.largest_f.front();
    out.spheres[part] = fresh.spheres.front();
    return out;
}

std::optional<decompose::Partition> moved_cut(const Object& object, const decompose::Partition& partition, std::uint32_t part,
                                              std::uint32_t other, double distance)
{
    const std::vector<std::uint32_t>& label = partition.part_of_triangle;
    const double reach = distance / object.metres_per_model_unit();  // model units
    const std::size_t n = label.size();
    // The cut moves along the surface, from the border into the other part.
    std::vector<std::uint32_t> border;
    for (std::uint32_t t = 0; t < n; ++t)
        for (const std::uint32_t next : object.dual.neighbours[t])
            if (label[t] == other && next != mesh::k_no_triangle && label[next] == part) border.push_back(t);
    if (border.empty()) return std::nullopt;  // no cut between them
    const std::vector<std::uint32_t> taken = nearest_seeds(
        object.mesh, object.dual, border, [&](std::uint32_t t, double along) { return label[t] == other && along <= reach; });
    // The largest piece that is left stays the other part; smaller ones that the cut leaves behind go with it.
    std::vector<std::uint32_t> piece(n, 0);
    std::uint32_t pieces = 0, largest = 0;
    std::size_t max = 0;
    std::vector<std::uint32_t> stack;
    for (std::uint32_t t = 0; t < n; ++t) {
        if (label[t] != other || taken[t] != k_no_seed || piece[t] != 0) continue;
        piece[t] = ++pieces;
        stack = {t};
        std::size_t size = 0;
        while (!stack.empty()) {
            const std::uint32_t at = stack.back();
            stack.pop_back();
            ++size;
            for (const std::uint32_t next : object.dual.neighbours[at])
                if (next != mesh::k_no_triangle && label[next] == other && taken[next] == k_no_seed && piece[next] == 0) {
                    piece[next] = pieces;
                    stack.push_back(next);
                }
        }
        if (size > max) max = size, largest = pieces;
    }
    constexpr std::size_t k_least = 16;  // triangles: fewer are no part
    if (max < k_least) return std::nullopt;
    decompose::Partition out = partition;
    out.boundaries.clear();
    for (std::uint32_t t = 0; t < n; ++t)
        if (label[t] == other && piece[t] != largest) out.part_of_triangle[t] = part;
    return out;
}

std::vector<std::vector<std::uint32_t>> neighbours_of(const Object& object, const decompose::Partition& partition)
{
    std::vector<std::vector<std::uint32_t>> out(partition.part_count);
    for (std::uint32_t t = 0; t < object.dual.neighbours.size(); ++t)
        for (const std::uint32_t n : object.dual.neighbours[t]) {
            if (n == mesh::k_no_triangle) continue;
            const std::uint32_t a = partition.part_of_triangle[t], b = partition.part_of_triangle[n];
            if (a != b && std::find(out[a].begin(), out[a].end(), b) == out[a].end()) out[a].push_back(b);
        }
    for (auto& list : out) std::sort(list.begin(), list.end());
    return out;
}

std::shared_ptr<Object> rebaked(const Object& object, const Parts& parts, BakeMeshOptions options, const Words& words)
{
    options.provenance = {.made_by = "sqmap view", .source = object.name};
    if (object.baked_with) {
        const auto progress = std::move(options.bake.progress);
        options.bake = *object.baked_with;
        options.bake.progress = progress;
    }
    options.bake.partition = &parts.partition;
    BakedModel baked = bake_mesh(admitted_mesh_of(object.view), options);
    std::vector<Note> notes;
    for (const Note& note : object.notes)
        if (!is_about_model(note)) notes.push_back(note);
    for (const Note& note : baked.notes)
        if (is_about_model(note)) notes.push_back(note);
    baked.notes = std::move(notes);
    auto out = object_from_model(baked.bytes(), object.name, 1, words);
    out->name = object.name;
    out->put_at(object.metres_per_unit, object.position, object.up);
    out->names_file = object.names_file;
    out->admission = object.admission;
    out->baked_with = object.baked_with;
    return out;
}

}  // namespace sqmap::viewer
