// Common to the tests of the C interface: a torus by both interfaces, a mesh in C's form, refusals.
#pragma once

#include "sqmap.h"
#include "sqmap/mesh/shapes.h"
#include "support/parsed.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <random>
#include <string>
#include <vector>

namespace sqmap::test {

inline constexpr double k_nan = std::numeric_limits<double>::quiet_NaN();

/// A mesh in the C interface's form.
class GivenMesh {
public:
    explicit GivenMesh(const mesh::Mesh& mesh) : vertices_(mesh.vertices)
    {
        for (const mesh::Triangle& t : mesh.triangles) corners_.insert(corners_.end(), t.begin(), t.end());
    }
    [[nodiscard]] sqmap_mesh operator()() const
    {
        return {sizeof(sqmap_mesh), &vertices_[0].x, vertices_.size(), corners_.data(), corners_.size() / 3};
    }

private:
    std::vector<Vec3d> vertices_;
    std::vector<std::int64_t> corners_;
};

/// A torus by both interfaces, and points in and about it; one of them is not finite.
class Capi : public testing::Test {
protected:
    Capi()
    {
        EXPECT_EQ(sqmap_open_bytes(bytes_.data(), bytes_.size(), &model_), SQMAP_OK);
        std::mt19937_64 random(1);
        std::uniform_real_distribution<double> uniform(-1.6, 1.6);
        for (int i = 0; i < 10'000; ++i) points_.push_back({uniform(random), uniform(random), uniform(random)});
        points_[17].y = k_nan;
    }
    ~Capi() override { EXPECT_EQ(sqmap_close_model(model_), SQMAP_OK); }

    [[nodiscard]] const model::ModelView& view() const { return parsed_.view(); }
    [[nodiscard]] sqmap_points points() const { return {sizeof(sqmap_points), &points_[0].x, points_.size(), nullptr}; }

    mesh::Mesh torus_ = mesh::torus();
    Parsed parsed_{torus_};
    std::vector<std::byte> bytes_ = baked_bytes(torus_, true);
    sqmap_model model_{};
    std::vector<Vec3d> points_;
};

/// The last error is complete, and says this of where.
inline void expect_refused(sqmap_code code, sqmap_code expected, const std::string& element)
{
    ASSERT_EQ(code, expected) << sqmap_last_error()->message;
    const sqmap_error& e = *sqmap_last_error();
    EXPECT_EQ(e.code, expected);
    EXPECT_EQ(e.element, element);
    EXPECT_GT(std::strlen(e.name), 2u);
    EXPECT_GT(std::strlen(e.message), 2u);
    EXPECT_GT(std::strlen(e.cure), 2u);
}

}  // namespace sqmap::test
