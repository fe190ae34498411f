#include "searches.h"

#include "chart.h"
#include "least_squares.h"
#include "problems.h"
#include "undeformed_points.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace sqmap::fit {

using shape::Superquadricd;

namespace {

/// The point of greatest bound first: most others are then known to lie deeper, and cost no power.
double largest_f(const Superquadricd& sq, const UndeformedPoints& at)
{
    const std::span<const double> bounds = at.bounds();
    double f = 0, root = 0;
    const auto offer = [&](std::size_t i) {
        f = std::max(f, shape::implicit_undeformed(sq.a, sq.eps1, sq.eps2, at.points()[i]));
        root = std::sqrt(f);
    };
    if (!bounds.empty()) offer(static_cast<std::size_t>(std::max_element(bounds.begin(), bounds.end()) - bounds.begin()));
    for (std::size_t i = 0; i < bounds.size(); ++i)
        if (!(bounds[i] < root)) offer(i);
    return root;
}
double largest_f(const Superquadricd& sq, std::span<const Vec3d> points)
{
    UndeformedPoints at;
    at.take(sq, points);
    return largest_f(sq, at);
}

/// Adds the point of each run of candidates that lies farthest outside, if any does by more than a little. at: of the candidates.
bool admit_violators(const Superquadricd& sq, std::span<const Vec3d> candidates, const UndeformedPoints& at,
                     std::vector<Vec3d>& points)
{
    const std::size_t runs = 12, before = points.size();
    for (std::size_t r = 0; r < runs; ++r) {
        const Vec3d* worst = nullptr;
        double root = 1.02, largest = root * root;
        for (std::size_t i = r * candidates.size() / runs; i < (r + 1) * candidates.size() / runs; ++i) {
            if (at.bounds()[i] < root) continue;
            const double f = shape::implicit_undeformed(sq.a, sq.eps1, sq.eps2, at.points()[i]);
            if (f > largest) {
                largest = f;
                root = std::sqrt(f);
                worst = &candidates[i];
            }
        }
        if (worst != nullptr && std::find(points.begin(), points.end(), *worst) == points.end()) points.push_back(*worst);
    }
    return points.size() > before;
}

}  // namespace

void scale_by(Superquadricd& sq, double s)
{
    sq.a = s * sq.a;
    sq.bend = sq.bend / s;
}

// One step is exact for plain shapes, F(s x) = s^2 F(x). For deformed ones f falls faster with the size, log f ~ -degree log s:
// secant steps, never past a bracket.
bool shrink_wrap(Superquadricd& sq, std::span<const Vec3d> points)
{
    double degree = sq.is_deformed() ? 2 : 1, scale = 1, last_log_f = 0, last_step = 0;
    double low = 0, high = INFINITY;
    const Superquadricd start = sq;
    for (int i = 0; i < 30; ++i) {
        const double m = largest_f(sq, points);
        if (!std::isfinite(m) || !(m > 1e-9)) return false;
        const double log_f = std::log(m);
        if (std::abs(log_f) < 1e-7) return true;
        (log_f > 0 ? low : high) = scale;
        if (i > 0 && sq.is_deformed()) degree = std::clamp((last_log_f - log_f) / last_step, 0.5, 30.0);
        double next = scale * std::exp(std::clamp(log_f / degree, -1.0, 1.0));
        if (!(next > low && next < high)) next = high < INFINITY ? 0.5 * (low + high) : 1.1 * low;
        last_step = std::log(next / scale);
        last_log_f = log_f;
        scale = next;
        sq = start;
        scale_by(sq, scale);
        if (!sq.is_deformed()) return true;
    }
    return std::abs(largest_f(sq, points) - 1) < 1e-3;
}

