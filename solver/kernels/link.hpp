// Links between two bodies, or a body and the ground: springs with gaps, dashpots, yield and fracture.
//
// A link is axial, along the line between its ends, or acts in d directions, along axes that turn with
// its first body. Along each it has an extension e and a force F(e), positive in tension, which is
// monotone and piecewise linear. Over a step it acts with its mean over the way,
//
//     P = -dt/(e_1 - e_0) int F de - c (rho_1 - rho_0),                                         (M61)
//
// rho being the extension beyond the gap: the work of the spring is then the change of its energy, and
// what the dashpot takes is never negative. In the local problem a link is a contact with another law:
// P = f(y) with y the rate of extension, found from the trial P - r y that all laws are given.
#pragma once

#include <vector>

#include "shape.hpp"

namespace rockslip {

/// The law of a link along one direction.
struct LinkLaw {
    double stiffness = 0;       // k, N/m
    double damping = 0;         // c, N s/m
    double gap = 0;             // extension before it resists, m; below 0: preload over stiffness
    bool compression = true;    // whether it resists shortening, too
    double yield = INFINITY;    // force at which it flows, N

    /// The extension beyond the gap, m, signed: rho.
    double beyond(double elastic) const {
        if (elastic > gap) return elastic - gap;
        if (compression && gap >= 0) return std::min(elastic + gap, 0.0);
        return compression ? elastic - gap : 0;
    }
    double force(double elastic) const { return std::clamp(stiffness * beyond(elastic), -yield, yield); }
    double energy(double elastic) const {
        const double rho = beyond(elastic);
        return 0.5 * stiffness * rho * rho;
    }
    /// Derivative of the force.
    double slope(double elastic) const {
        const double rho = beyond(elastic);
        return rho != 0 && std::fabs(stiffness * rho) < yield ? stiffness : 0;
    }

    /// Mean of the force over the way between two elastic extensions, and its derivative over the second.
    std::array<double, 2> mean_force(double from, double to) const {
        const double flows = yield / stiffness;
        std::array<double, 6> at{from, gap, -gap, gap + flows, (gap < 0 ? gap : -gap) - flows, to};
        const double low = std::min(from, to), high = std::max(from, to);
        double sum = 0, before = low;
        bool bent = false;
        std::sort(at.begin(), at.end());
        for (const double each : at) {
            if (!(each > before) || each > high) continue;
            sum += 0.5 * (force(before) + force(each)) * (each - before);
            bent |= each < high;
            before = each;
        }
        if (!(high > low)) return {force(from), 0.5 * slope(from)};
        const double mean = sum / (high - low);
        return {mean, bent ? (force(to) - mean) / (to - from) : 0.5 * slope(0.5 * (from + to))};
    }

    /// Impulse of a step of dt between two elastic extensions (M61), and its derivative over the second.
    std::array<double, 2> impulse(double from, double to, double dt) const {
        const auto [mean, slope] = mean_force(from, to);
        const double damped = damping * (beyond(to) - beyond(from));
        const double total = -dt * mean - damped;
        if (!compression && total > 0) return {0, 0};  // it cannot push
        return {total, -(dt * slope + (beyond(to) != 0 ? damping : 0))};
    }

    /// By how much the plastic part changes at an elastic extension, m.
    double flow(double elastic) const {
        const double rho = beyond(elastic), over = std::fabs(rho) - yield / stiffness;
        return over > 0 ? std::copysign(over, rho) : 0;
    }
};

/// A link and its state.
template <int d> struct Link {
    int a = 0, b = 0;           // bodies of the first and the second end
    bool axial = true;
    Vec<d> end_a{}, end_b{};    // places of the ends in the frames of their bodies, about the centres, m
    Mat<d, d> axes{};           // of a link in d directions, in the frame of the first body
    Vec<d> length{};            // at which the extensions count as 0, m: the distance of the ends, axial; else its components
    std::array<LinkLaw, static_cast<std::size_t>(d)> laws{};  // axial: the first alone
    double strength = INFINITY;  // force at which it breaks, N

    Vec<d> plastic{};           // m
    Vec<d> force{};             // of the last piece of a step, N, in tension
    Vec<d> mean{};              // of the forces over the last step, N
    Vec<d> extension{};         // at its end, m
    bool broken = false;
    double broken_at = 0;       // s
    double lost = 0;            // energy that it had when it broke, J

    int directions() const { return axial ? 1 : d; }

    /// The extensions for bodies at two places.
    Vec<d> measure(const Placement<d>& of_a, const Placement<d>& of_b) const {
        const Vec<d> between = (of_b.centre - of_a.centre) + (mul(of_b.R, end_b) - mul(of_a.R, end_a));
        Vec<d> found{};
        if (axial) found[0] = norm(between) - length[0];
        else
            for (int i = 0; i < d; i++) found[i] = dot(mul(of_a.R, axes[i]), between) - length[i];
        return found;
    }

    /// Size of the spring force at extensions, N.
    double load(const Vec<d>& extensions) const {
        Vec<d> found{};
        for (int i = 0; i < directions(); i++) found[i] = laws[i].force(extensions[i] - plastic[i]);
        return norm(found);
    }

    /// Takes the extensions at the end of a step; returns what flow and dashpots took, by the work on the bodies, J.
    double take(const Vec<d>& extensions, double work) {
        const double before = energy();
        extension = extensions;
        for (int i = 0; i < directions(); i++) plastic[i] += laws[i].flow(extension[i] - plastic[i]);
        return before - work - energy();
    }

    /// Breaks; returns the energy that is lost, J.
    double fracture(double when) {
        lost = energy();
        broken = true;
        broken_at = when;
        return lost;
    }
    double energy() const {
        double sum = 0;
        if (!broken)
            for (int i = 0; i < directions(); i++) sum += laws[i].energy(extension[i] - plastic[i]);
        return sum;
    }
};

/// What the local problem knows of a link in a step along all its directions.
template <int d> struct LinkStep {
    const Link<d>* link = nullptr;
    double dt = 0;  // s

    double way(double rate) const { return 0.5 * dt * rate; }

    /// Impulse at a rate of extension y (sum of both ends of the step, m/s), and its derivative.
    std::array<double, 2> impulse(int direction, double rate) const {
        const double from = link->extension[direction] - link->plastic[direction];
        const auto [impulse, slope] = link->laws[direction].impulse(from, from + way(rate), dt);
        return {impulse, 0.5 * dt * slope};
    }

    /// The impulse with P = f((P - trial)/r), and its derivative over the trial.
    ///
    /// P - f is monotone: Newton's method within a bracket.
    std::array<double, 2> answer(int direction, double trial, double r) const {
        const auto value = [&](double P) {
            const auto [f, slope] = impulse(direction, (P - trial) / r);
            return std::array<double, 2>{P - f, 1 - slope / r};
        };
        double P = trial;
        double off = value(P)[0], slope = value(P)[1];
        double low = -INFINITY, high = INFINITY;
        for (int round = 0; round < 100 && off != 0; round++) {
            (off > 0 ? high : low) = P;
            double next = P - off / slope;
            if (next == P) break;
            if (next <= low || next >= high) next = 0.5 * (low + high);
            if (!std::isfinite(next) || next == P) break;
            const double step = next - P;
            P = next;
            const auto there = value(P);
            off = there[0];
            slope = there[1];
            if (std::fabs(step) <= 1e-16 * std::fabs(P)) break;
        }
        return {P, 1 - 1 / slope};
    }
};

}  // namespace rockslip
