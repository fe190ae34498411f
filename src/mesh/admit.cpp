// The ladder of admission: the mesh as it is, repaired, closed, wrapped; the first rung that judge_surface takes. An outer solid
// is made beside the ladder.
#include "sqmap/mesh/admission.h"

#include "sqmap/mesh/wrap.h"

#include "admit_steps.h"
#include "close/close.h"
#include "close/steps.h"
#include "surface.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace sqmap::mesh {
namespace {

constexpr double k_proven_apart = 1e-7;  ///< between an outer solid's surface and the input, cells

/// True if a higher rung may take a mesh that the code refuses.
bool is_curable(Refusal code, const AdmitOptions& options)
{
    if (options.repair < Repair::Close || options.accept_surface || options.thickness > 0) return false;
    return code == Refusal::NonManifold || code == Refusal::Orient || code == Refusal::Open || code == Refusal::Limit;
}

void check_cost(const Surface& surface, const AdmitOptions& options)
{
    if (surface.faces.size() > options.max_cured_faces)
        refuse(Refusal::Limit, "mesh",
               "it needs a surface of its own, and has " + number(surface.faces.size()) + " triangles; the limit of cures is " +
                   number(options.max_cured_faces),
               Words("raise the limit with ", Setting::MaxCuredFaces, "", ", or ") + "close the mesh");
}

/// The part of the input that bounds the solid: the polygons of which a cure kept something, or with counts = false the others.
/// cured: made-up faces have no polygon.
Surface what_counts(const Surface& soup, const Surface& cured, bool counts = true)
{
    std::vector<bool> kept;
    for (const Face& f : cured.faces) {
        if (f.polygon == k_none) continue;
        if (f.polygon >= kept.size()) kept.resize(f.polygon + 1, false);
        kept[f.polygon] = true;
    }
    Surface out{soup.points, soup.source, {}};
    for (const Face& f : soup.faces)
        if ((f.polygon < kept.size() && kept[f.polygon]) == counts) out.faces.push_back(f);
    return out;
}

Mesh scaled(const Surface& surface, double unit)
{
    Mesh mesh;
    for (const Vec3d& p : surface.points) mesh.vertices.push_back(unit * p);
    for (const Face& f : surface.faces) mesh.triangles.push_back(f.v);
    return mesh;
}

class Ladder {
public:
    Ladder(const PolygonView& in, const AdmitOptions& options) : in_(in), options_(options) {}

    AdmitResult judge()
    {
        try {
            take(soup_of(in_));
            const Surface soup = surface_;
            if (options_.solid == SolidKind::Outer) {
                enclose(soup);
                return std::move(out_);
            }
            clean_up();
            climb(soup);
        } catch (Refused& refused) {
            reset({});
            out_.diagnosis = std::move(refused.diagnosis);
        }
        return std::move(out_);
    }

private:
    void take(Soup soup)
    {
        surface_ = std::move(soup.surface);
        box_ = soup.box;
        diagonal_ = norm(size(box_));
        degenerate_count_ = soup.degenerate_polygons;
        if (soup.unused_vertices > 0) note(RepairKind::UnusedVertices, soup.unused_vertices);
        if (soup.cut_polygons > 0) note(RepairKind::Triangulated, soup.cut_polygons);
    }

    void clean_up()
    {
        const Cleaned cleaned = clean(surface_, box_);
        if (cleaned.welded_vertices > 0) note(RepairKind::WeldedVertices, cleaned.welded_vertices);
        if (const std::uint64_t n = degenerate_count_ + cleaned.degenerate_faces; n > 0) note(RepairKind::DegenerateFaces, n);
        if (cleaned.duplicate_faces > 0) note(RepairKind::DuplicateFaces, cleaned.duplicate_faces);
    }

    /// soup: the triangles as they came, which cures are measured against.
    void climb(const Surface& soup)
    {
        const Surface cleaned = surface_;
        const std::vector<RepairNote> repairs = out_.repairs;
        try {
            judge_surface(surface_, box_, options_, out_);
            out_.admission = out_.repairs.empty() ? Admission::Accept : Admission::Repaired;
            return;
        } catch (Refused& refused) {
            if (!is_curable(refused.diagnosis.code, options_)) throw;
            first_ = std::move(refused.diagnosis);
        }
        check_cost(cleaned, options_);
        if (cured(repairs, [&] { fill(cleaned); })) {
            out_.admission = Admission::Closed;
        } else if (options_.repair >= Repair::Wrap && cured(repairs, [&] { wrap_up(cleaned); })) {
            out_.admission = Admission::Wrapped;
            std::fill(out_.source_triangle.begin(), out_.source_triangle.end(), k_no_polygon);  // a surface of its own
        } else {
            throw Refused{first_};
        }
        const Surface& input = out_.admission == Admission::Closed ? what_counts(soup, surface_) : soup;
        const double unit = options_.unit.value_or(1.0);
        out_.deviation = deviation(scaled(input, unit), out_.mesh, out_.made_up);
        if (out_.admission == Admission::Wrapped)
            out_.deviation->bounding_to_result = Distances{unit * moved_.mean, unit * moved_.p99, unit * moved_.max};
        if (out_.admission == Admission::Closed)
            warn(dropped_warning(scaled(what_counts(soup, surface_, false), unit), out_.mesh, unit * diagonal_));
        else
            warn(tolerance_warning(out_.mesh, *out_.deviation, options_.wrap));
    }

