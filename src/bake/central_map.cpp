// The central map: conservative rasterisation of the mesh's triangles onto a cube of directions, where straight edges
// stay straight and planes stay linear in w = 1/rho, so that every deviation below is exact up to rounding.
#include "central_map.h"

#include "bake/central/footprint.h"
#include "model/flags.h"
#include "sqmap/mesh/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

namespace sqmap::bake {

namespace {

using model::CellKind;
using model::CentralCell;
using model::LayeredHead;

constexpr double k_border = 4e-6;         // of a face: more than float rounding moves a point between cells
constexpr double k_same_place = 1e-9;     // of w
constexpr int k_max_bilinear = 3;         // surfaces over one cell that are worth corner samples of their own
constexpr double k_division_share = 0.6;  // a mixed cell is divided where that leaves at most this share of its misfit

/// Surface crossings of one ray from the centre, nearest first: values of w where the verdict flips.
struct RaySample {
    bool valid = false;
    int count = 0;
    std::array<double, 16> w{};
};

[[noreturn]] void too_large(const char* what)
{
    throw mesh::RefusedMesh(
        {mesh::Refusal::Limit, "part", what, "reduce the mesh, allow more parts with --max-parts, or a larger --target-error"});
}

class Baker {
public:
    Baker(const SurfaceContext& context, const shape::Superquadricd& sq, Vec3f centre, const ChartDomain& domain,
          std::span<const std::uint32_t> own_triangles, const CentralOptions& options)
        : context_(context), sq_(sq), options_(options)
    {
        own_.assign(context.mesh.triangles.size(), 0);
        for (const std::uint32_t t : own_triangles) own_[t] = 1;
        out_.centre = centre;
        centre_ = cast<double>(centre);
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) {
                out_.chart_rows[3 * i + j] = static_cast<float>(sq.rotation.row[i][j] / sq.a[i]);
                rows_.row[i][j] = out_.chart_rows[3 * i + j];
            }
        out_.domain = domain;
        out_.centre_winding = context.bvh.winding_number(centre_);
    }

    /// The cheapest resolution: too coarse a base is split everywhere, too fine a one stores what nobody needs.
    CentralMapData run(const KnownMap* known)
    {
        project();
        choose_range();
        if (known == nullptr || !follow(*known)) bake_bases();
        bake_offsets();
        bake_smoothing();
        return std::move(out_);
    }

private:
    void bake_bases()
    {
        const CentralMapData blank = out_;
        CentralMapData best;
        std::size_t best_bytes = std::numeric_limits<std::size_t>::max() / 2;
        for (const std::uint32_t base : {8u, 12u, 16u, 24u, 32u}) {
            if (base < options_.least_base || base > options_.max_base) continue;
            out_ = blank;
            out_.base = base_ = base;
            if (!bake_faces(best_bytes + best_bytes / 4)) break;
            if (const std::size_t bytes = out_.map_bytes(); bytes <= best_bytes) {
                best_bytes = bytes;
                best = std::move(out_);
            }
        }
        out_ = std::move(best);
        base_ = out_.base;
    }

    /// Takes over what no changed triangle reaches. False: nothing is, and the map has to be made anew.
    bool follow(const KnownMap& known)
    {
        const model::Part& was = known.part;
        const model::SampleRange range{was.w_min, was.w_step};
        if (was.centre_winding != out_.centre_winding || !range.holds(least_w_, max_w_)) return false;
        const CentralMapData blank = out_;
        set_range(range);
        out_.base = base_ = was.base;
        find_changed(known);
        known_ = &known;
        const bool done = bake_faces(std::numeric_limits<std::size_t>::max());
        known_ = nullptr;
        if (done) return true;
        out_ = blank;
        set_range(blank.range);
        return false;
    }

    /// Footprints of changed triangles, where they were and where they are.
    void find_changed(const KnownMap& known)
    {
        std::vector<std::uint8_t> is_changed(context_.mesh.triangles.size(), 0);
        std::vector<Vec3d> polygon;
        for (const std::uint32_t t : known.changed) {
            is_changed[t] = 1;
            polygon.clear();
            for (const std::uint32_t v : known.mesh.triangles[t]) polygon.push_back(rows_ * (known.mesh.vertices[v] - centre_));
            if (clip_to_domain(polygon)) spread(t, polygon, changed_);
        }
        for (std::size_t face = 0; face < model::k_faces; ++face)
            for (const Polygon& p : polygons_[face])
                if (is_changed[p.triangle] != 0) changed_[face].push_back(p);
    }

    /// Cells with a changed triangle over them or beside them, for neighbours share samples; and those whose triangles are asked
    /// for these and their blocks.
    struct Reached {
        std::vector<std::uint8_t> anew, listed;  ///< #cells of a face
    };

    Reached reached_cells(int face, double size, int n) const
    {
        const auto count = static_cast<std::size_t>(n * n);
        if (known_ == nullptr) return {std::vector<std::uint8_t>(count, 1), std::vector<std::uint8_t>(count, 1)};
        Reached reached{std::vector<std::uint8_t>(count, 0), std::vector<std::uint8_t>(count, 0)};
        const auto mark = [&](std::vector<std::uint8_t>& cells, int row0, int row1, int column0, int column1) {
            for (int row = std::max(row0, 0); row <= std::min(row1, n - 1); ++row)
                for (int column = std::max(column0, 0); column <= std::min(column1, n - 1); ++column)
                    cells[static_cast<std::size_t>(row * n + column)] = 1;
        };
        const auto cell = [&](double v) { return static_cast<int>(std::floor((v + 1) / size)); };
        for (const Polygon& p : changed_[static_cast<std::size_t>(face)]) {
            const Extent e = extent_of(p);
            mark(reached.anew, cell(e.lo_t - k_border) - 1, cell(e.hi_t + k_border) + 1, cell(e.lo_s - k_border) - 1,
                 cell(e.hi_s + k_border) + 1);
        }
        for (int row = 0; row < n; ++row)
            for (int column = 0; column < n; ++column) {
                if (reached.anew[static_cast<std::size_t>(row * n + column)] == 0) continue;
                const int r = row - row % model::k_block, c = column - column % model::k_block;
                mark(reached.listed, row - 1, row + 1, column - 1, column + 1);
                mark(reached.listed, r, r + model::k_block - 1, c, c + model::k_block - 1);
            }
        return reached;
    }

