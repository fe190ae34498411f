// The central map: conservative rasterisation of the mesh's triangles onto a cube of directions, where straight edges
// stay straight and planes stay linear in w = 1/rho, so that every deviation below is exact up to rounding.
#include "central_map.h"

#include "bake/central/cells.h"
#include "bake/central/offsets_and_smoothing.h"
#include "bake/central/project.h"
#include "bake/central/update.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

namespace sqmap::bake {

namespace {

using Bins = std::vector<std::vector<Polygon>>;  // #cells of a face: footprints, clipped to each with a border

/// Puts a footprint into the cells that are listed.
void bin(const Polygon& p, const ReachedCells& cells, Bins& bins)
{
    const int n = cells.side;
    const double size = 2.0 / n;
    const auto cell = [&](double v) { return std::clamp(static_cast<int>(std::floor((v + 1) / size)), 0, n - 1); };
    const Extent whole = extent_of(p);
    for (int row = cell(whole.lo_t - k_cell_border); row <= cell(whole.hi_t + k_cell_border); ++row) {
        const auto first = cells.listed.begin() + static_cast<std::ptrdiff_t>(row * n);
        if (std::find(first, first + n, 1) == first + n) continue;
        Polygon strip = p;
        clip_to_cell(strip, -2, 2, -1 + size * row - k_cell_border, -1 + size * (row + 1) + k_cell_border);
        if (strip.count == 0) continue;
        const Extent e = extent_of(strip);
        for (int column = cell(e.lo_s - k_cell_border); column <= cell(e.hi_s + k_cell_border); ++column) {
            if (cells.listed[static_cast<std::size_t>(row * n + column)] == 0) continue;
            Polygon c = strip;
            clip_to_cell(c, -1 + size * column - k_cell_border, -1 + size * (column + 1) + k_cell_border, -2, 2);
            if (c.count > 0) bins[static_cast<std::size_t>(row * n + column)].push_back(c);
        }
    }
}

/// The input from which maps of several bases are baked.
struct MapInput {
    MapInput(const Projection& from, const CentralOptions& o, double w_step)
        : projection(from), options(o), mixed(from, o, w_step)
    {
    }

    const Projection& projection;
    const CentralOptions& options;
    MixedCells mixed;
};

/// Bakes a map's faces, one after another. known: what may be taken over, or null.
class FaceBaker {
public:
    FaceBaker(MapInput& input, const KnownCells* known, CentralMapData& map)
        : projection_(input.projection),
          known_(known),
          map_(map),
          cells_(input.projection, input.options, input.mixed, map),
          side_(static_cast<int>(map.base)),
          size_(2.0 / side_),
          cells_left_(model::k_faces * static_cast<std::size_t>(side_ * side_)),
          listed_at_(projection_.solid().mesh().triangles.size(), 0)
    {
    }

    /// False: given up, since the map takes more than so many bytes or is full where it may not be, or what is taken over has no
    /// room.
    bool run(std::size_t max_bytes, bool may_be_full = true)
    {
        may_be_full_ = may_be_full;
        for (int number = 0; number < model::k_faces; ++number) {
            Face face{number, known_ != nullptr ? known_->reached(number) : all_cells(side_), {}, {}};
            face.bins.resize(static_cast<std::size_t>(side_ * side_));
            for (const Polygon& p : projection_.footprints()[static_cast<std::size_t>(number)]) bin(p, face.reached, face.bins);
            add_samples(face);
            const std::vector<model::Block> blocks = blocks_of(face);
            if (!add_cells(face, max_bytes)) return false;
            map_.blocks.insert(map_.blocks.end(), blocks.begin(), blocks.end());
        }
        return map_.map_bytes() <= max_bytes;
    }

private:
    struct Face {
        int number;
        ReachedCells reached;
        Bins bins;
        std::vector<RaySample> rays;  ///< #samples; of those that are taken over, none
    };

    /// Base samples of a face, and the rays of those that are cast.
    void add_samples(Face& face)
    {
        const ReachedCells& reached = face.reached;
        for (int row = 0; row <= side_; ++row)
            for (int column = 0; column <= side_; ++column) {
                if (!reached.is_anew(row, column) && !reached.is_anew(row - 1, column) && !reached.is_anew(row, column - 1) &&
                    !reached.is_anew(row - 1, column - 1)) {
                    face.rays.emplace_back();
                    map_.samples.push_back(known_->sample(map_.samples.size()));
                    continue;
                }
                // All four cells around: a surface that leaves the chart's domain may be listed in one of them only.
                near_.clear();
                ++sample_;
                for (int q = 0; q < 4; ++q) {
                    const int r = row - (q >> 1), c = column - (q & 1);
                    if (r < 0 || c < 0 || r >= side_ || c >= side_) continue;
                    for (const Polygon& p : face.bins[static_cast<std::size_t>(r * side_ + c)])
                        if (std::exchange(listed_at_[p.triangle], sample_) != sample_) near_.push_back(&p);
                }
                face.rays.push_back(projection_.crossings({face.number, -1 + size_ * column, -1 + size_ * row}, near_));
                map_.samples.push_back(stored_sample(face.rays.back(), map_.range));
            }
    }

