// Bounding superquadrics for parts: Moustakas, Tzovaras and Strintzis, SQ-Map, section 2.
//
// Data term: Solina and Bajcsy, Recovery of parametric models from range images (1990), with the radial distance of Gross
// and Boult (1988) as residual by default: a departure from eq. 3, whose minimum is biased towards points near the centre.
// Bounding: least volume under f <= 1 by an augmented Lagrangian, see problems.h; the closed form F(s x) = s^2 F(x) then
// makes containment exact, and certify() proves it for what is really stored, the parameters rounded to float.
#include "sqmap/fit/fit.h"

#include "chart.h"
#include "least_squares.h"
#include "power_free.h"
#include "problems.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

namespace sqmap::fit {
namespace {

using Corners = std::array<Vec3d, 3>;
using shape::Superquadricd;

constexpr int k_short = 3, k_long = 8;  ///< rounds of the augmented Lagrangian, to rank starts and to finish one
constexpr double k_exact_cost = 1e-10;  ///< of eq. 3 in the part's units: nothing left to explain by deforming
constexpr double k_least_bend = 0.12;   ///< radians at the part's ends: less than that does not pay
constexpr double k_infinity = std::numeric_limits<double>::infinity();

/// The part in coordinates of its own: about the middle of its principal box, with greatest distance 1 from it.
struct Part {
    std::vector<Corners> triangles;     ///< model space: surface, then caps
    std::vector<Vec3d> corners;         ///< model space: of the surface, each once, and of the caps
    std::vector<mesh::Triangle> faces;  ///< triangles, by corners
    Mat3d frame;                        ///< rows: principal axes, longest first
    Vec3d middle;                       ///< model space
    double size = 1;                    ///< model units
    std::vector<Vec3d> points;          ///< all corners
    std::vector<Vec3d> extreme;         ///< those of them that lie farthest in some of many directions
    std::vector<Vec3d> points_inner;    ///< points, and some within triangles large enough to leave a shape that is not convex
    std::vector<Vec3d> extreme_inner;   ///< extreme, and some of those
    std::vector<Vec3d> check;           ///< points_inner, thinned to a few hundred
    std::vector<Sample> samples;        ///< of the surface, without caps
    double least_a = 1e-3;
};

struct Candidate {
    Superquadricd sq;
    double volume = k_infinity;
    bool converged = false;
};

Mat3d principal_frame(std::span<const Corners> triangles, Vec3d origin)
{
    Eigen::Matrix3d moment = Eigen::Matrix3d::Zero(), corner_moment = Eigen::Matrix3d::Zero();
    Eigen::Vector3d first = Eigen::Vector3d::Zero(), corner_first = Eigen::Vector3d::Zero();
    double area = 0;
    const auto eigen = [&](Vec3d v) { return Eigen::Vector3d(v.x - origin.x, v.y - origin.y, v.z - origin.z); };
    for (const Corners& t : triangles) {
        const double a = norm(cross(t[1] - t[0], t[2] - t[0])) / 2;
        const Eigen::Vector3d p = eigen(t[0]), q = eigen(t[1]), r = eigen(t[2]), s = p + q + r;
        const Eigen::Matrix3d corners = p * p.transpose() + q * q.transpose() + r * r.transpose();
        moment += a / 12 * (corners + s * s.transpose());
        first += a / 3 * s;
        area += a;
        corner_moment += corners;
        corner_first += s;
    }
    // Corners keep a say, so that triangles without area have axes too.
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    if (area > 0) covariance = moment / area - first * first.transpose() / (area * area);
    const double count = 3.0 * static_cast<double>(std::max<std::size_t>(1, triangles.size()));
    covariance += 1e-3 * (corner_moment / count - corner_first * corner_first.transpose() / (count * count));
    const double trace = covariance.trace();
    if (!(trace > 0) || !std::isfinite(trace)) return {};

    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(Eigen::Matrix3d(covariance / trace));
    const Eigen::Matrix3d axes = solver.eigenvectors();
    Mat3d frame;
    for (int i = 0; i < 3; ++i) frame.row[i] = {axes(0, 2 - i), axes(1, 2 - i), axes(2, 2 - i)};
    for (int i = 0; i < 2; ++i) {  // an eigenvector's sign means nothing: make it the same on every machine
        const Vec3d v = frame.row[i];
        const double largest =
            std::abs(v.x) >= std::abs(v.y) && std::abs(v.x) >= std::abs(v.z) ? v.x : (std::abs(v.y) >= std::abs(v.z) ? v.y : v.z);
        if (largest < 0) frame.row[i] = -v;
    }
    frame.row[2] = cross(frame.row[0], frame.row[1]);
    return frame;
}

/// Stratified by area in the order of the triangles, with the R2 sequence within them.
std::vector<Sample> sample(std::span<const Corners> triangles, int count)
{
    std::vector<double> sum;
    double area = 0;
    for (const Corners& t : triangles) sum.push_back(area += norm(cross(t[1] - t[0], t[2] - t[0])) / 2);
    std::vector<Sample> samples;
    if (!(area > 0)) {
        for (const Corners& t : triangles) {
            if (static_cast<int>(samples.size()) >= count) break;
            for (const Vec3d& v : t) samples.push_back({v, 1});
        }
    } else {
        std::size_t at = 0;
        double u = 0.5, v = 0.5;
        for (int i = 0; i < count; ++i) {
            while (at + 1 < triangles.size() && sum[at] < area * (i + 0.5) / count) ++at;
            u = u + 0.7548776662466927 - (u + 0.7548776662466927 >= 1);
            v = v + 0.5698402909980532 - (v + 0.5698402909980532 >= 1);
            const bool fold = u + v > 1;
            const double b1 = fold ? 1 - u : u, b2 = fold ? 1 - v : v;
            samples.push_back(
                {triangles[at][0] + b1 * (triangles[at][1] - triangles[at][0]) + b2 * (triangles[at][2] - triangles[at][0]), 1});
        }
    }
    for (Sample& s : samples) s.weight = 1 / std::sqrt(static_cast<double>(samples.size()));
    return samples;
}

struct Box {
    Vec3d middle, half;
};

Box box_of(const Mat3d& frame, std::span<const Vec3d> points)
{
    Vec3d low{k_infinity, k_infinity, k_infinity}, high = -low;
    for (const Vec3d& p : points) {
        const Vec3d q = frame * p;
        for (int k = 0; k < 3; ++k) {
            low[k] = std::min(low[k], q[k]);
            high[k] = std::max(high[k], q[k]);
        }
    }
    return {transpose_mul(frame, 0.5 * (low + high)), 0.5 * (high - low)};
}

/// Points that lie farthest in some of many directions, the directions stretched with the box so that needles and sheets
/// are covered as evenly as balls.
std::vector<Vec3d> extreme_points(std::span<const Vec3d> points, const Mat3d& frame, Vec3d half, int directions)
{
    std::vector<std::size_t> chosen;
    for (int i = 0; i < directions; ++i) {
        const double z = 1 - (2 * i + 1.0) / directions, r = std::sqrt(1 - z * z);
        const double angle = i * std::numbers::pi * (3 - std::sqrt(5.0));
        const Vec3d d = transpose_mul(frame, Vec3d{r * std::cos(angle) / half.x, r * std::sin(angle) / half.y, z / half.z});
        std::size_t best = 0;
        double reach = -k_infinity;
        for (std::size_t k = 0; k < points.size(); ++k) {
            const double along = dot(d, points[k]);
            if (along > reach) {
                reach = along;
                best = k;
            }
        }
        chosen.push_back(best);
    }
    std::sort(chosen.begin(), chosen.end());
    chosen.erase(std::unique(chosen.begin(), chosen.end()), chosen.end());
    std::vector<Vec3d> extreme;
    for (const std::size_t k : chosen) extreme.push_back(points[k]);
    return extreme;
}

void add_inner_points(const Corners& t, Vec3d middle, double size, std::vector<Vec3d>& points)
{
    const double longest = std::max({norm(t[1] - t[0]), norm(t[2] - t[1]), norm(t[0] - t[2])}) / size;
    const int n = std::min(4, static_cast<int>(longest / 0.2));
    for (int i = 0; n >= 2 && i <= n; ++i)
        for (int j = 0; i + j <= n; ++j)
            if (i != n && j != n && i + j != 0)
                points.push_back((t[0] + (double(i) / n) * (t[1] - t[0]) + (double(j) / n) * (t[2] - t[0]) - middle) / size);
}

Part prepare(const mesh::Mesh& mesh, std::span<const std::uint32_t> triangles, std::span<const Corners> caps,
             const FitOptions& options)
{
    Part part;
    for (const std::uint32_t t : triangles)
        part.triangles.push_back(
            {mesh.vertices[mesh.triangles[t][0]], mesh.vertices[mesh.triangles[t][1]], mesh.vertices[mesh.triangles[t][2]]});
    const std::size_t surface = part.triangles.size();
    part.triangles.insert(part.triangles.end(), caps.begin(), caps.end());

    std::vector<std::uint32_t> corners;
    for (const std::uint32_t t : triangles) corners.insert(corners.end(), mesh.triangles[t].begin(), mesh.triangles[t].end());
    std::sort(corners.begin(), corners.end());
    corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
    for (const std::uint32_t v : corners) part.points.push_back(mesh.vertices[v]);
    for (const std::uint32_t t : triangles) {
        mesh::Triangle& face = part.faces.emplace_back();
        for (std::size_t k = 0; k < 3; ++k)
            face[k] = static_cast<std::uint32_t>(std::lower_bound(corners.begin(), corners.end(), mesh.triangles[t][k]) -
                                                 corners.begin());
    }
    for (const Corners& t : caps) {
        const auto first = static_cast<std::uint32_t>(part.points.size());
        part.faces.push_back({first, first + 1, first + 2});
        part.points.insert(part.points.end(), t.begin(), t.end());
    }
    part.corners = part.points;
    if (part.points.empty()) part.points.push_back({});

    part.frame = principal_frame(part.triangles, part.points[0]);
    part.middle = box_of(part.frame, part.points).middle;
    double size = 0;
    for (const Vec3d& p : part.points) size = std::max(size, norm(p - part.middle));
    // Nothing thinner than float coordinates can tell from its middle.
    const double least = std::max(2e-3 * size, std::max(5e-5 * norm(part.middle), 1e-30));
    part.size = std::max(size, 2 * least);
    part.least_a = least / part.size;

    std::vector<Corners> local;
    for (Vec3d& p : part.points) p = (p - part.middle) / part.size;
    for (std::size_t i = 0; i < surface; ++i) {
        Corners t = part.triangles[i];
        for (Vec3d& v : t) v = (v - part.middle) / part.size;
        local.push_back(t);
    }
    part.points_inner = part.points;
    for (const Corners& t : part.triangles) add_inner_points(t, part.middle, part.size, part.points_inner);
    part.samples = sample(local, std::max(options.max_samples, 1));
    Vec3d half = box_of(part.frame, part.points).half;
    for (int k = 0; k < 3; ++k) half[k] = std::max(half[k], part.least_a);
    part.extreme = part.points.size() > 200 ? extreme_points(part.points, part.frame, half, 200) : part.points;
    part.extreme_inner = part.extreme;
    const std::size_t inner = part.points_inner.size() - part.points.size(), step = 1 + inner / 80;
    for (std::size_t i = part.points.size(); i < part.points_inner.size(); i += step)
        part.extreme_inner.push_back(part.points_inner[i]);
    const std::size_t thin = 1 + part.points_inner.size() / 500;
    for (std::size_t i = 0; i < part.points_inner.size(); i += thin) part.check.push_back(part.points_inner[i]);
    return part;
}

double largest_f(const Superquadricd& sq, std::span<const Vec3d> points)
{
    const PowerFreeBound at_most(sq);
    double f = 0, root = 0;
    for (const Vec3d& p : points) {
        const Vec3d u = undeformed(sq, p);
        if (at_most(u) < root) continue;
        f = std::max(f, shape::implicit_undeformed(sq.a, sq.eps1, sq.eps2, u));
        root = std::sqrt(f);
    }
    return root;
}

void scale_by(Superquadricd& sq, double s)
{
    sq.a = s * sq.a;
    sq.bend = sq.bend / s;
}

/// Scales sq about its centre until it just holds the points. One step is exact for plain shapes, F(s x) = s^2 F(x). For
/// deformed ones f falls faster with the size, log f ~ -degree log s: secant steps, never past a bracket.
bool shrink_wrap(Superquadricd& sq, std::span<const Vec3d> points)
{
    double degree = sq.is_deformed() ? 2 : 1, scale = 1, last_log_f = 0, last_step = 0;
    double low = 0, high = k_infinity;
    const Superquadricd start = sq;
    for (int i = 0; i < 30; ++i) {
        const double m = largest_f(sq, points);
        if (!std::isfinite(m) || !(m > 1e-9)) return false;
        const double log_f = std::log(m);
        if (std::abs(log_f) < 1e-7) return true;
        (log_f > 0 ? low : high) = scale;
        if (i > 0 && sq.is_deformed()) degree = std::clamp((last_log_f - log_f) / last_step, 0.5, 30.0);
        double next = scale * std::exp(std::clamp(log_f / degree, -1.0, 1.0));
        if (!(next > low && next < high)) next = high < k_infinity ? 0.5 * (low + high) : 1.1 * low;
        last_step = std::log(next / scale);
        last_log_f = log_f;
        scale = next;
        sq = start;
        scale_by(sq, scale);
        if (!sq.is_deformed()) return true;
    }
    return std::abs(largest_f(sq, points) - 1) < 1e-3;
}

Mat3d with_z_axis(const Mat3d& frame, int axis)
{
    return {{frame.row[(axis + 1) % 3], frame.row[(axis + 2) % 3], frame.row[axis]}};
}

/// Best exponents for the principal box with a given z axis, in closed form.
Candidate closed_form(const Part& part, const Mat3d& frame, std::span<const Vec3d> points, const FitOptions& options)
{
    const Box box = box_of(frame, points);
    Candidate best;
    const double grid[] = {0.1, 0.4, 0.8, 1.0, 1.4};
    for (const double eps1 : grid) {
        for (const double eps2 : grid) {
            Superquadricd sq;
            sq.a = box.half;
            for (int k = 0; k < 3; ++k) sq.a[k] = std::max(sq.a[k], part.least_a);
            sq.eps1 = std::clamp(eps1, options.min_exponent, options.max_exponent);
            sq.eps2 = std::clamp(eps2, options.min_exponent, options.max_exponent);
            sq.rotation = frame;
            sq.translation = box.middle;
            const double m = std::max(1e-3, largest_f(sq, points));
            scale_by(sq, m);
            const double v = volume(sq);
            if (m <= options.max_overhang && v < best.volume) best = {sq, v, true};
        }
    }
    if (best.volume < k_infinity) return best;
    // Only when the caller's exponents are all round: the ellipsoid-like one, whatever it overhangs.
    Superquadricd sq;
    sq.a = box.half;
    for (int k = 0; k < 3; ++k) sq.a[k] = std::max(sq.a[k], part.least_a);
    sq.eps1 = sq.eps2 = std::clamp(1.0, options.min_exponent, options.max_exponent);
    sq.rotation = frame;
    sq.translation = box.middle;
    scale_by(sq, std::max(1e-3, largest_f(sq, points)));
    return {sq, volume(sq), true};
}

Chart chart_of(const Part& part, const FitOptions& options)
{
    Chart chart;
    chart.least_a = part.least_a * 0.999;
    chart.greatest_a = 2;
    chart.least_eps = options.min_exponent;
    chart.greatest_eps = std::max(options.max_exponent, options.min_exponent + 1e-6);
    return chart;
}

struct DataFit {
    Superquadricd sq;
    double cost = k_infinity;  ///< half the sum of squares of eq. 3, in the part's units
    bool converged = false;
};

bool all_finite(std::span<const double> values)
{
    return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

/// Eq. 3 from one start.
template <int N>
DataFit fit_data(const Part& part, const Superquadricd& start, std::span<const Sample> samples, const FitOptions& options,
                 int iterations, int& spent)
{
    Chart chart = chart_of(part, options);
    std::array<double, N> t;
    encode<N>(start, chart, t.data());
    const DataTerm<N> term{chart, samples, options.residual};
    const LeastSquaresReport done = minimise<N>(term, t.data(), {.max_iterations = iterations, .cost_change = 1e-8});
    spent += done.iterations;
    if (!all_finite(t) || !std::isfinite(done.cost)) return {start};
    return {decode<N>(chart, t.data()), done.cost, done.settled};
}

/// Adds the point of each run of candidates that lies farthest outside, if any does by more than a little.
bool admit_violators(const Superquadricd& sq, std::span<const Vec3d> candidates, std::vector<Vec3d>& points)
{
    const std::size_t runs = 12, before = points.size();
    const PowerFreeBound at_most(sq);
    for (std::size_t r = 0; r < runs; ++r) {
        const Vec3d* worst = nullptr;
        double root = 1.02, most = root * root;
        for (std::size_t i = r * candidates.size() / runs; i < (r + 1) * candidates.size() / runs; ++i) {
            const Vec3d u = undeformed(sq, candidates[i]);
            if (at_most(u) < root) continue;
            const double f = shape::implicit_undeformed(sq.a, sq.eps1, sq.eps2, u);
            if (f > most) {
                most = f;
                root = std::sqrt(f);
                worst = &candidates[i];
            }
        }
        if (worst != nullptr && std::find(points.begin(), points.end(), *worst) == points.end()) points.push_back(*worst);
    }
    return points.size() > before;
}

/// Least bounding volume from one start.
template <int N>
Candidate fit_volume(const Part& part, Superquadricd start, const FitOptions& options, int rounds, int& spent)
{
    if (!shrink_wrap(start, N == k_plain ? part.extreme : part.extreme_inner)) return {};
    Chart chart = chart_of(part, options);
    std::array<double, N> t;
    encode<N>(start, chart, t.data());
    // Extreme points bound a convex shape; into one that is not, others may reach: those join as they are found.
    std::vector<Vec3d> points = N == k_plain ? part.extreme : part.extreme_inner;
    VolumeTerm<N> term(chart, points, options.max_overhang);
    const LeastSquaresOptions steps{.max_iterations = 8, .cost_change = 1e-7, .trust_region = 3};
    std::vector<double> g(points.size() + 3);
    std::array<std::size_t, 3> extreme;
    Candidate best;
    for (int round = 0; round < rounds; ++round) {
        term.log_volume_0 = log_volume(decode<N>(chart, t.data()));
        std::copy_n(t.data(), N, term.t0.begin());
        spent += minimise<N>(term, t.data(), steps).iterations;
        if (!all_finite(t)) break;
        const Superquadricd sq = decode<N>(chart, t.data());
        term.constraints(sq, g.data(), extreme);
        for (std::size_t i = 0; i < g.size(); ++i) term.lambda[i] = std::max(0.0, term.lambda[i] + term.mu * g[i]);
        term.mu *= 2;

        // The volume once it holds the points, by the closed form: exact for plain shapes, pessimistic for deformed ones.
        double most = *std::max_element(g.begin(), g.end() - 3);
        if (N != k_plain) most = std::max(most, std::log(largest_f(sq, part.check)));
        const double v = volume(sq) * std::exp(3 * most);
        const bool settled = std::abs(v - best.volume) <= 2e-3 * v;
        if (v < best.volume) best = {sq, v, settled};
        if (settled) {
            best.converged = true;
            break;
        }
        if constexpr (N != k_plain) {
            if (admit_violators(sq, part.check, points)) {
                term.points = points;
                term.lambda.insert(term.lambda.end() - 3, points.size() + 3 - term.lambda.size(), 0.0);
                g.resize(points.size() + 3);
            }
        }
    }
    if (!(best.volume < k_infinity) || !shrink_wrap(best.sq, N == k_plain ? part.points : part.points_inner)) return {};
    best.volume = volume(best.sq);
    return best;
}

bool overhangs(const Superquadricd& sq, std::span<const Vec3d> points, double least_a, double limit)
{
    Vec3d extent{};
    for (const Vec3d& p : points) {
        const Vec3d u = undeformed(sq, p);
        for (int k = 0; k < 3; ++k) extent[k] = std::max(extent[k], std::abs(u[k]));
    }
    for (int k = 0; k < 3; ++k)
        if (sq.a[k] > limit * std::max(extent[k], least_a)) return true;
    return false;
}

/// A bent start from the parabola through the samples along the z axis of frame.
std::optional<Superquadricd> bent_start(const Part& part, const Mat3d& frame, const FitOptions& options)
{
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Matrix<double, 3, 2> right = Eigen::Matrix<double, 3, 2>::Zero();
    const Box box = box_of(frame, part.points);
    for (const Sample& s : part.samples) {
        const Vec3d q = frame * (s.point - box.middle);
        const Eigen::Vector3d row(1, q.z, q.z * q.z);
        normal += row * row.transpose();
        right += row * Eigen::RowVector2d(q.x, q.y);
    }
    const Eigen::Matrix<double, 3, 2> c = normal.ldlt().solve(right);
    if (!c.allFinite()) return std::nullopt;
    Superquadricd sq;
    sq.bend = 2 * std::hypot(c(2, 0), c(2, 1));
    sq.bend_angle = std::atan2(c(2, 1), c(2, 0));
    if (!(sq.bend * box.half.z > k_least_bend)) return std::nullopt;
    // z along the parabola's tangent at its middle.
    const Vec3d z = normalized(frame.row[2] + c(1, 0) * frame.row[0] + c(1, 1) * frame.row[1]);
    const Vec3d x = normalized(frame.row[0] - dot(frame.row[0], z) * z);
    sq.rotation = {{x, cross(z, x), z}};
    sq.translation = box.middle + transpose_mul(frame, Vec3d{c(0, 0), c(0, 1), 0});
    sq.eps1 = std::clamp(0.7, options.min_exponent, options.max_exponent);
    sq.eps2 = std::clamp(1.0, options.min_exponent, options.max_exponent);
    sq.a = {part.least_a, part.least_a, std::max(box.half.z, part.least_a)};
    sq.bend = std::min(sq.bend, 0.9 * bend_limit(sq));
    Vec3d extent{part.least_a, part.least_a, part.least_a};
    for (const Vec3d& p : part.extreme) {
        const Vec3d u = undeformed(sq, p);
        for (int k = 0; k < 3; ++k) extent[k] = std::max(extent[k], std::abs(u[k]));
    }
    sq.a = extent;
    sq.bend = std::min(sq.bend, 0.9 * bend_limit(sq));
    return sq;
}

double as_float(double v) { return static_cast<double>(static_cast<float>(v)); }

void round_to_float(Superquadricd& sq)
{
    for (int k = 0; k < 3; ++k) {
        sq.a[k] = as_float(sq.a[k]);
        sq.translation[k] = as_float(sq.translation[k]);
        for (int i = 0; i < 3; ++i) sq.rotation.row[i][k] = as_float(sq.rotation.row[i][k]);
    }
    for (double* v : {&sq.eps1, &sq.eps2, &sq.taper_x, &sq.taper_y, &sq.bend, &sq.bend_angle}) *v = as_float(*v);
}

/// Into model space, rounded, and enlarged until the proof holds with room for the runtime's rounding.
bool finish(const Part& part, Superquadricd sq, FitReport& report)
{
    scale_by(sq, part.size);
    sq.translation = part.middle + part.size * sq.translation;
    for (int attempt = 0; attempt < 12; ++attempt) {
        round_to_float(sq);
        const Certificate certificate = certify(sq, part.corners, part.faces);
        if (!std::isfinite(certificate.largest_f)) return false;
        const double margin = float_margin(sq);
        if (margin < 0.5 && certificate.largest_f <= 1 - margin) {
            report.superquadric = sq;
            report.certificate = certificate;
            report.volume = volume(sq);
            return true;
        }
        scale_by(sq, std::sqrt(std::max(1.0, certificate.largest_f) / std::max(0.1, 1 - margin)) * (1 + 2e-7 * (1 << attempt)));
    }
    return false;
}

double radial_rms(const Part& part, Superquadricd sq)
{
    // samples are in the part's own units
    sq.translation = (sq.translation - part.middle) / part.size;
    scale_by(sq, 1 / part.size);
    double sum = 0;
    for (const Sample& s : part.samples) {
        const double r = s.weight * residual_of(Residual::Radial, sq, s.point);
        sum += r * r;
    }
    return part.size * std::sqrt(sum);
}

/// Eq. 3 on the samples: a few steps from each start on a part of them, then the best `finalists` on all.
template <int N>
DataFit fit_data_from(const Part& part, std::span<const Superquadricd> starts, const FitOptions& options, std::size_t finalists,
                      int& spent)
{
    std::vector<Sample> few;
    for (std::size_t i = 0; i < part.samples.size(); i += 1 + part.samples.size() / 64) few.push_back(part.samples[i]);
    std::vector<DataFit> fits;
    for (const Superquadricd& start : starts)
        fits.push_back(fit_data<N>(part, start, few, options, std::min(8, options.max_iterations), spent));
    const auto less = [](const DataFit& a, const DataFit& b) { return a.cost < b.cost; };
    std::stable_sort(fits.begin(), fits.end(), less);
    fits.resize(std::min(finalists, fits.size()));
    for (DataFit& fit : fits) fit = fit_data<N>(part, fit.sq, part.samples, options, options.max_iterations, spent);
    return *std::min_element(fits.begin(), fits.end(), less);
}

/// A little taper, so that its sign can be found: at 0 exactly it counts as absent and has no slope.
void seed_taper(std::vector<Superquadricd>& starts)
{
    for (Superquadricd& start : starts) start.taper_x = start.taper_y = 0.02;
}

/// Starts with their axis along the part's longest, and where thorough along its second too.
std::vector<Superquadricd> bent_starts(const Part& part, const FitOptions& options, bool thorough)
{
    std::vector<Superquadricd> starts;
    for (int axis = 0; axis < (thorough ? 2 : 1); ++axis)
        if (const auto start = bent_start(part, with_z_axis(part.frame, axis), options)) starts.push_back(*start);
    seed_taper(starts);
    return starts;
}

}  // namespace

FitReport fit_bounding(const mesh::Mesh& mesh, std::span<const std::uint32_t> triangles, std::span<const Corners> cap_triangles,
                       const FitOptions& options)
{
    const Part part = prepare(mesh, triangles, cap_triangles, options);
    FitReport report;

    std::vector<Candidate> closed;
    std::vector<Superquadricd> starts;
    for (int axis = 0; axis < 3; ++axis) {
        closed.push_back(closed_form(part, with_z_axis(part.frame, axis), part.extreme, options));
        starts.push_back(closed.back().sq);
        if (!shrink_wrap(closed.back().sq, part.points)) closed.back().volume = k_infinity;
    }
    const auto less = [](const Candidate& a, const Candidate& b) { return a.volume < b.volume; };
    const Candidate plain_bound = *std::min_element(closed.begin(), closed.end(), less);

    std::vector<Candidate> ranked;  // each pays for what it adds to those before
    const auto consider = [&](const Candidate& c, double gain) {
        const double limit = ranked.empty() ? plain_bound.volume : ranked.back().volume;
        if (c.volume < (1 - gain) * limit && !overhangs(c.sq, part.points, part.least_a, 1.1 * options.max_overhang))
            ranked.push_back(c);
    };
    const DataFit data = fit_data_from<k_plain>(part, starts, options, 1, report.iterations);
    const auto smallest_from = [&]<int N>(std::span<const Superquadricd> from) {
        Candidate best;
        for (const Superquadricd& start : from)
            best = std::min(best, fit_volume<N>(part, start, options, k_short, report.iterations), less);
        if (!(best.volume < k_infinity)) return best;
        return std::min(best, fit_volume<N>(part, best.sq, options, k_long, report.iterations), less);
    };
    starts.push_back(data.sq);
    consider(smallest_from.operator()<k_plain>(starts), 0);

    const Candidate plain = ranked.empty() ? plain_bound : ranked.back();
    if (options.allow_taper) {
        starts.back() = plain.sq;
        seed_taper(starts);
        consider(smallest_from.operator()<k_tapered>(starts), options.taper_gain);
    }
    if (options.allow_bend) {
        std::vector<Superquadricd> bent = bent_starts(part, options, false);
        if (!bent.empty()) {
            bent.push_back(fit_data_from<k_bent>(part, bent, options, 1, report.iterations).sq);
            consider(smallest_from.operator()<k_bent>(bent), options.bend_gain);
        }
    }
    // The proof may ask for some room: more than a little of it, and the simpler shape before is the better one.
    report.fallback = true;
    for (auto c = ranked.rbegin(); c != ranked.rend() && report.fallback; ++c) {
        const double before = c + 1 == ranked.rend() ? plain_bound.volume : (c + 1)->volume;
        if (!finish(part, c->sq, report) || report.volume > 1.02 * before * part.size * part.size * part.size) continue;
        report.fallback = false;
        report.converged = c->converged && data.converged;
    }
    if (report.fallback && !finish(part, plain_bound.sq, report)) {
        // A ball about everything: reached only when all else has failed.
        Superquadricd ball;
        ball.a = {1.01, 1.01, 1.01};
        finish(part, ball, report);
    }
    report.rms = radial_rms(part, report.superquadric);
    return report;
}

FitReport fit_surface(const mesh::Mesh& mesh, std::span<const std::uint32_t> triangles, const FitOptions& options)
{
    const Part part = prepare(mesh, triangles, {}, options);
    FitReport report;
    std::vector<Superquadricd> starts;
    for (int axis = 0; axis < 3; ++axis)
        starts.push_back(closed_form(part, with_z_axis(part.frame, axis), part.extreme, options).sq);
    DataFit best = fit_data_from<k_plain>(part, starts, options, starts.size(), report.iterations);
    const auto consider = [&](const DataFit& c) {
        if (c.cost < 0.8 * best.cost && best.cost > k_exact_cost) best = c;
    };
    starts.push_back(best.sq);
    seed_taper(starts);
    if (options.allow_taper) consider(fit_data_from<k_tapered>(part, starts, options, starts.size(), report.iterations));
    if (options.allow_bend) {
        const std::vector<Superquadricd> bent = bent_starts(part, options, true);
        if (!bent.empty()) consider(fit_data_from<k_bent>(part, bent, options, bent.size(), report.iterations));
    }
    report.converged = best.converged;
    Superquadricd sq = best.sq;
    scale_by(sq, part.size);
    sq.translation = part.middle + part.size * sq.translation;
    round_to_float(sq);
    report.superquadric = sq;
    report.certificate = certify(sq, part.corners, part.faces);
    report.volume = volume(sq);
    report.rms = radial_rms(part, sq);
    return report;
}

}  // namespace sqmap::fit