    /// A known cell and all that hangs on it. False: there is no room for it.
    bool keep_cell(CentralCell was, CentralCell& cell)
    {
        const model::ModelData& m = known_->model;
        cell = was;
        if (was.kind() == CellKind::Split) {
            const std::size_t record = out_.splits.size();
            if (record / model::k_split_size >= model::k_max_payload) return false;
            const std::uint16_t* from =
                m.splits.data() + model::k_split_size * (known_->part.first_split + std::size_t{was.payload()});
            out_.splits.insert(out_.splits.end(), from, from + model::k_split_size);
            for (std::size_t i = model::k_split_cells; i < model::k_split_size; ++i) {
                CentralCell child;
                if (!keep_cell({from[i]}, child)) return false;
                out_.splits[record + i] = child.word;
            }
            cell = CentralCell::of(CellKind::Split, record / model::k_split_size);
        }
        if (was.kind() == CellKind::Layered) {
            const std::uint16_t* from =
                m.pool.data() + known_->part.first_pool + m.specials[known_->part.first_special + was.payload()];
            if (!add_special(cell)) return false;
            out_.pool.insert(out_.pool.end(), from, from + LayeredHead{*from}.record_size());
        }
        return true;
    }

    using Faces = std::array<std::vector<Polygon>, model::k_faces>;

    /// A triangle as rays from the centre meet it.
    struct Sides {
        Vec3d normal[3];  ///< of the planes through the centre and an edge
        double tiny, volume;
    };

    bool buried(std::uint32_t triangle) const { return model::is_buried(context_.flags[triangle]); }

    /// Keeps the side of a convex polygon where value(corner) >= 0.
    template <class Value>
    void cut(std::vector<Vec3d>& polygon, Value&& value)
    {
        if (polygon.empty()) return;
        scratch_.clear();
        for (std::size_t i = 0; i < polygon.size(); ++i) {
            const Vec3d a = polygon[i], b = polygon[(i + 1) % polygon.size()];
            const double va = value(a), vb = value(b);
            if (va >= 0) scratch_.push_back(a);
            if ((va >= 0) != (vb >= 0)) scratch_.push_back(a + (va / (va - vb)) * (b - a));
        }
        polygon.swap(scratch_);
    }

    /// Clips every triangle to the chart's domain and spreads it over the faces.
    void project()
    {
        const std::size_t n = context_.mesh.vertices.size();
        x_.resize(n);
        place_of_.resize(context_.mesh.triangles.size());
        for (std::size_t i = 0; i < n; ++i) x_[i] = rows_ * (context_.mesh.vertices[i] - centre_);
        std::vector<Vec3d> polygon;
        for (std::uint32_t t = 0; t < context_.mesh.triangles.size(); ++t) {
            const mesh::Triangle& tri = context_.mesh.triangles[t];
            polygon.assign({x_[tri[0]], x_[tri[1]], x_[tri[2]]});
            if (!clip_to_domain(polygon)) continue;
            place_of_[t] = static_cast<std::uint32_t>(sides_.size());
            sides_.push_back(sides_of(tri));
            spread(t, polygon, polygons_);
        }
    }

    /// False: nothing is left.
    bool clip_to_domain(std::vector<Vec3d>& polygon)
    {
        for (std::size_t k = 0; k < 9 && !polygon.empty(); ++k) {
            double least = std::numeric_limits<double>::infinity(), most = -least;
            for (const Vec3d& p : polygon) {
                const double v = model::domain_coordinate(p, k);
                least = std::min(least, v);
                most = std::max(most, v);
            }
            const double lo = out_.domain.lo[k] - k_border, hi = out_.domain.hi[k] + k_border;
            if (most < lo || least > hi) polygon.clear();
            if (least < lo) cut(polygon, [&](Vec3d p) { return model::domain_coordinate(p, k) - lo; });
            if (most > hi) cut(polygon, [&](Vec3d p) { return hi - model::domain_coordinate(p, k); });
        }
        return !polygon.empty();
    }

    Sides sides_of(const mesh::Triangle& tri) const
    {
        const Vec3d a = x_[tri[0]], b = x_[tri[1]], c = x_[tri[2]];
        // The same for both triangles of an edge.
        const auto edge = [](std::uint32_t i, std::uint32_t j, Vec3d e, Vec3d f) { return i < j ? cross(e, f) : -cross(f, e); };
        const double size = std::sqrt(std::max({norm_sq(a), norm_sq(b), norm_sq(c)}));
        return {{edge(tri[1], tri[2], b, c), edge(tri[2], tri[0], c, a), edge(tri[0], tri[1], a, b)},
                1e-14 * size * size,
                dot(a, cross(b, c))};
    }

    void spread(std::uint32_t t, const std::vector<Vec3d>& whole, Faces& to)
    {
        std::vector<Vec3d> polygon;
        for (int face = 0; face < model::k_faces; ++face) {
            const int m = face >> 1, iu = (m + 1) % 3, iv = (m + 2) % 3;
            const double sign = (face & 1) != 0 ? -1.0 : 1.0;
            polygon.clear();
            for (const Vec3d& p : whole) polygon.push_back({sign * p[m], p[iu], p[iv]});
            const double e = 1 + k_border;
            cut(polygon, [](Vec3d p) { return p.x - 1e-4; });
            cut(polygon, [&](Vec3d p) { return e * p.x - p.y; });
            cut(polygon, [&](Vec3d p) { return e * p.x + p.y; });
            cut(polygon, [&](Vec3d p) { return e * p.x - p.z; });
            cut(polygon, [&](Vec3d p) { return e * p.x + p.z; });
            if (polygon.empty()) continue;
            Polygon footprint;
            footprint.triangle = t;
            for (const Vec3d& p : polygon)
                footprint.corner[static_cast<std::size_t>(footprint.count++)] = {p.y / p.x, p.z / p.x, 1 / p.x};
            to[static_cast<std::size_t>(face)].push_back(footprint);
        }
    }

    void choose_range()
    {
        double lo = std::numeric_limits<double>::infinity(), hi = 0;
        for (const auto& face : polygons_)
            for (const Polygon& p : face)
                for (int i = 0; i < p.count; ++i) {
                    lo = std::min(lo, p.corner[static_cast<std::size_t>(i)].w);
                    hi = std::max(hi, p.corner[static_cast<std::size_t>(i)].w);
                }
        if (!(hi > 0)) lo = hi = 1;
        least_w_ = lo;
        max_w_ = hi;
        set_range(model::SampleRange::around(lo, hi));
    }