    /// The pyramid over a face's cells: bounds of the part's own surface.
    std::vector<model::Block> blocks_of(const Face& face) const
    {
        const int along = side_ / model::k_block;
        std::vector<model::Block> blocks(static_cast<std::size_t>(along * along), model::k_empty_block);
        std::vector<std::uint8_t> is_anew(blocks.size(), 0);
        for (int row = 0; row < side_; ++row)
            for (int column = 0; column < side_; ++column) {
                const auto at = static_cast<std::size_t>((row / model::k_block) * along + column / model::k_block);
                if (face.reached.is_anew(row, column)) is_anew[at] = 1;
                for (const Polygon& p : face.bins[static_cast<std::size_t>(row * side_ + column)]) {
                    if (!projection_.is_own(p.triangle)) continue;
                    for (int i = 0; i < p.count; ++i) {
                        const double w = p.corner[static_cast<std::size_t>(i)].w;
                        blocks[at].lo = std::min(blocks[at].lo, map_.range.encode_down(w));
                        blocks[at].hi = std::max(blocks[at].hi, map_.range.encode_up(w));
                    }
                }
            }
        for (std::size_t i = 0; i < blocks.size(); ++i)
            if (is_anew[i] == 0) blocks[i] = known_->block(map_.blocks.size() + i);
        return blocks;
    }

    /// False: the map takes more than so many bytes, or what is taken over has no room. Takes the face's bins.
    bool add_cells(Face& face, std::size_t max_bytes)
    {
        for (int row = 0; row < side_; ++row) {
            for (int column = 0; column < side_; ++column) {
                --cells_left_;
                if (!face.reached.is_anew(row, column)) {
                    const std::optional<model::CentralCell> kept = known_->cell(map_.cells.size(), map_);
                    if (!kept) return false;
                    map_.cells.push_back(kept->word);
                    continue;
                }
                const RaySample* r = face.rays.data() + row * (side_ + 1) + column;
                const CellSquare square{face.number, -1 + size_ * column, -1 + size_ * row, size_};
                Cell cell{square,
                          0,
                          cells_left_,
                          std::move(face.bins[static_cast<std::size_t>(row * side_ + column)]),
                          {r[0], r[1], r[side_ + 1], r[side_ + 2]}};
                map_.cells.push_back(cells_.bake(cell).word);
            }
            if (map_.map_bytes() > max_bytes || (map_.is_full && !may_be_full_)) return false;
        }
        return true;
    }

    const Projection& projection_;
    const KnownCells* known_;
    CentralMapData& map_;
    CentralCellBaker cells_;
    int side_;
    double size_;
    bool may_be_full_ = true;
    std::size_t cells_left_;                ///< base cells not baked yet
    std::vector<const Polygon*> near_;      ///< of one sample, each triangle once
    std::vector<std::uint32_t> listed_at_;  ///< #triangles: the last sample that it was listed at
    std::uint32_t sample_ = 0;
};

/// The map before its range is chosen.
CentralMapData blank_map(const Projection& projection)
{
    CentralMapData map;
    map.centre = projection.chart().centre;
    map.centre_winding = projection.centre_winding();
    map.domain = projection.chart().domain;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) map.chart_rows[3 * i + j] = static_cast<float>(projection.rows().row[i][j]);
    return map;
}

void set_range(const Projection& projection, model::SampleRange range, CentralMapData& map)
{
    const Vec3d axes = projection.chart().superquadric.a;
    map.range = range;
    // d rho = dw / w^2, largest where w is least, in the longest axis.
    map.quantisation = 0.5 * range.w_step / (projection.least_w() * projection.least_w()) * std::max({axes.x, axes.y, axes.z});
}

/// The cheapest resolution: too coarse a base is split everywhere, too fine a one stores needless samples. A map that is full
/// takes fewer bytes for what it leaves out, so it is none beside one that is not, and finer bases would be full too.
CentralMapData best_map(const Projection& projection, const CentralOptions& options)
{
    CentralMapData blank = blank_map(projection);
    set_range(projection, model::SampleRange::around(projection.least_w(), projection.max_w()), blank);
    MapInput input(projection, options, static_cast<double>(blank.range.w_step));
    CentralMapData best;
    std::size_t best_bytes = std::numeric_limits<std::size_t>::max() / 2;
    for (const std::uint32_t base : {4u, 6u, 8u, 12u, 16u, 24u, 32u}) {
        if (base < options.least_base || base > options.max_base) continue;
        CentralMapData map = blank;
        map.base = base;
        const bool has_one = best.base != 0;
        if (!FaceBaker(input, nullptr, map).run(best_bytes + best_bytes / 4, !has_one || best.is_full)) break;
        if (const std::size_t bytes = map.map_bytes(); bytes <= best_bytes) {
            best_bytes = bytes;
            best = std::move(map);
        }
    }
    return best;
}

/// Takes over all cells that no changed triangle reaches. Returns nothing where the map has to be made anew.
std::optional<CentralMapData> followed_map(const Projection& projection, const CentralOptions& options, const KnownMap& known)
{
    const model::SampleRange range{known.part.w_min, known.part.w_step};
    if (known.part.centre_winding != projection.centre_winding() || !range.holds(projection.least_w(), projection.max_w()))
        return std::nullopt;
    CentralMapData map = blank_map(projection);
    set_range(projection, range, map);
    map.base = known.part.base;
    const KnownCells cells(known, projection);
    MapInput input(projection, options, static_cast<double>(range.w_step));
    if (!FaceBaker(input, &cells, map).run(std::numeric_limits<std::size_t>::max())) return std::nullopt;
    return map;
}

}  // namespace

CentralMapData bake_central_map(const mesh::Solid& solid, const PartChart& chart, const CentralOptions& options,
                                const KnownMap* known)
{
    const Projection projection(solid, chart);
    std::optional<CentralMapData> followed;
    if (known != nullptr) followed = followed_map(projection, options, *known);
    CentralMapData map = followed ? std::move(*followed) : best_map(projection, options);
    add_offsets(projection, options, map);
    add_smoothing(options.smoothing_radius, map);
    return map;
}

}  // namespace sqmap::bake
