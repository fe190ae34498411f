// Handling of a garment while it is worn: seams cut and sewn, points pinned, cloth pulled by a tool.
#pragma once

#include "common/dress/garment_file.h"
#include "common/dress/tool.h"

#include <nlohmann/json.hpp>

#include <functional>
#include <memory>
#include <string>

namespace sqmap::app {

/// The number of the solid or joint of that name; sim::Cloth::k_world for "world". @throw GarmentFileError for any other
using FindBone = std::function<std::uint32_t(const std::string&)>;

/// The vertex nearest to a position.
[[nodiscard]] std::uint32_t nearest_vertex(const sim::Cloth& cloth, Vec3d position);

/// A garment's events as its file lists them, step by step. A pull is a tool's tip that goes its way at 1 kHz, of the cloth's
/// own time, in front of a safety filter; it hovers where it will grasp for what the filter's ramp takes.
class Handling {
public:
    /// solids: as they are at first; their models outlive this. @throw GarmentFileError for a bone that is not there
    Handling(const GarmentFile& file, const std::string& name, std::span<const sim::Collider> solids, const FindBone& bone);

    /// Before the cloth's step that ends at time, dt seconds long.
    void before(sim::Cloth& cloth, double time, double dt, std::span<const sim::Collider> solids);

    /// One object a pull: the nodes it took, and the tool's forces against cloth and body.
    [[nodiscard]] const nlohmann::json& pulls() const { return pulls_; }
    /// Events that the file lists for later than the garment was worn, in words.
    [[nodiscard]] std::vector<std::string> never_came(double until) const;

private:
    void pull(sim::Cloth& cloth, const Pull& p, double time, double dt, std::span<const sim::Collider> solids);

    const GarmentFile* file_;
    std::vector<std::uint32_t> bones_;                ///< of the pins
    std::vector<std::vector<std::uint32_t>> pinned_;  ///< vertices of each
    std::unique_ptr<ClothTool> tool_;
    std::unique_ptr<haptic::SafetyFilter> filter_;
    std::uint64_t sequence_ = 0;
    const Pull* holding_ = nullptr;
    Vec3d grabbed_{}, dragged_{};
    nlohmann::json pulls_ = nlohmann::json::array();
};

}  // namespace sqmap::app