    void set_range(model::SampleRange range)
    {
        out_.range = range;
        deviations_ = model::DeviationCodes(range.w_step);
        // d rho = dw / w^2, largest where w is least, in the longest axis.
        out_.quantisation = 0.5 * range.w_step / (least_w_ * least_w_) * std::max({sq_.a.x, sq_.a.y, sq_.a.z});
    }

    double decode(std::uint16_t v) const { return static_cast<double>(out_.range.decode(v)); }

    std::uint16_t stored_sample(const RaySample& r) const
    {
        return r.valid && r.count > 0 ? out_.range.encode(r.w[0]) : model::k_no_surface;
    }

    /// Crossings of the ray through (s, t) with the triangles of polys, as verdict flips.
    RaySample sample(int face, double s, double t, const std::vector<Polygon>& polys) const
    {
        // A ray through an edge or corner is moved by less than a cell border; the certificates measure what is stored.
        static constexpr double k_nudge[][2] = {
            {0.61e-6, 0.37e-6}, {-0.83e-6, 0.29e-6}, {0.17e-6, -0.91e-6}, {-0.41e-6, -0.67e-6}};
        RaySample result;
        for (const auto& nudge : k_nudge) {
            if (cast_ray(model::face_direction(face, s + nudge[0], t + nudge[1]), polys, result)) return result;
        }
        return result;
    }

    bool cast_ray(Vec3d q, const std::vector<Polygon>& polys, RaySample& result) const
    {
        std::array<std::pair<double, int>, 64> hits;
        std::size_t count = 0;
        for (const Polygon& p : polys) {
            const Sides& sides = sides_[place_of_[p.triangle]];
            const double u = dot(sides.normal[0], q), v = dot(sides.normal[1], q), w = dot(sides.normal[2], q);
            const double tiny = sides.tiny, volume = sides.volume;
            if ((u > tiny || v > tiny || w > tiny) && (u < -tiny || v < -tiny || w < -tiny)) continue;
            if (std::abs(u) <= tiny || std::abs(v) <= tiny || std::abs(w) <= tiny) return false;
            const double along = u + v + w;
            if (!((along > 0) == (volume > 0)) || volume == 0) continue;
            if (count == hits.size()) return false;
            hits[count++] = {along / volume, along > 0 ? 1 : -1};  // w = 1/rho since q has largest coordinate 1
        }
        std::sort(hits.begin(), hits.begin() + static_cast<std::ptrdiff_t>(count),
                  [](const auto& l, const auto& r) { return l.first > r.first; });
        result.valid = true;
        result.count = 0;
        int winding = out_.centre_winding;
        for (std::size_t i = 0; i < count;) {
            // Faces that lie on each other are passed at once: between them there is nothing.
            const double w = hits[i].first;
            int next = winding;
            for (; i < count && hits[i].first >= (1 - k_same_place) * w; ++i) next -= hits[i].second;
            if ((next > 0) != (winding > 0) && result.count < 16) result.w[static_cast<std::size_t>(result.count++)] = w;
            winding = next;
        }
        return true;
    }

    /// Length, in model units, that a change of w by e moves a surface with plane (w, ws, wt) at (s, t).
    double metric_deviation(int face, double s, double t, double w, double ws, double wt, double e) const
    {
        const Vec3d n = model::plane_vector(face, s, t, model::ChartPlane<double>{w, ws, wt});
        const Vec3d l{n.x / sq_.a.x, n.y / sq_.a.y, n.z / sq_.a.z};
        const double length = norm(l);
        return length > 0 ? e / (w * length) : 0;
    }

    /// Largest extent of a cell at radius 1/w, model units.
    double metric_size(int face, double size, double w) const
    {
        const int m = face >> 1;
        return size / w * std::max(sq_.a[(m + 1) % 3], sq_.a[(m + 2) % 3]);
    }

    /// Largest |w - b| over a polygon, b the bilinear form of four corner values on the unit cell. The difference is
    /// a saddle, so its extremes lie on the polygon's edges, where it is a parabola.
    static double deviation(const Polygon& p, const double c[4], double s0, double t0, double size)
    {
        const double k = c[0] - c[1] - c[2] + c[3];
        const auto difference = [&](double s, double t, double w) {
            const double u = (s - s0) / size, v = (t - t0) / size;
            return w - (c[0] + u * (c[1] - c[0]) + v * (c[2] - c[0]) + u * v * k);
        };
        double worst = 0;
        for (int i = 0; i < p.count; ++i) {
            const Stw& a = p.corner[static_cast<std::size_t>(i)];
            const Stw& b = p.corner[static_cast<std::size_t>((i + 1) % p.count)];
            const double d0 = difference(a.s, a.t, a.w), d1 = difference(b.s, b.t, b.w);
            worst = std::max(worst, std::abs(d0));
            // Along the edge: d(f) = d0 + (d1 - d0 + q) f - q f^2 with q = k du dv.
            const double q = k * (b.s - a.s) * (b.t - a.t) / (size * size);
            if (q != 0) {
                const double f = (d1 - d0 + q) / (2 * q);
                if (f > 0 && f < 1) worst = std::max(worst, std::abs(d0 + (d1 - d0 + q) * f - q * f * f));
            }
        }
        return worst;
    }

    CentralCell uniform() const { return CentralCell::uniform(out_.centre_winding > 0); }

    /// True while every cell still to come, and the quadrants of one more split a level, can have a record of its own.
    bool has_room() const { return out_.specials.size() + cells_left_ + 4 * model::k_max_split_depth < model::k_max_payload; }

    /// A layered cell of the record that comes next in the pool. False: there is no room for another.
    bool add_special(CentralCell& cell)
    {
        if (out_.specials.size() >= model::k_max_payload) return false;
        cell = CentralCell::of(CellKind::Layered, out_.specials.size());
        out_.specials.push_back(static_cast<std::uint32_t>(out_.pool.size()));
        return true;
    }

