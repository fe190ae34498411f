// Bounding superquadrics for parts: Moustakas, Tzovaras and Strintzis, SQ-Map, section 2.
//
// Data term: Solina and Bajcsy, Recovery of parametric models from range images (1990), with the radial distance of Gross
// and Boult (1988) as residual by default: a departure from eq. 3, whose minimum is biased towards points near the centre.
// Bounding: least volume under f <= 1 by an augmented Lagrangian, see problems.h; the closed form F(s x) = s^2 F(x) then
// makes containment exact, and certify() proves it for the stored parameters, which are rounded to float.
#include "sqmap/fit/fit.h"

#include "scaled_part.h"
#include "searches.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace sqmap::fit {

using shape::Superquadricd;

namespace {

constexpr int k_short = 3, k_long = 8;  ///< rounds of the augmented Lagrangian, to rank starts and to finish one
constexpr double k_exact_cost = 1e-10;  ///< of eq. 3 in the part's units: nothing left to explain by deforming

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
bool finish(const ScaledPart& part, Superquadricd sq, FitReport& report)
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

double radial_rms(const ScaledPart& part, Superquadricd sq)
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

/// Shapes with more and more freedom, each of less volume by its own gain than those before it.
struct Ranking {
    std::vector<Candidate> shapes;
    Candidate closed;  ///< the smallest closed form: the answer if no search succeeds
    bool data_settled = false;
    int iterations = 0;
};

/// Least volume of all starts: a short search from each, a long one from the best.
template <int N>
Candidate smallest_from(const ScaledPart& part, std::span<const Superquadricd> starts, const FitOptions& options)
{
    Candidate best;
    int spent = 0;
    const auto offer = [&](const Superquadricd& start, int rounds) {
        const Candidate found = least_volume<N>(part, start, options, rounds);
        spent += found.iterations;
        if (found.volume < best.volume) best = found;
    };
    for (const Superquadricd& start : starts) offer(start, k_short);
    if (best.volume < INFINITY) offer(best.sq, k_long);
    best.iterations = spent;
    return best;
}

Ranking rank_shapes(const ScaledPart& part, const FitOptions& options)
{
    Ranking ranking;
    std::vector<Superquadricd> starts;
    for (int axis = 0; axis < 3; ++axis) {
        Candidate closed = closed_form(part, with_z_axis(part.frame, axis), options);
        starts.push_back(closed.sq);
        if (!shrink_wrap(closed.sq, part.points)) closed.volume = INFINITY;
        if (axis == 0 || closed.volume < ranking.closed.volume) ranking.closed = closed;
    }
    const auto smallest = [&]() -> const Candidate& { return ranking.shapes.empty() ? ranking.closed : ranking.shapes.back(); };
    const auto consider = [&](const Candidate& c, double gain) {
        ranking.iterations += c.iterations;
        if (c.volume < (1 - gain) * smallest().volume && !overhangs(c.sq, part, options.max_overhang))
            ranking.shapes.push_back(c);
    };
    const DataFit data = fit_data<k_plain>(part, starts, options, 1);
    ranking.data_settled = data.converged;
    ranking.iterations = data.iterations;
    starts.push_back(data.sq);
    consider(smallest_from<k_plain>(part, starts, options), 0);
    if (options.allow_taper) {
        starts.back() = smallest().sq;
        seed_taper(starts);
        consider(smallest_from<k_tapered>(part, starts, options), options.taper_gain);
    }
    if (!options.allow_bend) return ranking;
    std::vector<Superquadricd> bent = bent_starts(part, options, false);
    if (bent.empty()) return ranking;
    const DataFit bent_data = fit_data<k_bent>(part, bent, options, 1);
    ranking.iterations += bent_data.iterations;
    bent.push_back(bent_data.sq);
    consider(smallest_from<k_bent>(part, bent, options), options.bend_gain);
    return ranking;
}

}  // namespace

FitReport fit_bounding(const mesh::Mesh& mesh, std::span<const std::uint32_t> triangles, std::span<const Corners> cap_triangles,
                       const FitOptions& options)
{
    const ScaledPart part = scaled_part(mesh, triangles, cap_triangles, options);
    const Ranking ranking = rank_shapes(part, options);
    FitReport report;
    report.iterations = ranking.iterations;
    // The proof may enlarge the shape: if by more than a little, the simpler shape before is the better one.
    report.fallback = true;
    const std::vector<Candidate>& shapes = ranking.shapes;
    for (auto c = shapes.rbegin(); c != shapes.rend() && report.fallback; ++c) {
        const double before = c + 1 == shapes.rend() ? ranking.closed.volume : (c + 1)->volume;
        if (!finish(part, c->sq, report) || report.volume > 1.02 * before * part.size * part.size * part.size) continue;
        report.fallback = false;
        report.converged = c->converged && ranking.data_settled;
    }
    if (report.fallback && !finish(part, ranking.closed.sq, report)) {
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
    const ScaledPart part = scaled_part(mesh, triangles, {}, options);
    FitReport report;
    std::vector<Superquadricd> starts;
    for (int axis = 0; axis < 3; ++axis) starts.push_back(closed_form(part, with_z_axis(part.frame, axis), options).sq);
    DataFit best = fit_data<k_plain>(part, starts, options, starts.size());
    report.iterations = best.iterations;
    const auto consider = [&](const DataFit& c) {
        report.iterations += c.iterations;
        if (c.cost < 0.8 * best.cost && best.cost > k_exact_cost) best = c;
    };
    starts.push_back(best.sq);
    seed_taper(starts);
    if (options.allow_taper) consider(fit_data<k_tapered>(part, starts, options, starts.size()));
    if (options.allow_bend) {
        const std::vector<Superquadricd> bent = bent_starts(part, options, true);
        if (!bent.empty()) consider(fit_data<k_bent>(part, bent, options, bent.size()));
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
