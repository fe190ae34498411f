// A model as owned arrays: what bake makes and io writes. The runtime never uses it.
#pragma once

#include "sqmap/model/model.h"

#include <string>
#include <vector>

namespace sqmap::model {

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
    std::vector<float> vertices;
    std::vector<std::uint16_t> triangles16;
    std::vector<std::uint32_t> triangles32;
    std::vector<std::uint16_t> triangle_part;
    std::vector<std::uint32_t> piece_triangle;
    std::vector<float> pieces;
    // Normal maps, one a part, or none.
    std::vector<NormalPart> normal_parts;
    std::vector<std::uint16_t> normal_distance, normal_normal;
    std::vector<std::uint8_t> normal_cuts, normal_offset;
    std::vector<std::uint32_t> correction_rows, gap_rows;
    std::vector<VertexCorrection> corrections;
    std::vector<MapGap> gaps;
    std::vector<FootSeed> seeds;
    std::vector<SmoothedSample> normal_smoothed;
    Locator locator{};
    std::vector<std::uint32_t> bricks, places, part_lists, planes;
    std::vector<Seed> locator_seeds;
    std::vector<std::uint32_t> near_bricks;
    std::vector<std::uint16_t> near;
    std::vector<std::uint8_t> rises;

    Measured measured;
    std::string made_by, source, options;
    std::uint64_t mesh_hash = 0;

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
                vertices,
                triangles16,
                triangles32,
                triangle_part,
                piece_triangle,
                pieces,
                {normal_parts, normal_distance, normal_normal, normal_cuts, normal_offset, correction_rows, gap_rows, corrections,
                 gaps, seeds, normal_smoothed},
                locator,
                bricks,
                places,
                part_lists,
                planes,
                locator_seeds,
                near_bricks,
                near,
                rises,
                measured,
                made_by,
                source,
                options,
                mesh_hash};
    }
};

}  // namespace sqmap::model