    /// One cell and everything below it. polys: footprints clipped to the cell (with a border); corner: the rays at its
    /// corners, shared with its neighbours, since a Single cell reads shared samples.
    CentralCell bake_cell(int face, double s0, double t0, double size, int depth, const std::vector<Polygon>& polys,
                          const RaySample corner[4])
    {
        bool any = false, own = false;
        for (const Polygon& p : polys) {
            any = any || !buried(p.triangle);
            own = own || (own_[p.triangle] != 0 && !buried(p.triangle));
        }
        if (!any) return uniform();
        const double tolerance = (own ? options_.tolerance : options_.foreign_tolerance) * context_.r_max;

        bool same = true;
        for (int i = 0; i < 4; ++i) same = same && corner[i].valid && corner[i].count == corner[0].count;
        double w_least = std::numeric_limits<double>::infinity();
        for (const Polygon& p : polys)
            for (int i = 0; i < p.count; ++i) w_least = std::min(w_least, p.corner[static_cast<std::size_t>(i)].w);
        const bool has_depth = depth < options_.max_depth && has_room();
        const double extent = metric_size(face, size, w_least) / context_.r_max;
        const int sheets = corner[0].count;
        CentralCell cell;
        const Sheets layers = same && sheets >= 1 && sheets <= k_max_bilinear
                                  ? measure_sheets(s0, t0, size, face, sheets, corner, polys)
                                  : Sheets{};
        // A band much wider than a crease makes is a hidden fold: as much a silhouette as a missing crossing.
        const bool folded = !layers.valid || layers.deviation > options_.silhouette * context_.r_max;
        const bool may_split = has_depth && extent > (folded ? options_.silhouette : options_.finest);
        if (layers.valid && (layers.deviation <= tolerance || !may_split)) {
            if (layers.deviation > tolerance) ++out_.rough_cells;
            if (store_sheets(layers, !own, cell)) return cell;
        }
        if (may_split && bake_split(face, s0, t0, size, depth, polys, corner, cell)) return cell;
        ++out_.rough_cells;
        return bake_mixed(face, s0, t0, size, !own, polys);
    }

    /// Bilinear surfaces through the corner crossings of a cell, with their certified deviations.
    struct Sheets {
        bool valid = false;  ///< every surface over the cell lies in one of the disjoint bands
        int count = 0;
        double deviation = 0;  ///< the widest band, as a length in model units
        std::uint16_t stored[k_max_bilinear][4];
        std::uint16_t code[k_max_bilinear];
    };

    Sheets measure_sheets(double s0, double t0, double size, int face, int sheets, const RaySample corner[4],
                          const std::vector<Polygon>& polys) const
    {
        Sheets out;
        out.count = sheets;
        double c[k_max_bilinear][4];
        for (int j = 0; j < sheets; ++j)
            for (int i = 0; i < 4; ++i) {
                out.stored[j][i] = out_.range.encode(corner[i].w[static_cast<std::size_t>(j)]);
                c[j][i] = decode(out.stored[j][i]);
            }
        double e[k_max_bilinear] = {};
        for (const Polygon& p : polys) {
            if (buried(p.triangle)) continue;
            int best = 0;
            double least = std::numeric_limits<double>::infinity();
            for (int j = 0; j < sheets; ++j) {
                const double d = deviation(p, c[j], s0, t0, size);
                if (d < least) {
                    least = d;
                    best = j;
                }
            }
            e[best] = std::max(e[best], least);
        }
        for (int j = 0; j < sheets; ++j) {
            // The runtime evaluates in float: a few parts in 10^7 of w on top.
            const double largest = std::max(std::max(c[j][0], c[j][1]), std::max(c[j][2], c[j][3]));
            const std::optional<std::uint16_t> code = deviations_.at_least(e[j] + 3e-6 * largest);
            if (!code) return out;
            out.code[j] = *code;
            e[j] = deviations_[*code];
            const double w = 0.25 * (c[j][0] + c[j][1] + c[j][2] + c[j][3]);
            const double ws = 0.5 * (c[j][1] - c[j][0] + c[j][3] - c[j][2]) / size,
                         wt = 0.5 * (c[j][2] - c[j][0] + c[j][3] - c[j][1]) / size;
            out.deviation = std::max(out.deviation, metric_deviation(face, s0 + 0.5 * size, t0 + 0.5 * size, w, ws, wt, e[j]));
        }
        for (int j = 0; j + 1 < sheets; ++j)
            for (int i = 0; i < 4; ++i)
                if (!(c[j][i] - c[j + 1][i] > e[j] + e[j + 1])) return out;
        out.valid = true;
        return out;
    }

    bool store_sheets(const Sheets& sheets, bool foreign, CentralCell& cell)
    {
        if (sheets.count == 1) {
            cell = CentralCell::single(sheets.code[0], foreign);  // its corners are shared samples
            return true;
        }
        if (!add_special(cell)) return false;
        out_.pool.push_back(LayeredHead::of_bilinear(sheets.count, foreign).word);
        for (int j = 0; j < sheets.count; ++j) {
            out_.pool.insert(out_.pool.end(), sheets.stored[j], sheets.stored[j] + 4);
            out_.pool.push_back(sheets.code[j]);
        }
        return true;
    }

    bool bake_split(int face, double s0, double t0, double size, int depth, const std::vector<Polygon>& polys,
                    const RaySample corner[4], CentralCell& cell)
    {
        const std::size_t record = out_.splits.size();
        if (record / model::k_split_size >= model::k_max_payload) return false;
        out_.splits.resize(record + model::k_split_size);
        const double half = 0.5 * size;
        RaySample rays[9];
        for (int i = 0; i < 9; ++i)
            rays[i] = i % 2 == 0 && i != 4 ? corner[i % 3 / 2 + 2 * (i / 6)]
                                           : sample(face, s0 + half * (i % 3), t0 + half * (i / 3), polys);
        std::uint16_t children[4];
        for (int q = 0; q < 4; ++q) {
            const double s = s0 + half * (q & 1), t = t0 + half * (q >> 1);
            std::vector<Polygon> inside;
            for (const Polygon& p : polys) {
                Polygon c = p;
                clip_to_cell(c, s - k_border, s + half + k_border, t - k_border, t + half + k_border);
                if (c.count > 0) inside.push_back(c);
            }
            const RaySample* r = rays + (q & 1) + 3 * (q >> 1);
            const RaySample quadrant[4] = {r[0], r[1], r[3], r[4]};
            children[q] = bake_cell(face, s, t, half, depth + 1, inside, quadrant).word;
        }
        auto stored = out_.splits.begin() + static_cast<std::ptrdiff_t>(record);
        for (const int i : model::k_split_samples) *stored++ = stored_sample(rays[i]);
        std::copy(children, children + 4, stored);
        cell = CentralCell::of(CellKind::Split, record / model::k_split_size);
        return true;
    }