    /// True if a cure gives a solid; else adds the reason to the first refusal's.
    template <class Cure>
    bool cured(const std::vector<RepairNote>& repairs, Cure&& cure)
    {
        reset(repairs);
        try {
            cure();
            judge_surface(surface_, box_, options_, out_);
            return true;
        } catch (Refused& refused) {
            if (refused.diagnosis.code == Refusal::Limit) first_.cure = refused.diagnosis.cure;
            first_.message += "; " + refused.diagnosis.message;
        } catch (const RefusedMesh& refused) {
            refuse(refused.diagnosis().code, "mesh", refused.diagnosis().message,
                   Words("raise the limit of the wrap with ", Setting::MaxCells));
        }
        return false;
    }

    void fill(const Surface& cleaned)
    {
        Closing closing = close(cleaned, {diagonal_, options_.max_filled, options_.refine_fillings});
        if (!closing.failure.empty()) refuse(first_.code, "mesh", "closing it fails: " + closing.failure, "");
        for (const RepairNote& r : closing.notes) note(r.kind, r.count);
        surface_ = std::move(closing.surface);
    }

    void wrap_up(const Surface& cleaned)
    {
        Surface oriented = cleaned;
        if (const std::uint64_t turned = orient_outward(oriented); turned > 0) note(RepairKind::Reoriented, turned);
        std::vector<Triangle> triangles;
        for (const Face& f : oriented.faces) triangles.push_back(f.v);
        const WrapResult wrapped = wrap(oriented.points, triangles, options_.wrap);
        if (wrapped.mesh.triangles.empty()) refuse(first_.code, "mesh", "wrapping it finds no solid", "");
        moved_ = wrapped.moved;
        take_surface(wrapped.mesh, wrapped.made_up);
        note(RepairKind::Wrapped, surface_.faces.size());
    }

    /// A solid about all that came, proven to hold it.
    void enclose(const Surface& soup)
    {
        check_cost(soup, options_);
        std::vector<Triangle> triangles;
        for (const Face& f : soup.faces) triangles.push_back(f.v);
        const OuterResult outer = outer_solid(soup.points, triangles,
                                              {.tolerance = options_.wrap.tolerance,
                                               .gap = options_.gap,
                                               .max_triangles = options_.wrap.max_triangles,
                                               .max_cells = options_.wrap.max_cells});
        if (outer.mesh.triangles.empty())
            refuse(Refusal::Flat, "mesh", "no face has an area: all vertices lie on lines", "give a mesh whose faces have areas");
        take_surface(outer.mesh, outer.made_up);
        judge_surface(surface_, box_, options_, out_);
        std::fill(out_.source_triangle.begin(), out_.source_triangle.end(), k_no_polygon);
        out_.admission = Admission::Wrapped;
        const double unit = options_.unit.value_or(1.0);
        const Mesh input = scaled(soup, unit);
        if (const auto missed =
                first_not_enclosed(input.vertices, input.triangles, out_.mesh, k_proven_apart * unit * outer.cell))
            refuse(Refusal::Internal, element("face", soup.faces[*missed].polygon), "the outer solid is not proven to hold it",
                   "move the mesh nearer to the origin, or report it with the file");
        note(RepairKind::Enclosed, soup.faces.size());
        out_.deviation = deviation(input, out_.mesh, out_.made_up);
        warn(tolerance_warning(out_.mesh, *out_.deviation, options_.wrap));
    }

    /// Goes on with a mesh that was made here.
    void take_surface(const Mesh& made, std::span<const std::uint8_t> made_up)
    {
        surface_ = {made.vertices, std::vector<std::uint32_t>(made.vertices.size(), k_none), {}};
        for (std::size_t t = 0; t < made.triangles.size(); ++t)
            surface_.faces.push_back({made.triangles[t], made_up[t] != 0 ? k_none : 0});
    }

    /// Clears the result but for its facts; the repairs become these.
    void reset(const std::vector<RepairNote>& repairs)
    {
        AdmitResult blank;
        blank.facts = out_.facts;
        blank.repairs = repairs;
        out_ = std::move(blank);
    }

    void note(RepairKind kind, std::uint64_t count) { mesh::note(out_.repairs, kind, count); }
    void warn(std::optional<Warning> warning)
    {
        if (warning) out_.warnings.push_back(std::move(*warning));
    }

    const PolygonView& in_;
    const AdmitOptions& options_;
    AdmitResult out_;
    Diagnosis first_;  ///< the refusal of the first rungs
    Box box_;
    double diagonal_ = 0;
    Surface surface_;
    Distances moved_;                     ///< of a wrapped surface, input units
    std::uint64_t degenerate_count_ = 0;  ///< polygons that repeat a corner
};

}  // namespace

AdmitResult admit(const PolygonView& polygons, const AdmitOptions& options)
{
    if (const std::string why = out_of_range(k_admission_numbers, options); !why.empty()) throw InvalidInput(why);
    return Ladder(polygons, options).judge();
}

}  // namespace sqmap::mesh
