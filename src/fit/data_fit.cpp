#include "searches.h"

#include "least_squares.h"
#include "problems.h"
#include "sqmap/math/assert.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <algorithm>
#include <optional>

namespace sqmap::fit {

using shape::Superquadricd;

namespace {

constexpr double k_min_bend = 0.12;  ///< radians at the part's ends: less than that does not pay

/// On which samples, and how long.
struct Search {
    std::span<const Sample> samples;
    int max_iterations;
};

/// Eq. 3 from one start.
template <int N>
DataFit from_start(const ScaledPart& part, const Superquadricd& start, const Search& search, const FitOptions& options)
{
    Chart chart = chart_of(part, options);
    std::array<double, N> t;
    encode<N>(start, chart, t.data());
    const DataTerm<N> term{chart, search.samples, options.residual};
    const LeastSquaresReport done = minimise<N>(term, t.data(), {.max_iterations = search.max_iterations, .cost_change = 1e-8});
    if (!all_finite(t) || !std::isfinite(done.cost)) return {start, INFINITY, false, done.iterations};
    return {decode<N>(chart, t.data()), done.cost, done.settled, done.iterations};
}

/// A bent start from the parabola through the samples along the z axis of frame.
std::optional<Superquadricd> bent_start(const ScaledPart& part, const Mat3d& frame, const FitOptions& options)
{
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Matrix<double, 3, 2> right = Eigen::Matrix<double, 3, 2>::Zero();
    const OrientedBox box = box_of(frame, part.points);
    for (const Sample& s : part.samples) {
        const Vec3d q = frame * (s.point - box.middle);
        const Eigen::Vector3d row(1, q.z, q.z * q.z);
        normal += row * row.transpose();
        right += row * Eigen::RowVector2d(q.x, q.y);
    }
    // Column by column: Eigen's kernel for several at once fuses multiply and add on arm64, and models would differ.
    const Eigen::LDLT<Eigen::Matrix3d> solver(normal);
    Eigen::Matrix<double, 3, 2> c;
    for (int k = 0; k < 2; ++k) c.col(k) = solver.solve(right.col(k));
    if (!c.allFinite()) return std::nullopt;
    Superquadricd sq;
    sq.bend = 2 * norm(Vec3d{c(2, 0), c(2, 1), 0});
    sq.bend_angle = std::atan2(c(2, 1), c(2, 0));
    if (!(sq.bend * box.half.z > k_min_bend)) return std::nullopt;
    // z along the parabola's tangent at its middle.
    const Vec3d z = normalized(frame.row[2] + c(1, 0) * frame.row[0] + c(1, 1) * frame.row[1]);
    const Vec3d x = normalized(frame.row[0] - dot(frame.row[0], z) * z);
    sq.rotation = {{x, cross(z, x), z}};
    sq.translation = box.middle + transpose_mul(frame, Vec3d{c(0, 0), c(0, 1), 0});
    sq.eps1 = std::clamp(0.7, options.min_exponent, options.max_exponent);
    sq.eps2 = std::clamp(1.0, options.min_exponent, options.max_exponent);
    sq.a = {part.min_a, part.min_a, std::max(box.half.z, part.min_a)};
    sq.bend = std::min(sq.bend, 0.9 * bend_limit(sq));
    Vec3d extent{part.min_a, part.min_a, part.min_a};
    for (const Vec3d& p : part.extreme) {
        const Vec3d u = undeformed(sq, p);
        for (int k = 0; k < 3; ++k) extent[k] = std::max(extent[k], std::abs(u[k]));
    }
    sq.a = extent;
    sq.bend = std::min(sq.bend, 0.9 * bend_limit(sq));
    return sq;
}

}  // namespace

Mat3d with_z_axis(const Mat3d& frame, int axis)
{
    return {{frame.row[(axis + 1) % 3], frame.row[(axis + 2) % 3], frame.row[axis]}};
}

void seed_taper(std::vector<Superquadricd>& starts)
{
    for (Superquadricd& start : starts) start.taper_x = start.taper_y = 0.02;
}

std::vector<Superquadricd> bent_starts(const ScaledPart& part, const FitOptions& options, bool thorough)
{
    std::vector<Superquadricd> starts;
    for (int axis = 0; axis < (thorough ? 2 : 1); ++axis)
        if (const auto start = bent_start(part, with_z_axis(part.frame, axis), options)) starts.push_back(*start);
    seed_taper(starts);
    return starts;
}

template <int N>
DataFit fit_data(const ScaledPart& part, std::span<const Superquadricd> starts, const FitOptions& options, std::size_t finalists)
{
    SQMAP_ASSERT(!starts.empty());
    std::vector<Sample> few;
    for (std::size_t i = 0; i < part.samples.size(); i += 1 + part.samples.size() / 64) few.push_back(part.samples[i]);
    std::vector<DataFit> fits;
    int spent = 0;
    const auto run = [&](const Superquadricd& start, const Search& search) {
        const DataFit found = from_start<N>(part, start, search, options);
        spent += found.iterations;
        return found;
    };
    for (const Superquadricd& start : starts) fits.push_back(run(start, {few, std::min(8, options.max_iterations)}));
    const auto less = [](const DataFit& a, const DataFit& b) { return a.cost < b.cost; };
    std::stable_sort(fits.begin(), fits.end(), less);
    fits.resize(std::min(finalists, fits.size()));
    for (DataFit& fit : fits) fit = run(fit.sq, {part.samples, options.max_iterations});
    DataFit best = *std::min_element(fits.begin(), fits.end(), less);
    best.iterations = spent;
    return best;
}

template DataFit fit_data<k_plain>(const ScaledPart&, std::span<const Superquadricd>, const FitOptions&, std::size_t);
template DataFit fit_data<k_tapered>(const ScaledPart&, std::span<const Superquadricd>, const FitOptions&, std::size_t);
template DataFit fit_data<k_bent>(const ScaledPart&, std::span<const Superquadricd>, const FitOptions&, std::size_t);

}  // namespace sqmap::fit