    /// A cell whose rays do not all meet the same surfaces: one certified band, and planes through its middle ray.
    CentralCell bake_mixed(int face, double s0, double t0, double size, bool foreign, const std::vector<Polygon>& polys)
    {
        double lo = std::numeric_limits<double>::infinity(), hi = 0;
        for (const Polygon& p : polys) {
            if (buried(p.triangle)) continue;
            for (int i = 0; i < p.count; ++i) {
                lo = std::min(lo, p.corner[static_cast<std::size_t>(i)].w);
                hi = std::max(hi, p.corner[static_cast<std::size_t>(i)].w);
            }
        }
        // A middle ray whose point beyond the band lies in the chart's domain tells the verdict there. Where no ray
        // reaches past the band, nothing can be asked there.
        static constexpr double k_rays[][2] = {{.5, .5},   {.25, .25}, {.75, .75}, {.25, .75}, {.75, .25},
                                               {.05, .05}, {.95, .95}, {.05, .95}, {.95, .05}};
        CellRay chosen;
        for (const auto& place : k_rays) {
            const CellRay ray = cast_in_band(face, s0 + place[0] * size, t0 + place[1] * size, lo, polys);
            if (!ray.sample.valid) continue;
            const bool reaches = beyond_is_in_domain(face, ray.s, ray.t, lo * (1 - 1e-6));
            if (!chosen.sample.valid || reaches) chosen = ray;
            if (reaches) break;
        }
        const Planes first = planes_through(chosen, face, size, hi - lo, polys);
        const Division division = divide(face, s0, t0, size, lo, hi, first, polys);

        CentralCell cell;
        if (!add_special(cell)) {
            // No room for another record: the verdict of the middle ray's end would be a guess, so say so loudly.
            too_large("its central map needs more than 16384 refined cells");
        }
        const LayeredHead head = division.valid ? LayeredHead::of_divided(first.count, division.second.count, foreign)
                                                : LayeredHead::of_mixed(first.count, foreign);
        out_.pool.push_back(head.word);
        out_.pool.push_back(out_.range.encode_down(lo * (1 - 3e-6)));
        out_.pool.push_back(out_.range.encode_up(hi * (1 + 3e-6)));
        if (division.valid) out_.pool.push_back(model::border_line_word(division.from, division.to));
        store_planes(first, s0, t0, size, lo, hi);
        if (division.valid) store_planes(division.second, s0, t0, size, lo, hi);
        return cell;
    }

    /// A ray through a cell, with its crossings inside the cell's band.
    struct CellRay {
        double s = 0, t = 0;
        RaySample sample;
    };

    CellRay cast_in_band(int face, double s, double t, double lo, const std::vector<Polygon>& polys) const
    {
        CellRay ray{s, t, sample(face, s, t, polys)};
        int kept = 0;
        while (kept < ray.sample.count && ray.sample.w[static_cast<std::size_t>(kept)] >= lo * (1 - 1e-9)) ++kept;
        ray.sample.count = kept;
        return ray;
    }

    /// Planes through a ray's crossings, each w at (s, t) and its slopes.
    struct Planes {
        int count = 0;
        double s = 0, t = 0;
        std::array<double, model::k_max_sheets> w{}, ws{}, wt{};

        double at(int j, double to_s, double to_t) const
        {
            const auto i = static_cast<std::size_t>(j);
            return w[i] + (to_s - s) * ws[i] + (to_t - t) * wt[i];
        }
    };

    Planes planes_through(const CellRay& ray, int face, double size, double band, const std::vector<Polygon>& polys) const
    {
        Planes planes;
        planes.s = ray.s;
        planes.t = ray.t;
        planes.count = std::min(ray.sample.count, model::k_max_sheets);
        if ((planes.count & 1) != (ray.sample.count & 1)) --planes.count;
        for (int j = 0; j < planes.count; ++j) {
            const auto i = static_cast<std::size_t>(j);
            const double w = ray.sample.w[i];
            double ws = 0, wt = 0;
            plane_at(face, ray.s, ray.t, w, polys, ws, wt);
            // Slopes that would cross another sheet or leave the band are flattened.
            double limit = std::max(band, static_cast<double>(out_.range.w_step));
            if (j > 0) limit = std::min(limit, 0.45 * (ray.sample.w[i - 1] - w));
            if (j + 1 < ray.sample.count) limit = std::min(limit, 0.45 * (w - ray.sample.w[i + 1]));
            const double steep = (std::abs(ws) + std::abs(wt)) * 0.5 * size;
            const double flatten = steep > limit ? limit / steep : 1;
            planes.w[i] = w;
            planes.ws[i] = ws * flatten;
            planes.wt[i] = wt * flatten;
        }
        return planes;
    }

    /// Planes are stored at the middle of the cell.
    void store_planes(const Planes& planes, double s0, double t0, double size, double lo, double hi)
    {
        const double reach = 0.5 * size;
        for (int j = 0; j < planes.count; ++j) {
            out_.pool.push_back(out_.range.encode(std::clamp(planes.at(j, s0 + reach, t0 + reach), lo, hi)));
            out_.pool.push_back(out_.range.encode_slope(planes.ws[static_cast<std::size_t>(j)] * reach));
            out_.pool.push_back(out_.range.encode_slope(planes.wt[static_cast<std::size_t>(j)] * reach));
        }
    }

    /// How far, as radii in the chart, planes are from what a ray meets: the way from every crossing to the nearest plane
    /// and from every plane to the nearest crossing, whole: where there is none.
    static double misfit(const Planes& planes, const CellRay& ray, double whole)
    {
        const RaySample& r = ray.sample;
        double sum = 0;
        for (int i = 0; i < r.count; ++i) {
            double least = whole;
            for (int j = 0; j < planes.count; ++j)
                least = std::min(least, std::abs(1 / planes.at(j, ray.s, ray.t) - 1 / r.w[static_cast<std::size_t>(i)]));
            sum += least;
        }
        for (int j = 0; j < planes.count; ++j) {
            double least = whole;
            for (int i = 0; i < r.count; ++i)
                least = std::min(least, std::abs(1 / planes.at(j, ray.s, ray.t) - 1 / r.w[static_cast<std::size_t>(i)]));
            sum += least;
        }
        return sum;
    }

