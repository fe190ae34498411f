// A garment from JSON: its pattern, its fabric and the events while it is worn.
#pragma once

#include "sqmap/sim/garment.h"

#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

namespace sqmap::app {

/// A garment file that does not say what it should; what() names the file, the key and the cure.
class GarmentFileError : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

struct SeamEvent {
    std::string seam;
    double at = 0;  ///< s
    bool sew = false;
};

/// The vertex nearest to a position and what is within radius of it ride a bone, from a time until another.
struct PinEvent {
    double at = 0, until = 0;  ///< s
    Vec3d near{};
    double radius = 0.02;  ///< m
    std::string bone;      ///< or "world"
};

/// A tool that takes the vertex nearest to a position and moves it.
struct Pull {
    double at = 0, until = 0;  ///< s
    Vec3d near{}, by{};        ///< m; by: in all, at a steady rate
    double radius = 0.02;
};

struct GarmentFile {
    std::string name, fabric_name;
    sim::Garment garment;
    sim::Fabric fabric;
    std::string waist_bone;  ///< that the waistband rides; empty: none
    std::vector<SeamEvent> seam_events;
    std::vector<PinEvent> pins;
    std::vector<Pull> pulls;  ///< one after the other
};

/// @throw GarmentFileError
[[nodiscard]] GarmentFile read_garment(const std::filesystem::path& path);

}  // namespace sqmap::app
