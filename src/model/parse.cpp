#include "sqmap/model/parse.h"

#include "model/candidate_lists.h"
#include "model/central_cells.h"
#include "model/flags.h"
#include "model/locator_cells.h"
#include "model/notes_field.h"
#include "model/parse_steps.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

namespace sqmap::model {

namespace {

static_assert(sizeof(Part) == sizeof(fb::Part) && alignof(Part) == alignof(fb::Part));
static_assert(sizeof(Header) == sizeof(fb::Header) && alignof(Header) == alignof(fb::Header));
static_assert(sizeof(Seed) == sizeof(fb::Seed) && alignof(Seed) == alignof(fb::Seed));
static_assert(sizeof(HierarchyNode) == sizeof(fb::HierarchyNode) && sizeof(HierarchyGroup) == sizeof(fb::HierarchyGroup));
static_assert(sizeof(SurfaceSample) == sizeof(fb::SurfaceSample));
static_assert(sizeof(DistanceHeader) == sizeof(fb::DistanceHeader));
static_assert(sizeof(HalfSpacef) == sizeof(fb::HalfSpace) && alignof(HalfSpacef) == alignof(fb::HalfSpace));
static_assert(sizeof(BoundFigures) == sizeof(fb::BoundFigures) && alignof(BoundFigures) == alignof(fb::BoundFigures));
static_assert(sizeof(Locator) == sizeof(fb::Locator) && alignof(Locator) == alignof(fb::Locator));
static_assert(sizeof(Block) == sizeof(fb::Block) && alignof(Block) == alignof(fb::Block));

constexpr std::uint32_t k_max_base = 256;
constexpr std::uint32_t k_max_sides = 64;
constexpr float k_max_taper = 0.951f;
constexpr std::int32_t k_max_winding = 1 << 20;  // sums of it and any list's crossings stay within 32 bits

bool finite(std::span<const float> values)
{
    for (const float v : values)
        if (!std::isfinite(v)) return false;
    return true;
}

/// Checks one cell and all that hangs on it.
bool valid_cell(const CentralArrays<ArrayView>& own, CentralCell cell, int depth)
{
    const CellKind kind = cell.kind();
    if (kind == CellKind::Uniform || kind == CellKind::Single) return cell.has_valid_bits();
    if (kind == CellKind::Split) {
        if (depth >= k_max_split_depth || k_split_size * std::size_t{cell.payload()} >= own.splits.size()) return false;
        const std::uint16_t* split = own.splits.data() + k_split_size * std::size_t{cell.payload()};
        for (int i = 0; i < 4; ++i)
            if (!valid_cell(own, {split[k_split_cells + i]}, depth + 1)) return false;
        return true;
    }
    if (cell.payload() >= own.specials.size()) return false;
    const std::uint32_t offset = own.specials[cell.payload()];
    return within(offset, 1, own.pool.size()) && within(offset, LayeredHead{own.pool[offset]}.record_size(), own.pool.size());
}

/// Checks a part's superquadric and its bounds.
ParseStatus check_superquadric(const Part& part)
{
    const float* floats = part.a;
    if (!finite({floats, offsetof(Part, base) / sizeof(float)}) || !std::isfinite(part.area)) return ParseStatus::BadValue;
    for (const float a : part.a)
        if (!(a > 0)) return ParseStatus::BadValue;
    for (const float e : part.eps)
        if (!(e >= 0.099f && e <= 2.001f)) return ParseStatus::BadValue;
    for (const float t : part.taper)
        if (!(std::abs(t) <= k_max_taper)) return ParseStatus::BadValue;
    if (!(part.bend >= 0) || !(part.sphere[3] >= 0)) return ParseStatus::BadValue;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            if (!(std::abs(dot(vec3(part.rotation + 3 * i), vec3(part.rotation + 3 * j)) - (i == j ? 1.f : 0.f)) < 1e-4f))
                return ParseStatus::BadValue;
    if (part.centre_winding > k_max_winding || part.centre_winding < -k_max_winding) return ParseStatus::BadValue;
    return ParseStatus::Ok;
}

/// Checks the polytopes: of every part or of none.
ParseStatus check_bounds(const ModelView& v)
{
    if (v.polytope_ends.empty())
        return v.polytope_sides.empty() && v.bound_figures.empty() ? ParseStatus::Ok : ParseStatus::BadStructure;
    if (v.polytope_ends.size() != v.parts.size() || v.polytope_ends.back() != v.polytope_sides.size() ||
        v.bound_figures.size() != v.parts.size() + 1)
        return ParseStatus::BadStructure;
    std::uint32_t first = 0;
    for (const std::uint32_t end : v.polytope_ends) {
        if (end < first || end - first > k_max_sides) return ParseStatus::BadStructure;
        first = end;
    }
    for (const HalfSpacef& side : v.polytope_sides)
        if (!finite({&side.normal.x, 4}) || !(std::abs(norm_sq(side.normal) - 1.f) < 1e-4f)) return ParseStatus::BadValue;
    for (const BoundFigures& f : v.bound_figures)
        if (!finite({&f.solid_volume, sizeof f / sizeof(float)})) return ParseStatus::BadValue;
    return ParseStatus::Ok;
}

/// Checks a part's central map.
ParseStatus check_chart(const Part& part, const ModelView& view)
{
    const std::uint32_t n = part.base;
    if (!(part.w_step > 0) || !(part.w_min >= 0)) return ParseStatus::BadValue;
    if (!std::isfinite(part.w_min + 65535.f * part.w_step)) return ParseStatus::BadValue;
    for (int i = 0; i < 9; ++i)
        if (!(part.chart_lo[i] < part.chart_hi[i])) return ParseStatus::BadValue;
    for (int i = 0; i < 3; ++i) {
        // Rows must be an orthonormal frame divided by a.
        for (int j = 0; j < 3; ++j) {
            const float d = part.a[i] * part.a[j] * dot(vec3(part.chart_rows + 3 * i), vec3(part.chart_rows + 3 * j));
            if (!(std::abs(d - (i == j ? 1.f : 0.f)) < 1e-4f)) return ParseStatus::BadValue;
        }
    }
    if (n < k_block || n > k_max_base || n % k_block != 0) return ParseStatus::BadStructure;
    if (part.samples.count != k_faces * (n + 1) * (n + 1) || part.cells.count != k_faces * n * n ||
        part.blocks.count != k_faces * (n / k_block) * (n / k_block))
        return ParseStatus::BadStructure;
    bool inside = view.splits.size() % k_split_size == 0;
    CentralArrays<ArrayView>::each_slice(
        [&](const Slice& slice, std::size_t values, const auto& array) {
            inside = inside && within(slice.first, slice.count, array.size() / values);
        },
        part, view);
    if (!inside) return ParseStatus::BadStructure;
    const CentralArrays<ArrayView> own = arrays_of(view, part);
    for (const std::uint16_t word : own.cells)
        if (!valid_cell(own, {word}, 0)) return ParseStatus::BadStructure;
    return ParseStatus::Ok;
}

/// Seeds of existing parts up to the last; where several are searched from, choices among them in the word before.
bool valid_chain(const ModelView& v, std::uint32_t first)
{
    std::uint32_t count = 1;
    while (!is_last_seed(v.seeds[first + count - 1]) && count <= k_max_seeds) ++count;
    if (count > k_max_seeds) return false;
    for (std::uint32_t k = 0; k < count; ++k)
        if (seed_part(v.seeds[first + k]) >= v.parts.size()) return false;
    if (count == 1) return true;
    if (first == 0) return false;
    for (std::uint32_t octant = 0; octant < 8; ++octant)
        if (seed_choice(v.seeds[first - 1].direction, octant) >= count) return false;
    return true;
}

/// Eighths that exist, divided no further than cells may be.
bool valid_divisions(const ModelView& v, LocatorCell cell, int left)
{
    if (!cell.is_divided()) return true;
    if (left == 0 || !within(cell.first(), 8, v.locator_cells.size())) return false;
    for (std::uint32_t i = 0; i < 8; ++i)
        if (!valid_divisions(v, {v.locator_cells[cell.first() + i]}, left - 1)) return false;
    return true;
}

/// A list, and planes of its parts or a seed, that exist.
bool valid_contents(const ModelView& v, LocatorCell cell)
{
    if (cell.is_free() || cell.is_divided()) return true;
    if (cell.list() >= v.part_lists.size()) return false;
    if (cell.has_seeds()) return cell.first() < v.seeds.size();
    if (!within(cell.first(), cell.planes(), v.planes.size())) return false;
    for (std::uint32_t k = 0; k < cell.planes(); ++k)
        if (part_in_list(v.part_lists[cell.list()], LocatorPlane{v.planes[cell.first() + k]}.slot()) == k_no_part) return false;
    return true;
}

/// Checks planes, seeds and lists of parts, to which the cells of a locator lead. @pre check_cells
ParseStatus check_contents(const ModelView& v)
{
    for (const std::uint32_t word : v.locator_cells)
        if (!valid_contents(v, {word})) return ParseStatus::BadStructure;
    for (const std::uint32_t list : v.part_lists)
        for (const std::uint8_t part : decode_list(list))
            if (part != k_no_part && part >= v.parts.size()) return ParseStatus::BadStructure;
    // Every chain ends.
    if (!v.seeds.empty() && !is_last_seed(v.seeds.back())) return ParseStatus::BadStructure;
    for (const std::uint32_t word : v.locator_cells)
        if (const LocatorCell cell{word}; cell.has_seeds() && !valid_chain(v, cell.first())) return ParseStatus::BadStructure;
    return ParseStatus::Ok;
}

/// Which cells of a brick are not Free, one bit each.
std::uint64_t occupied_cells(const ModelView& v, LocatorBrick brick)
{
    std::uint64_t occupied = 0;
    for (std::uint32_t k = 0; k < brick.cell_count(); ++k)
        if (!LocatorCell{v.locator_cells[brick.first() + k]}.is_free()) occupied |= std::uint64_t{1} << k;
    return occupied;
}

/// True for an empty list, and for a valid two-level mask over so many triangles.
bool valid_list(std::span<const std::uint16_t> list, std::uint32_t triangles)
{
    if (list.empty()) return true;
    const auto words = static_cast<std::uint32_t>(mask_words(triangles));
    const std::size_t steps = mask_words(words);
    if (list.size() <= steps) return false;
    const auto bits_within = [](std::uint32_t word, std::uint32_t bits) { return bits >= 16 || word >> bits == 0; };
    if (!bits_within(list[steps - 1], words - 16 * static_cast<std::uint32_t>(steps - 1))) return false;
    std::size_t filled = 0;
    for (const std::uint16_t word : list.first(steps)) filled += static_cast<std::size_t>(std::popcount(word));
    if (filled != list.size() - steps) return false;
    const bool is_last_filled = (list[steps - 1] >> (words - 1) % 16 & 1u) != 0;
    if (is_last_filled && !bits_within(list.back(), triangles - 16 * (words - 1))) return false;
    return std::none_of(list.begin() + static_cast<std::ptrdiff_t>(steps), list.end(),
                        [](std::uint16_t word) { return word == 0; });
}

/// A record with a list for every cell that is not Free, of triangles that exist.
bool valid_candidates(const ModelView& v, std::size_t index)
{
    const LocatorBrick brick{v.bricks[index]};
    const std::uint32_t first = v.near_bricks[index];
    if (brick.is_free()) return first == k_no_candidates;
    if (!within(first, CandidateRecord::k_head, v.near.size())) return false;
    const CandidateRecord record = candidate_record(v, index);
    if (record.occupied != occupied_cells(v, brick)) return false;
    if (std::uint64_t{first} + record.head_size() > v.near.size() || record.starts[0] != 0) return false;
    for (std::uint32_t k = 0; k < record.cells(); ++k)
        if (record.starts[k] > record.starts[k + 1]) return false;
    if (std::uint64_t{first} + record.size() > v.near.size()) return false;
    for (std::uint32_t k = 0; k < record.cells(); ++k)
        if (!valid_list({record.lists + record.starts[k], record.lists + record.starts[k + 1]}, record.triangles)) return false;
    for (std::uint32_t k = 0; k < record.triangles; ++k)
        if (record.all().triangle(k) >= v.triangle_part.size()) return false;
    return true;
}

/// False where it says what no cure does.
bool read_cure(const fb::Cure* c, ModelView& view)
{
    if (c == nullptr) return true;
    view.cure = {Rung{c->rung()}, c->from_mean(), c->from_p99(), c->from_max(),
                 c->to_mean(),    c->to_p99(),    c->to_max(),   c->made_up_share()};
    if (c->cells() != nullptr) view.made_up_cells = {c->cells()->data(), c->cells()->size()};
    for (const double value :
         {c->from_mean(), c->from_p99(), c->from_max(), c->to_mean(), c->to_p99(), c->to_max(), c->made_up_share()})
        if (!(value >= 0) || !std::isfinite(value)) return false;
    return view.cure.rung == Rung::Closed || view.cure.rung == Rung::Wrapped;
}

}  // namespace

const char* to_string(ParseStatus status) noexcept
{
    switch (status) {
        case ParseStatus::Ok:
            return "ok";
        case ParseStatus::Truncated:
            return "truncated or malformed";
        case ParseStatus::NotAModel:
            return "not a .sqmap file";
        case ParseStatus::PaperModel:
            return "a paper model, which this reader does not know";
        case ParseStatus::WrongVersion:
            return "made by another format version";
        case ParseStatus::BadHash:
            return "content differs from what was written";
        case ParseStatus::BadStructure:
            return "sizes or indices contradict each other";
        case ParseStatus::BadValue:
            return "a value is not finite or out of range";
    }
    return "unknown";
}

const char* cure_of(ParseStatus status) noexcept
{
    switch (status) {
        case ParseStatus::Ok:
            return "";
        case ParseStatus::NotAModel:
            return "bake a mesh first, or get the whole file";
        case ParseStatus::PaperModel:
            return "open it with sqmap::paper";
        case ParseStatus::WrongVersion:
            return "bake the mesh again with this version";
        case ParseStatus::Truncated:
        case ParseStatus::BadHash:
        case ParseStatus::BadStructure:
        case ParseStatus::BadValue:
            break;
    }
    return "bake the mesh again, or get the whole file";
}

std::uint64_t content_hash(const ModelView& view) noexcept
{
    std::uint64_t hash = 0xcbf29ce484222325ull;
    hash_bytes(hash, std::span<const Header>(&view.header, 1));
    const auto add = [&](const char*, const auto& array) { hash_bytes(hash, array); };
    each_surface_array(add, view);
    // Format 11 had as many arrays here, empty in a central model.
    for (int i = 0; i < 11; ++i) hash_bytes(hash, std::span<const std::byte>());
    hash_bytes(hash, std::span<const Locator>(&view.locator, 1));
    each_cell_array(add, view);
    hash_bytes(hash, std::span<const DistanceHeader>(&view.distance.header, 1));
    DistanceArrays<ArrayView>::each(add, view.distance);
    const Measured& m = view.measured;
    const double figures[] = {double(m.points), double(m.missed), double(m.false_contacts), m.eq35_mean,
                              m.eq35_p99,       m.eq35_max,       m.depth_median,           m.depth_p95,
                              m.depth_p99,      m.depth_max,      m.normal_median,          m.q2_share};
    hash_bytes(hash, std::span<const double>(figures));
    for (const std::string_view text : {view.made_by, view.source, view.options})
        hash_bytes(hash, std::span<const char>(text.data(), text.size()));
    // Models without these keep the hash that they were written with.
    if (const double layers[] = {m.layer1_depth_p99, m.layer2_depth_p99}; layers[0] > 0 || layers[1] > 0)
        hash_bytes(hash, std::span<const double>(layers));
    if (view.mesh_hash != 0) hash_bytes(hash, std::span<const std::uint64_t>(&view.mesh_hash, 1));
    if (!view.polytope_ends.empty()) BoundArrays<ArrayView>::each(add, view);
    if (const Cure& c = view.cure; c.rung != Rung::AsItIs) {
        const double moved[] = {double(c.rung), c.from_mean, c.from_p99, c.from_max,
                                c.to_mean,      c.to_p99,    c.to_max,   c.made_up_share};
        hash_bytes(hash, std::span<const double>(moved));
        hash_bytes(hash, view.made_up_cells);
    }
    if (has_input(view)) InputArrays<ArrayView>::each(add, view.input);
    return hash;
}

ParseStatus read_model(const fb::Model& model, const std::byte* end, ModelView& v) noexcept
{
    if (model.version() != k_format_version || model.former_maps() != nullptr) return ParseStatus::WrongVersion;
    if (model.header() == nullptr) return ParseStatus::BadStructure;
    std::memcpy(&v.header, model.header(), sizeof(Header));
    const TableReader read(&model, *fb::ModelTypeTable());
    each_surface_array(read, v);
    if (model.locator() != nullptr) std::memcpy(&v.locator, model.locator(), sizeof(Locator));
    each_cell_array(read, v);
    BoundArrays<ArrayView>::each(read, v);
    if (const fb::Distance* d = model.distance(); d != nullptr && d->header() != nullptr) {
        std::memcpy(&v.distance.header, d->header(), sizeof(DistanceHeader));
        DistanceArrays<ArrayView>::each(TableReader(d, *fb::DistanceTypeTable()), v.distance);
    }
    if (const fb::Input* input = model.input(); input != nullptr)
        InputArrays<ArrayView>::each(TableReader(input, *fb::InputTypeTable()), v.input);
    if (const fb::Measured* m = model.measured(); m != nullptr)
        v.measured = {m->points(),        m->missed(),       m->false_contacts(),   m->eq35_mean(),       m->eq35_p99(),
                      m->eq35_max(),      m->depth_median(), m->depth_p95(),        m->depth_p99(),       m->depth_max(),
                      m->normal_median(), m->q2_share(),     m->layer1_depth_p99(), m->layer2_depth_p99()};
    if (!read_cure(model.cure(), v)) return ParseStatus::BadValue;
    const auto text = [](const flatbuffers::String* s) { return s == nullptr ? std::string_view() : s->string_view(); };
    v.made_by = text(model.made_by());
    v.source = text(model.source());
    v.options = text(model.options());
    v.mesh_hash = model.mesh_hash();

    const Header& h = v.header;
    for (const double value : {h.origin[0], h.origin[1], h.origin[2], h.unit, h.r_max, h.quantisation})
        if (!std::isfinite(value)) return ParseStatus::BadValue;
    if (!(h.unit > 0) || !(h.r_max > 0) || !finite(h.sphere) || !(h.sphere[3] >= 0)) return ParseStatus::BadValue;
    if (v.parts.empty() || v.parts.size() > k_max_parts) return ParseStatus::BadStructure;
    const std::size_t corners = v.triangles16.size() + v.triangles32.size();
    if ((!v.triangles16.empty() && !v.triangles32.empty()) || v.vertices.size() % 3 != 0 || corners != 3 * v.triangle_part.size())
        return ParseStatus::BadStructure;
    if (v.offsets.size() != v.samples.size() || v.smoothing.size() != v.samples.size()) return ParseStatus::BadStructure;
    // The writer builds from the end: the parts come last, and nothing stands behind them.
    if (reinterpret_cast<const std::byte*>(v.parts.data() + v.parts.size()) != end) return ParseStatus::BadStructure;
    if (content_hash(v) != model.content_hash()) return ParseStatus::BadHash;
    return check_notes(model);
}

/// Checks that the caller's coordinates are those of the vertices, up to rounding: boxes about these lead to those.
ParseStatus check_input(const ModelView& v) noexcept
{
    const InputArrays<ArrayView>& in = v.input;
    if (!has_input(v))
        return in.source_triangle.empty() && in.source_vertex.empty() ? ParseStatus::Ok : ParseStatus::BadStructure;
    if (!in.coordinates32.empty() && !in.coordinates64.empty()) return ParseStatus::BadStructure;
    if (in.coordinates32.size() + in.coordinates64.size() != v.vertices.size() ||
        in.source_triangle.size() != v.triangle_part.size() || in.source_vertex.size() != v.vertices.size() / 3)
        return ParseStatus::BadStructure;
    const Header& h = v.header;
    const Vec3d origin{h.origin[0], h.origin[1], h.origin[2]};
    for (std::size_t i = 0; i < v.vertices.size() / 3; ++i) {
        const Vec3d p = input_vertex(v, i), stored = cast<double>(vec3(&v.vertices[3 * i])), given = (p - origin) / h.unit;
        if (!is_finite(p)) return ParseStatus::BadValue;
        // Rounding to float moves a vertex, and so does subtraction far from zero.
        const double rounding = k_input_rounding * norm(stored) + 1e-14 * (norm(origin) + norm(p)) / h.unit;
        if (!(norm(given - stored) <= rounding)) return ParseStatus::BadValue;
    }
    return ParseStatus::Ok;
}

ParseStatus check_surface(const ModelView& v) noexcept
{
    if (!finite(v.vertices)) return ParseStatus::BadValue;
    for (const std::uint32_t i : v.triangles16)
        if (i >= v.vertices.size() / 3) return ParseStatus::BadStructure;
    for (const std::uint32_t i : v.triangles32)
        if (i >= v.vertices.size() / 3) return ParseStatus::BadStructure;
    for (const std::uint16_t p : v.triangle_part)
        if (part_of(p) >= v.parts.size()) return ParseStatus::BadStructure;
    if (v.pieces.size() != 9 * v.piece_triangle.size() || !std::is_sorted(v.piece_triangle.begin(), v.piece_triangle.end()) ||
        (!v.piece_triangle.empty() && v.piece_triangle.back() >= v.triangle_part.size()))
        return ParseStatus::BadStructure;
    if (!finite(v.pieces)) return ParseStatus::BadValue;
    for (const Part& part : v.parts)
        if (const ParseStatus status = check_superquadric(part); status != ParseStatus::Ok) return status;
    if (const ParseStatus status = check_bounds(v); status != ParseStatus::Ok) return status;
    if (const ParseStatus status = check_input(v); status != ParseStatus::Ok) return status;
    if (!v.made_up_cells.empty() && v.made_up_cells.size() != (v.locator_cells.size() + 31) / 32)
        return ParseStatus::BadStructure;
    return check_distance(v);
}

ParseStatus check_cells(const ModelView& v) noexcept
{
    const Locator& l = v.locator;
    if (v.bricks.empty())
        return l.bricks[0] == 0 && v.locator_cells.empty() && v.part_lists.empty() && v.planes.empty() && v.seeds.empty()
                   ? ParseStatus::Ok
                   : ParseStatus::BadStructure;
    if (!finite(l.origin) || !std::isfinite(l.cell) || !(l.cell > 0) || !std::isfinite(l.plane_reach) || !(l.plane_reach > 0))
        return ParseStatus::BadValue;
    // A byte names a part.
    if (v.parts.size() >= k_no_part || v.locator_cells.empty()) return ParseStatus::BadStructure;
    for (const std::uint32_t n : l.bricks)
        if (n == 0 || n > 256) return ParseStatus::BadStructure;
    if (std::uint64_t(l.bricks[0]) * l.bricks[1] * l.bricks[2] != v.bricks.size()) return ParseStatus::BadStructure;
    for (const std::uint32_t word : v.bricks) {
        const LocatorBrick brick{word};
        if (brick.is_free()) continue;
        if (!within(brick.first(), brick.cell_count(), v.locator_cells.size())) return ParseStatus::BadStructure;
        if (brick.is_deep() && LocatorCell{v.locator_cells[brick.first()]}.is_free()) return ParseStatus::BadStructure;
    }
    for (const std::uint32_t word : v.bricks) {
        const LocatorBrick brick{word};
        if (brick.is_free()) continue;
        for (std::uint32_t k = 0; k < brick.cell_count(); ++k)
            if (!valid_divisions(v, {v.locator_cells[brick.first() + k]}, brick.is_deep() ? 0 : k_max_divisions))
                return ParseStatus::BadStructure;
    }
    return ParseStatus::Ok;
}

ParseStatus check_candidates(const ModelView& v, std::size_t rises) noexcept
{
    if (v.bricks.empty() || !has_exact(v))
        return v.near_bricks.empty() && v.near.empty() && v.rises.empty() ? ParseStatus::Ok : ParseStatus::BadStructure;
    if (v.near_bricks.size() != v.bricks.size() || v.rises.size() != rises) return ParseStatus::BadStructure;
    for (std::size_t i = 0; i < v.bricks.size(); ++i)
        if (!valid_candidates(v, i)) return ParseStatus::BadStructure;
    return ParseStatus::Ok;
}

ParseStatus parse(std::span<const std::byte> bytes, ModelView& view) noexcept
{
    const auto* data = reinterpret_cast<const std::uint8_t*>(bytes.data());
    if (bytes.size() < 16) return ParseStatus::Truncated;
    if (flatbuffers::BufferHasIdentifier(data, k_paper_identifier)) return ParseStatus::PaperModel;
    if (!fb::ModelBufferHasIdentifier(data)) return ParseStatus::NotAModel;
    flatbuffers::Verifier verifier(data, bytes.size(), 16, 100000);
    if (!fb::VerifyModelBuffer(verifier)) return ParseStatus::Truncated;
    ModelView v;
    ParseStatus status = read_model(*fb::GetModel(data), bytes.data() + bytes.size(), v);
    if (status == ParseStatus::Ok && v.header.projection != 0) status = ParseStatus::BadStructure;
    if (status == ParseStatus::Ok) status = check_surface(v);
    for (std::size_t i = 0; i < v.parts.size() && status == ParseStatus::Ok; ++i) status = check_chart(v.parts[i], v);
    if (status == ParseStatus::Ok) status = check_cells(v);
    if (status == ParseStatus::Ok) status = check_contents(v);
    if (status == ParseStatus::Ok) status = check_candidates(v, padded_rises(v.locator_cells.size()));
    if (status == ParseStatus::Ok) view = v;
    return status;
}

}  // namespace sqmap::model