    /// A line across a mixed cell, and the planes on the other side of it.
    struct Division {
        bool valid = false;
        std::uint32_t from = 0, to = 0;  ///< codes of border points; the first planes hold left of the way between them
        Planes second;
    };

    /// Looks for the silhouette that makes a cell mixed: a lattice of rays is told apart by whether the planes of the
    /// first ray or those of the ray that they fit worst describe it better; the line goes through two places where the
    /// answer changes along the border.
    Division divide(int face, double s0, double t0, double size, double lo, double hi, const Planes& first,
                    const std::vector<Polygon>& polys) const
    {
        constexpr int k_side = 4, k_count = (k_side + 1) * (k_side + 1), k_ring = 4 * k_side;
        const double whole = 1 / lo - 1 / hi;
        std::array<CellRay, k_count> rays;
        std::array<double, k_count> with_first{}, with_second{};
        double undivided = 0;
        std::size_t worst = 0;
        for (std::size_t i = 0; i < k_count; ++i) {
            rays[i] = cast_in_band(face, s0 + size * static_cast<double>(i % (k_side + 1)) / k_side,
                                   t0 + size * static_cast<double>(i / (k_side + 1)) / k_side, lo, polys);
            if (!rays[i].sample.valid) continue;
            with_first[i] = misfit(first, rays[i], whole);
            undivided += with_first[i];
            if (with_first[i] > with_first[worst]) worst = i;
        }
        Division best;
        if (!(undivided > 0)) return best;
        // Twice: the second time through the ray in the middle of those that the first attempt won.
        std::array<bool, k_count> other{};
        std::size_t through = worst;
        for (int pass = 0; pass < 2; ++pass) {
            best.second = planes_through(rays[through], face, size, hi - lo, polys);
            double s = 0, t = 0, n = 0;
            for (std::size_t i = 0; i < k_count; ++i) {
                with_second[i] = rays[i].sample.valid ? misfit(best.second, rays[i], whole) : 0;
                other[i] = with_second[i] < with_first[i];
                if (!other[i]) continue;
                s += rays[i].s;
                t += rays[i].t;
                n += 1;
            }
            double nearest = std::numeric_limits<double>::infinity();
            for (std::size_t i = 0; i < k_count; ++i) {
                const double d = std::hypot(rays[i].s - s / n, rays[i].t - t / n);
                if (!other[i] || !(d < nearest)) continue;
                nearest = d;
                through = i;
            }
        }
        const auto on_ring = [](int k) {
            const int along = k % k_side;
            constexpr int k_row = k_side + 1;
            switch (k / k_side % 4) {
                case 0:
                    return static_cast<std::size_t>(along);
                case 1:
                    return static_cast<std::size_t>(k_side + along * k_row);
                case 2:
                    return static_cast<std::size_t>(k_side * k_row + k_side - along);
                default:
                    return static_cast<std::size_t>((k_side - along) * k_row);
            }
        };
        std::array<std::uint32_t, k_ring> changes{};
        std::size_t change_count = 0;
        for (int k = 0; k < k_ring; ++k) {
            const bool before = other[on_ring(k)];
            if (before == other[on_ring((k + 1) % k_ring)]) continue;
            constexpr std::uint32_t k_step = 256 / k_ring;
            std::uint32_t least = static_cast<std::uint32_t>(k) * k_step, most = least + k_step;
            while (most - least > 2) {
                const std::uint32_t middle = (least + most) / 2;
                const model::BorderPoint p = model::border_point(middle);
                const CellRay ray =
                    cast_in_band(face, s0 + size * static_cast<double>(p.u), t0 + size * static_cast<double>(p.v), lo, polys);
                const bool here = misfit(best.second, ray, whole) < misfit(first, ray, whole);
                (here == before ? least : most) = middle;
            }
            changes[change_count++] = ((least + most) / 2) & 255u;
        }
        const double worthwhile = options_.division * context_.r_max * k_count / std::max({sq_.a.x, sq_.a.y, sq_.a.z});
        double least = std::min(k_division_share * undivided, undivided - worthwhile);
        for (std::size_t i = 0; i < change_count; ++i)
            for (std::size_t j = 0; j < change_count; ++j) {
                if (i == j) continue;
                const model::BorderPoint from = model::border_point(changes[i]), to = model::border_point(changes[j]);
                double sum = 0;
                for (std::size_t k = 0; k < k_count; ++k) {
                    const double u = (rays[k].s - s0) / size, v = (rays[k].t - t0) / size;
                    const auto du = static_cast<double>(to.u - from.u), dv = static_cast<double>(to.v - from.v);
                    const bool left = du * (v - static_cast<double>(from.v)) - dv * (u - static_cast<double>(from.u)) >= 0;
                    sum += left ? with_first[k] : with_second[k];
                }
                if (!(sum < least)) continue;
                least = sum;
                best.valid = true;
                best.from = changes[i];
                best.to = changes[j];
            }
        return best;
    }

    /// Slopes of the triangle that crosses the ray (s, t) at w.
    void plane_at(int face, double s, double t, double w, const std::vector<Polygon>& polys, double& ws, double& wt) const
    {
        const int m = face >> 1;
        double least = std::numeric_limits<double>::infinity();
        for (const Polygon& p : polys) {
            const mesh::Triangle& tri = context_.mesh.triangles[p.triangle];
            const Vec3d a = x_[tri[0]], n = cross(x_[tri[1]] - a, x_[tri[2]] - a);
            const double d = dot(n, a);
            if (std::abs(d) < 1e-12) continue;
            const double fs = n[(m + 1) % 3] / d, ft = n[(m + 2) % 3] / d;
            const double at = model::face_sign<double>(face) * n[m] / d + fs * s + ft * t;
            double near = std::abs(at - w);
            // Planes agree only where the triangle itself is near the ray.
            {
                double lo_s = 2, hi_s = -2, lo_t = 2, hi_t = -2;
                for (int k = 0; k < p.count; ++k) {
                    lo_s = std::min(lo_s, p.corner[static_cast<std::size_t>(k)].s);
                    hi_s = std::max(hi_s, p.corner[static_cast<std::size_t>(k)].s);
                    lo_t = std::min(lo_t, p.corner[static_cast<std::size_t>(k)].t);
                    hi_t = std::max(hi_t, p.corner[static_cast<std::size_t>(k)].t);
                }
                near += w * (std::max({lo_s - s, 0.0, s - hi_s}) + std::max({lo_t - t, 0.0, t - hi_t}));
            }
            if (near < least) {
                least = near;
                ws = fs;
                wt = ft;
            }
        }
    }