Candidate closed_form(const ScaledPart& part, const Mat3d& frame, const FitOptions& options)
{
    const std::vector<Vec3d>& points = part.extreme;
    const OrientedBox box = box_of(frame, points);
    Candidate best;
    const double grid[] = {0.1, 0.4, 0.8, 1.0, 1.4};
    for (const double eps1 : grid) {
        for (const double eps2 : grid) {
            Superquadricd sq;
            sq.a = box.half;
            for (int k = 0; k < 3; ++k) sq.a[k] = std::max(sq.a[k], part.min_a);
            sq.eps1 = std::clamp(eps1, options.min_exponent, options.max_exponent);
            sq.eps2 = std::clamp(eps2, options.min_exponent, options.max_exponent);
            sq.rotation = frame;
            sq.translation = box.middle;
            const double m = std::max(1e-3, largest_f(sq, points));
            scale_by(sq, m);
            const double v = volume(sq);
            if (m <= options.max_overhang && v < best.volume) best = {sq, v, true, 0};
        }
    }
    if (best.volume < INFINITY) return best;
    // Only when the caller's exponents are all round: the ellipsoid-like one, whatever it overhangs.
    Superquadricd sq;
    sq.a = box.half;
    for (int k = 0; k < 3; ++k) sq.a[k] = std::max(sq.a[k], part.min_a);
    sq.eps1 = sq.eps2 = std::clamp(1.0, options.min_exponent, options.max_exponent);
    sq.rotation = frame;
    sq.translation = box.middle;
    scale_by(sq, std::max(1e-3, largest_f(sq, points)));
    return {sq, volume(sq), true, 0};
}

template <int N>
Candidate least_volume(const ScaledPart& part, Superquadricd start, const FitOptions& options, int rounds)
{
    if (!shrink_wrap(start, N == k_plain ? part.extreme : part.extreme_inner)) return {};
    Chart chart = chart_of(part, options);
    std::array<double, N> t;
    encode<N>(start, chart, t.data());
    // Extreme points bound a convex shape; into one that is not, others may reach: those join as they are found.
    std::vector<Vec3d> points = N == k_plain ? part.extreme : part.extreme_inner;
    VolumeTerm<N> term(chart, points, options.max_overhang);
    const LeastSquaresOptions steps{.max_iterations = 8, .cost_change = 1e-7, .trust_region = 3};
    UndeformedPoints checked;
    Candidate best;
    int spent = 0;
    for (int round = 0; round < rounds; ++round) {
        term.log_volume_0 = log_volume(decode<N>(chart, t.data()));
        std::copy_n(t.data(), N, term.t0.begin());
        spent += minimise<N>(term, t.data(), steps).iterations;
        if (!all_finite(t)) break;
        const Superquadricd sq = decode<N>(chart, t.data());
        const std::vector<double>& g = term.constraints(t.data());
        for (std::size_t i = 0; i < g.size(); ++i) term.lambda[i] = std::max(0.0, term.lambda[i] + term.mu * g[i]);
        term.mu *= 2;

        // The volume once it holds the points, by the closed form: exact for plain shapes, pessimistic for deformed ones.
        double largest = *std::max_element(g.begin(), g.end() - 3);
        if (N != k_plain) {
            checked.take(sq, part.check);
            largest = std::max(largest, std::log(largest_f(sq, checked)));
        }
        const double v = volume(sq) * std::exp(3 * largest);
        const bool settled = std::abs(v - best.volume) <= 2e-3 * v;
        if (v < best.volume) best = {sq, v, settled, 0};
        if (settled) {
            best.converged = true;
            break;
        }
        if constexpr (N != k_plain) {
            if (admit_violators(sq, part.check, checked, points)) {
                term.points = points;
                term.lambda.insert(term.lambda.end() - 3, points.size() + 3 - term.lambda.size(), 0.0);
            }
        }
    }
    if (!(best.volume < INFINITY) || !shrink_wrap(best.sq, N == k_plain ? part.points : part.points_inner))
        best = {};
    else
        best.volume = volume(best.sq);
    best.iterations = spent;
    return best;
}

template Candidate least_volume<k_plain>(const ScaledPart&, Superquadricd, const FitOptions&, int);
template Candidate least_volume<k_tapered>(const ScaledPart&, Superquadricd, const FitOptions&, int);
template Candidate least_volume<k_bent>(const ScaledPart&, Superquadricd, const FitOptions&, int);

bool overhangs(const Superquadricd& sq, const ScaledPart& part, double max_overhang)
{
    Vec3d extent{};
    UndeformedPoints at;
    at.take(sq, part.points);
    for (const Vec3d& u : at.points()) {
        for (int k = 0; k < 3; ++k) extent[k] = std::max(extent[k], std::abs(u[k]));
    }
    for (int k = 0; k < 3; ++k)
        if (sq.a[k] > 1.1 * max_overhang * std::max(extent[k], part.min_a)) return true;
    return false;
}

}  // namespace sqmap::fit
