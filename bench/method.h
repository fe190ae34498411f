// The interface of every method of the bench: built once from a setting, run once a frame, read outside the measurement.
#pragma once

#include "path.h"
#include "setting.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace sqmap::bench {

/// A probe vertex that a method finds inside the object.
struct VertexContact {
    std::uint32_t vertex;
    float depth;  ///< >= 0, units of the setting
};

/// Findings of a method in one frame.
struct FrameAnswer {
    std::vector<VertexContact> vertices;  ///< ascending; empty where the method reports triangle pairs
    std::uint64_t pairs = 0;              ///< pairs or contact points, where it does
    std::uint64_t pairs_hash = 0;
};

class Method {
public:
    virtual ~Method() = default;
    /// The timed work: everything from a pose to answers in memory of the method's own.
    virtual void run(const Pose& pose) = 0;
    /// The answers of the last run, in the common form; not timed.
    virtual void read(FrameAnswer& out) const = 0;
    /// Verdicts on all vertices, where a run stops at the first; not timed.
    virtual void read_all(const Pose&, FrameAnswer& out) { read(out); }

    std::size_t bytes = 0;        ///< kept resident for the object
    std::size_t probe_bytes = 0;  ///< and for the probe, beyond its vertices
    double build_s = 0;           ///< CPU seconds to make what bytes counts (as measured when a cached field was made)
};

/// A name that --methods knows.
struct MethodEntry {
    std::string name;
    std::string package{};  ///< Debian package that it needs, empty where it is always there
    bool pairs = false;     ///< reports triangle pairs, no verdict a vertex
    bool extra = false;     ///< run only when it is named
    bool slow = false;      ///< run on some frames only (RunOptions::slow_frames)
    std::unique_ptr<Method> (*make)(const Setting&, int) = nullptr;  ///< null: not compiled in
    int argument = 0;                                                ///< of make
};

/// All methods in the order of reports.
[[nodiscard]] std::span<const MethodEntry> method_entries();

// One file each. The argument: see methods.cpp.
[[nodiscard]] std::unique_ptr<Method> make_sqmap(const Setting& setting, int layer);
[[nodiscard]] std::unique_ptr<Method> make_sqmap_normal(const Setting& setting, int which);
[[nodiscard]] std::unique_ptr<Method> make_dense(const Setting& setting, int samples);
[[nodiscard]] std::unique_ptr<Method> make_dense_simd(const Setting& setting, int samples);
[[nodiscard]] std::unique_ptr<Method> make_dense_simd_normal(const Setting& setting, int samples);
[[nodiscard]] std::unique_ptr<Method> make_adf(const Setting& setting, int);
[[nodiscard]] std::unique_ptr<Method> make_openvdb(const Setting& setting, int voxels);
[[nodiscard]] std::unique_ptr<Method> make_embree(const Setting& setting, int);
[[nodiscard]] std::unique_ptr<Method> make_fcl(const Setting& setting, int kind);
[[nodiscard]] std::unique_ptr<Method> make_bullet(const Setting& setting, int);

/// CPU seconds of the whole process, for build times.

/// 64-bit FNV-1a over words: small, stable, good enough to tell answers apart.
class Hash {
public:
    void add(std::uint64_t word)
    {
        for (int i = 0; i < 8; ++i) value_ = (value_ ^ (word >> (8 * i) & 0xff)) * 0x100000001b3ull;
    }
    [[nodiscard]] std::uint64_t value() const { return value_; }

private:
    std::uint64_t value_ = 0xcbf29ce484222325ull;
};

}  // namespace sqmap::bench