    bool beyond_is_in_domain(int face, double s, double t, double w) const
    {
        const Vec3d x = model::face_direction(face, s, t) / w;
        for (std::size_t k = 0; k < 9; ++k)
            if (model::domain_coordinate(x, k) < out_.domain.lo[k] || model::domain_coordinate(x, k) > out_.domain.hi[k])
                return false;
        return true;
    }

    /// False: given up, since it takes more than so many bytes.
    bool bake_faces(std::size_t max_bytes)
    {
        const auto n = static_cast<int>(base_);
        const double size = 2.0 / n;
        const int blocks = n / model::k_block;
        cells_left_ = model::k_faces * base_ * base_;
        for (int face = 0; face < model::k_faces; ++face) {
            std::vector<std::vector<Polygon>> bins(static_cast<std::size_t>(n * n));
            const Reached reached = reached_cells(face, size, n);
            for (const Polygon& p : polygons_[static_cast<std::size_t>(face)]) bin(p, size, n, reached.listed, bins);
            std::vector<RaySample> rays;
            const auto is_anew = [&](int row, int column) {
                return row >= 0 && column >= 0 && row < n && column < n &&
                       reached.anew[static_cast<std::size_t>(row * n + column)] != 0;
            };
            for (int row = 0; row <= n; ++row)
                for (int column = 0; column <= n; ++column) {
                    if (!is_anew(row, column) && !is_anew(row - 1, column) && !is_anew(row, column - 1) &&
                        !is_anew(row - 1, column - 1)) {
                        rays.emplace_back();
                        out_.samples.push_back(known_->model.samples[known_->part.first_sample + out_.samples.size()]);
                        continue;
                    }
                    // All four cells around: a surface that leaves the chart's domain may be listed in one of them only.
                    std::vector<Polygon> polys;
                    for (int q = 0; q < 4; ++q) {
                        const int r = row - (q >> 1), c = column - (q & 1);
                        if (r < 0 || c < 0 || r >= n || c >= n) continue;
                        for (const Polygon& p : bins[static_cast<std::size_t>(r * n + c)])
                            if (std::none_of(polys.begin(), polys.end(),
                                             [&](const Polygon& o) { return o.triangle == p.triangle; }))
                                polys.push_back(p);
                    }
                    rays.push_back(sample(face, -1 + size * column, -1 + size * row, polys));
                    out_.samples.push_back(stored_sample(rays.back()));
                }
            std::vector<model::Block> pyramid(static_cast<std::size_t>(blocks * blocks), model::k_empty_block);
            std::vector<std::uint8_t> block_is_anew(pyramid.size(), 0);
            for (int row = 0; row < n; ++row) {
                for (int column = 0; column < n; ++column) {
                    const auto& polys = bins[static_cast<std::size_t>(row * n + column)];
                    --cells_left_;
                    if (is_anew(row, column)) {
                        const RaySample* r = rays.data() + row * (n + 1) + column;
                        const RaySample corner[4] = {r[0], r[1], r[n + 1], r[n + 2]};
                        out_.cells.push_back(bake_cell(face, -1 + size * column, -1 + size * row, size, 0, polys, corner).word);
                    } else {
                        CentralCell cell;
                        if (!keep_cell({known_->model.cells[known_->part.first_cell + out_.cells.size()]}, cell)) return false;
                        out_.cells.push_back(cell.word);
                    }
                    const auto at = static_cast<std::size_t>((row / model::k_block) * blocks + column / model::k_block);
                    if (is_anew(row, column)) block_is_anew[at] = 1;
                    for (const Polygon& p : polys) {
                        if (buried(p.triangle) || own_[p.triangle] == 0) continue;
                        for (int i = 0; i < p.count; ++i) {
                            pyramid[at].lo =
                                std::min(pyramid[at].lo, out_.range.encode_down(p.corner[static_cast<std::size_t>(i)].w));
                            pyramid[at].hi =
                                std::max(pyramid[at].hi, out_.range.encode_up(p.corner[static_cast<std::size_t>(i)].w));
                        }
                    }
                }
                if (out_.map_bytes() > max_bytes) return false;
            }
            for (std::size_t i = 0; i < pyramid.size(); ++i)
                out_.blocks.push_back(
                    block_is_anew[i] != 0 ? pyramid[i] : known_->model.blocks[known_->part.first_block + out_.blocks.size()]);
        }
        return out_.map_bytes() <= max_bytes;
    }

    /// w of a base sample, or 0 where its ray meets no surface.
    double base_w(int face, int row, int column) const
    {
        const auto n = static_cast<int>(base_);
        if (row < 0 || column < 0 || row > n || column > n) return 0;
        const std::uint16_t v = out_.samples[static_cast<std::size_t>((face * (n + 1) + row) * (n + 1) + column)];
        return v == model::k_no_surface ? 0 : decode(v);
    }

    /// Distance of the surface below the superquadric along a base sample's ray (Fig. 4c), model units.
    double distance_below(int face, int row, int column, double w) const
    {
        const double size = 2.0 / base_;
        const Vec3d q = model::face_direction(face, -1 + size * column, -1 + size * row);
        const Vec3d way = transpose_mul(sq_.rotation, Vec3d{sq_.a.x * q.x, sq_.a.y * q.y, sq_.a.z * q.z});
        // Its root grows with the distance from the centre, nearly straight: Illinois' rule (Dowell and Jarratt 1971).
        const auto excess = [&](double t) { return std::sqrt(shape::implicit(sq_, centre_ + t * way)) - 1; };
        double lo = 1 / w, hi = lo, at_lo = excess(lo), at_hi = at_lo;
        for (int i = 0; i < 40 && at_hi <= 0; ++i) at_hi = excess(hi *= 1.25);
        int last = 0;
        for (int i = 0; i < 24 && at_lo <= 0 && hi - lo > 1e-8 * hi; ++i) {
            const double middle = (lo * at_hi - hi * at_lo) / (at_hi - at_lo), at = excess(middle);
            if (at <= 0) {
                if (last < 0) at_hi *= 0.5;
                lo = middle;
                at_lo = at;
                last = -1;
            } else {
                if (last > 0) at_lo *= 0.5;
                hi = middle;
                at_hi = at;
                last = 1;
            }
            if (std::abs(at) < 1e-9) break;
        }
        return (lo - 1 / w) * norm(way);
    }

