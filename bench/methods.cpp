#include "method.h"

#include <array>

namespace sqmap::bench {
namespace {

#if SQMAP_BENCH_FCL
constexpr auto k_fcl = make_fcl;
#else
constexpr std::unique_ptr<Method> (*k_fcl)(const Setting&, int) = nullptr;
#endif
#if SQMAP_BENCH_BULLET
constexpr auto k_bullet = make_bullet;
#else
constexpr std::unique_ptr<Method> (*k_bullet)(const Setting&, int) = nullptr;
#endif
#if SQMAP_BENCH_OPENVDB
constexpr auto k_openvdb = make_openvdb;
#else
constexpr std::unique_ptr<Method> (*k_openvdb)(const Setting&, int) = nullptr;
#endif

}  // namespace

std::span<const MethodEntry> method_entries()
{
    static const std::array k_entries{
        MethodEntry{.name = "sqmap_layer1", .make = make_sqmap, .argument = 0},
        MethodEntry{.name = "sqmap_layer2", .make = make_sqmap, .argument = 2},
        MethodEntry{.name = "sqmap_layer3", .make = make_sqmap, .argument = 3},
        MethodEntry{.name = "sqmap_exact", .make = make_sqmap, .argument = 4},
        MethodEntry{.name = "fcl_obb_all", .package = "libfcl-dev", .pairs = true, .make = k_fcl, .argument = 0},
        MethodEntry{.name = "fcl_obb_first", .package = "libfcl-dev", .pairs = true, .make = k_fcl, .argument = 1},
        MethodEntry{.name = "fcl_kdop_all", .package = "libfcl-dev", .pairs = true, .slow = true, .make = k_fcl, .argument = 2},
        MethodEntry{.name = "bullet_gimpact", .package = "libbullet-dev", .pairs = true, .make = k_bullet},
        MethodEntry{.name = "dense64", .make = make_dense, .argument = 64},
        MethodEntry{.name = "dense128", .make = make_dense, .argument = 128},
        MethodEntry{.name = "dense256", .make = make_dense, .argument = 256},
        MethodEntry{.name = "dense64_simd", .make = make_dense_simd, .argument = 64},
        MethodEntry{.name = "dense128_simd", .make = make_dense_simd, .argument = 128},
        MethodEntry{.name = "dense256_simd", .make = make_dense_simd, .argument = 256},
        MethodEntry{.name = "adf", .make = make_adf},
        MethodEntry{.name = "openvdb256", .package = "libopenvdb-dev", .make = k_openvdb, .argument = 256},
        MethodEntry{.name = "embree_exact", .slow = true, .make = make_embree},
        MethodEntry{.name = "sqmap_layer1_all", .extra = true, .slow = true, .make = make_sqmap, .argument = 1},
        MethodEntry{.name = "sqmap_normal_layer1", .extra = true, .make = make_sqmap_normal, .argument = 1},
        MethodEntry{.name = "sqmap_normal_layer2", .extra = true, .make = make_sqmap_normal, .argument = 2},
        MethodEntry{.name = "sqmap_normal_layer3", .extra = true, .make = make_sqmap_normal, .argument = 3},
        MethodEntry{.name = "sqmap_normal_pyramid2", .extra = true, .make = make_sqmap_normal, .argument = 4},
        MethodEntry{.name = "sqmap_normal_pyramid3", .extra = true, .make = make_sqmap_normal, .argument = 5},
        MethodEntry{.name = "sqmap_normal_one_lane", .extra = true, .make = make_sqmap_normal, .argument = 6},
        MethodEntry{.name = "sqmap_normal_printed", .extra = true, .make = make_sqmap_normal, .argument = 0},
        MethodEntry{.name = "dense64_simd_normal", .extra = true, .make = make_dense_simd_normal, .argument = 64},
        MethodEntry{.name = "dense128_simd_normal", .extra = true, .make = make_dense_simd_normal, .argument = 128},
        MethodEntry{.name = "dense256_simd_normal", .extra = true, .make = make_dense_simd_normal, .argument = 256},
    };
    return k_entries;
}

}  // namespace sqmap::bench
