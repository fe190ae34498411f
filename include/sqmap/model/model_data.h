// A model as owned arrays: what bake makes and io writes. The runtime never uses it.
#pragma once

#include "sqmap/model/model.h"

#include <string>
#include <vector>

namespace sqmap::model {

/// Figures measured on a finished model, lengths in percent of R_max (see eval.h for what each means).
struct Measured {
    std::uint32_t points = 0;
    std::uint32_t missed = 0, false_contacts = 0;  ///< layer 3, farther than 0.5 % of R_max from the surface
    double eq35_mean = 0, eq35_p99 = 0, eq35_max = 0;
    double depth_median = 0, depth_p95 = 0, depth_p99 = 0, depth_max = 0;
    double normal_median = 0;  ///< degrees
    double q2_share = 0;       ///< percent of the surface that its part's projection does not see first
};

struct ModelData {
    Header header{};
    std::vector<Part> parts;
    std::vector<std::uint16_t> samples, cells;
    std::vector<std::uint8_t> offsets;
    std::vector<std::int8_t> smoothing;
    std::vector<Block> blocks;
    std::vector<std::uint16_t> splits;
    std::vector<std::uint32_t> specials;
    std::vector<std::uint16_t> pool;
    std::vector<std::uint32_t> rows;
    std::vector<std::uint16_t> starts, refs;
    std::vector<std::uint32_t> locals;
    std::vector<float> vertices;
    std::vector<std::uint16_t> triangles16;
    std::vector<std::uint32_t> triangles32;
    std::vector<std::uint16_t> triangle_part;
    // Normal maps, one a part, or none.
    std::vector<NormalPart> normal_parts;
    std::vector<std::uint16_t> normal_distance, normal_normal;
    std::vector<std::uint8_t> normal_cuts, normal_offset;
    std::vector<std::uint32_t> correction_rows, gap_rows;
    std::vector<VertexCorrection> corrections;
    std::vector<MapGap> gaps;
    std::vector<FootSeed> seeds;
    Locator locator{};
    std::vector<std::uint32_t> bricks, places, part_lists, locator_seeds;
    std::vector<std::uint8_t> seed_reaches;

    Measured measured;
    std::string made_by, source, options;

    [[nodiscard]] ModelView view() const
    {
        return {header,
                parts,
                samples,
                offsets,
                smoothing,
                cells,
                blocks,
                splits,
                specials,
                pool,
                rows,
                starts,
                refs,
                locals,
                vertices,
                triangles16,
                triangles32,
                triangle_part,
                {normal_parts, normal_distance, normal_normal, normal_cuts, normal_offset, correction_rows, gap_rows, corrections,
                 gaps, seeds},
                locator,
                bricks,
                places,
                part_lists,
                locator_seeds,
                seed_reaches};
    }
};

}  // namespace sqmap::model