    /// Eq. 12, corrected: where the distance map has a local minimum the surface may stick into a face of a probe whose
    /// corners are all outside. The gradient vanishes at a smooth minimum, so the largest slope of the ring around it
    /// is taken. delta = a_N d |grad D| = a_N |D(neighbour) - D|.
    void bake_offsets()
    {
        const auto n = static_cast<int>(base_);
        std::vector<double> delta(out_.samples.size(), 0.0);
        double largest = 0;
        std::size_t index = 0;
        for (int face = 0; face < model::k_faces; ++face) {
            std::vector<double> d(static_cast<std::size_t>((n + 1) * (n + 1)), -1.0);
            for (int row = 0; row <= n; ++row)
                for (int column = 0; column <= n; ++column)
                    if (const double w = base_w(face, row, column); w > 0)
                        d[static_cast<std::size_t>(row * (n + 1) + column)] = distance_below(face, row, column, w);
            for (int row = 0; row <= n; ++row)
                for (int column = 0; column <= n; ++column, ++index) {
                    const double here = d[static_cast<std::size_t>(row * (n + 1) + column)];
                    if (here < 0) continue;
                    double rise = 0;
                    bool minimum = true;
                    for (int dr = -1; dr <= 1; ++dr)
                        for (int dc = -1; dc <= 1; ++dc) {
                            const int r = row + dr, c = column + dc;
                            if ((dr == 0 && dc == 0) || r < 0 || c < 0 || r > n || c > n) continue;
                            const double there = d[static_cast<std::size_t>(r * (n + 1) + c)];
                            if (there < 0) continue;
                            minimum = minimum && there >= here;
                            rise = std::max(rise, there - here);
                        }
                    if (minimum) delta[index] = std::min(options_.offset_constant * rise, 0.02 * context_.r_max);
                    largest = std::max(largest, delta[index]);
                }
        }
        out_.offset_step = model::offset_step(largest);
        for (const double v : delta) out_.offsets.push_back(model::encode_offset(v, out_.offset_step));
    }

    /// The map convolved with a binomial kernel on each face, less the map. Rays without surface take no part.
    void bake_smoothing()
    {
        const auto n = static_cast<int>(base_);
        const int radius = options_.smoothing_radius;
        std::vector<double> change;
        double largest = 0;
        for (int face = 0; face < model::k_faces; ++face)
            for (int row = 0; row <= n; ++row)
                for (int column = 0; column <= n; ++column) {
                    const double here = base_w(face, row, column);
                    double sum = 0, weight = 0;
                    for (int dr = -radius; dr <= radius; ++dr)
                        for (int dc = -radius; dc <= radius; ++dc) {
                            const double there = base_w(face, row + dr, column + dc);
                            if (!(there > 0) || !(here > 0) || std::abs(there - here) > 0.25 * here) continue;
                            const double k = std::ldexp(1.0, -std::abs(dr) - std::abs(dc));
                            sum += k * there;
                            weight += k;
                        }
                    change.push_back(weight > 0 ? sum / weight - here : 0);
                    largest = std::max(largest, std::abs(change.back()));
                }
        out_.smoothing_step = model::smoothing_step(largest);
        for (const double v : change) out_.smoothing.push_back(model::encode_smoothing(v, out_.smoothing_step));
    }

    /// Into the cells that are listed.
    static void bin(const Polygon& p, double size, int n, const std::vector<std::uint8_t>& listed,
                    std::vector<std::vector<Polygon>>& bins)
    {
        double lo_t = 2, hi_t = -2;
        for (int i = 0; i < p.count; ++i) {
            lo_t = std::min(lo_t, p.corner[static_cast<std::size_t>(i)].t);
            hi_t = std::max(hi_t, p.corner[static_cast<std::size_t>(i)].t);
        }
        const auto cell = [&](double v) { return std::clamp(static_cast<int>(std::floor((v + 1) / size)), 0, n - 1); };
        for (int row = cell(lo_t - k_border); row <= cell(hi_t + k_border); ++row) {
            const auto first = listed.begin() + static_cast<std::ptrdiff_t>(row * n);
            if (std::find(first, first + n, 1) == first + n) continue;
            Polygon strip = p;
            clip_to_cell(strip, -2, 2, -1 + size * row - k_border, -1 + size * (row + 1) + k_border);
            if (strip.count == 0) continue;
            double lo_s = 2, hi_s = -2;
            for (int i = 0; i < strip.count; ++i) {
                lo_s = std::min(lo_s, strip.corner[static_cast<std::size_t>(i)].s);
                hi_s = std::max(hi_s, strip.corner[static_cast<std::size_t>(i)].s);
            }
            for (int column = cell(lo_s - k_border); column <= cell(hi_s + k_border); ++column) {
                if (listed[static_cast<std::size_t>(row * n + column)] == 0) continue;
                Polygon c = strip;
                clip_to_cell(c, -1 + size * column - k_border, -1 + size * (column + 1) + k_border, -2, 2);
                if (c.count > 0) bins[static_cast<std::size_t>(row * n + column)].push_back(c);
            }
        }
    }

    const SurfaceContext& context_;
    shape::Superquadricd sq_;
    CentralOptions options_;
    std::uint32_t base_ = 0;
    CentralMapData out_;
    Vec3d centre_;
    Mat3d rows_;
    std::vector<std::uint8_t> own_;  ///< #triangles
    std::vector<Vec3d> x_;
    std::vector<Sides> sides_;             ///< of triangles in the domain
    std::vector<std::uint32_t> place_of_;  ///< #triangles, in sides_
    Faces polygons_, changed_;             ///< footprints of all triangles; of the known map's changed ones, then and now
    const KnownMap* known_ = nullptr;      ///< while it is followed
    double least_w_ = 1, max_w_ = 1;       ///< of all footprints
    model::DeviationCodes deviations_{0};
    std::vector<Vec3d> scratch_;
    std::size_t cells_left_ = 0;  ///< base cells not baked yet
};

}  // namespace

CentralMapData bake_central_map(const SurfaceContext& context, const shape::Superquadricd& superquadric, Vec3f centre,
                                const ChartDomain& domain, std::span<const std::uint32_t> own_triangles,
                                const CentralOptions& options, const KnownMap* known)
{
    return Baker(context, superquadric, centre, domain, own_triangles, options).run(known);
}

}  // namespace sqmap::bake
