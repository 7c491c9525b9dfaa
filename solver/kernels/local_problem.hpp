// The law of contact for all contacts of an island at once:
//
//     y = c + G w,   M (w - w_free) = G^T P,                                              (M55)
//     0 <= P_n  complementary to  y_n >= 0,   |P_t| <= mu P_n + c, y_t opposite to P_t at the bound, 0 inside,
//
// as roots of P - project(P - r y) (Alart and Curnier 1991). Newton's method solves for the motions w
// of the bodies, by sparse factors of M + G^T H G. Rows of rigid bodies are redundant as a rule: the
// proximal term q W_own (P - anchor), added to y, makes the impulses unique; the proximal point algorithm
// takes what it leaves of the law out again, as far as round-off lets it. Where Newton's method cycles
// through states, a softer term holds it.
#pragma once

#include <unordered_map>

#include "island.hpp"

namespace rockslip {

/// How often what was needed.
struct Outcomes {
    long solves = 0, warm = 0, newton = 0, factorizations = 0;
    long softened = 0, failed = 0, loose = 0;
    double loosest = 0;
};

template <int d> class LocalProblem {
    static constexpr int unknowns = Dim<d>::unknowns;
    using Motion = Vec<unknowns>;
    using C = Contact<d>;
    using I = Island<d>;

  public:
    Outcomes outcomes;
    double tolerated_breach = 0;  // of y, m/s, in what counts as solved though round-off is left

    /// Finds impulses and motions from the impulses as guessed; false where nothing settles them.
    bool solve(I& island) {
        outcomes.solves++;
        set_compliances(island);
        island.move();
        island.factored_stamp = -1;
        if (error(island, 0) <= ENOUGH) {
            outcomes.warm++;
            return true;
        }
        save(island, first_);
        anchor_.resize(island.contacts.size());
        for (std::size_t i = 0; i < anchor_.size(); i++) anchor_[i] = island.contacts[i]->anchor;
        if (newton(island, SOFTNESS, FEW_STEPS)) return true;
        outcomes.softened++;
        restore(island, first_);
        if (is_solved(by_proximal_point(island, SOFT, ENOUGH, PATIENCE))) return true;
        for (C* k : island.contacts) k->impulse.fill(0);
        island.move();
        if (is_solved(by_proximal_point(island, SOFT, ENOUGH, PATIENCE))) return true;
        outcomes.failed++;
        restore(island, first_);
        return false;
    }

    /// Takes out what the proximal term has left of the law; with final rows. False where more than
    /// round-off is left of it. Forces at rest are to last: they are brought further.
    bool finish(I& island, bool at_rest = false) {
        const double e = by_proximal_point(island, SOFTNESS, at_rest ? SHARP : ENOUGH, MORE_PATIENCE);
        loose_ = e > ENOUGH;
        if (loose_) {
            outcomes.loose++;
            outcomes.loosest = std::max(outcomes.loosest, e);
        }
        return is_solved(e);
    }

    /// Impulses that the law admits and that obey it nearly, where nothing settles them: near the best
    /// ones of the proximal point algorithm.
    bool approximate(I& island) {
        restore(island, best_);
        for (C* k : island.contacts) {
            State state{};
            if (!k->link) k->impulse = project<d>(k->bound, k->mode, k->given, k->impulse, state, nullptr);
        }
        return take(island);
    }

    /// Whether the last `finish` left more of the law than is tolerated.
    bool is_loose() const { return loose_; }

    /// Takes impulses that do not obey the law, as far as they gain no energy, and writes motions and y;
    /// false beyond numbers.
    bool take(I& island) {
        const bool finite = take_back_gain(island);
        largest_defect = std::max(largest_defect, breach_);
        return finite;
    }

    /// Reduces the impulses of contacts in a step to what gains no energy, and writes motions and y; false
    /// beyond numbers. Springs of links may give back what they took.
    bool take_back_gain(I& island) {
        island.move();
        // P.G w is twice the work of the impulses, of which P.G M^-1 G^T P grows with their square.
        x_.assign(island.w.size(), {});
        double work = 0, own = 0;
        for (const C* k : island.contacts)
            if (!k->link) {
                work += dot(k->impulse, island.moved(*k, island.w));
                island.push(*k, k->impulse, x_);
            }
        for (std::size_t b = 0; b < x_.size(); b++) own += dot(x_[b], mul(island.inverse_mass[b], x_[b]));
        if (work > 0)
            for (C* k : island.contacts)
                if (!k->link) k->impulse = std::max(1 - work / own, 0.0) * k->impulse;
        return keep(island);
    }

    /// Keeps the impulses, whatever the law says, and writes motions and y; false beyond numbers.
    bool keep(I& island) {
        island.move();
        return std::isfinite(error(island, 0));
    }

    double largest_defect = 0;  // of y in what was taken unsettled, m/s

  private:
    static constexpr double TOLERANCE = 1e-12;         // of an impulse, relative to the largest of its contact
    static constexpr double ROUND_OFF = 64 * 2.2e-16;  // relative to the largest of all
    static constexpr double ENOUGH = 10;               // times what is tolerated: no need to go on
    static constexpr double SHARP = 0.01;              // the same for forces at rest, which are to last
    static constexpr double SOFTNESS = 1e-5;           // q of the proximal term
    static constexpr double SOFT = 1e-2;               // the same where Newton's method does not settle with that
    static constexpr double HARDEST = 1e-9;            // least q, where bodies are nearly wedged
    static constexpr double MOST_HELD = 3;             // of the compliance in it, times the least in the island
    static constexpr double SOFTEST = 1e4;
    static constexpr double FOLLOWED = 0.1;            // part of the coefficient of friction by which normal r are shorter
    static constexpr int FEW_STEPS = 10, STEPS = 20, PROXIMAL_ROUNDS = 80;
    static constexpr int PATIENCE = 2, MORE_PATIENCE = 8;  // settled rounds without a gain: while rows may change, and then

    /// Whether no more than round-off is left of the law after the last look, which found an error.
    bool is_solved(double e) const { return breach_ < tolerated_breach || (e < 1e6 && breach_ < 3 * tolerated_breach); }

    /// The proximal point algorithm: Newton's method again and again, with the term held at the last
    /// solution, softer where that does not settle and harder from solution to solution; until the law
    /// holds, or is broken by no more than is tolerated and gets little better in a number of rounds.
    /// Returns the error of the best impulses, which are kept.
    double by_proximal_point(I& island, double q, double enough, int patience) {
        double e = error(island, 0), least = e;
        bool solved = is_solved(e);
        int stalled = 0;
        save(island, best_);
        for (int round = 0; round < PROXIMAL_ROUNDS && (e > enough || !solved) && q <= SOFTEST; round++) {
            save(island, anchor_);
            const bool settled = newton(island, q, STEPS, std::min({enough, 1.0, 0.1 * e}));
            if (!settled) restore(island, anchor_);
            e = error(island, 0);
            const bool gains = e <= 0.5 * least;
            if (settled) stalled = gains ? 0 : stalled + 1;
            if (e < least) {
                least = e;
                solved = is_solved(e);
                save(island, best_);
            }
            if (solved && !gains && (least <= ENOUGH || stalled >= patience)) break;
            // A harder term than at first is less exact where impulses are not unique.
            const double hardest = stalled > 0 ? HARDEST : std::min(SOFTNESS, q);
            q = settled ? std::max(hardest, 0.3 * q) : 5 * q;
        }
        if (e > least) {
            restore(island, best_);
            e = error(island, 0);
        }
        return e;
    }

    static void save(const I& island, std::vector<Vec<d>>& impulses) {
        impulses.resize(island.contacts.size());
        for (std::size_t i = 0; i < impulses.size(); i++) impulses[i] = island.contacts[i]->impulse;
    }

    static void restore(I& island, const std::vector<Vec<d>>& impulses) {
        for (std::size_t i = 0; i < impulses.size(); i++) island.contacts[i]->impulse = impulses[i];
        island.move();
    }

    /// The compliance in the proximal term: own, but not more than what moves the heaviest bodies allows.
    static double held_compliance(const I& island, std::size_t contact, int tangential) {
        return std::min(island.own[contact][tangential], MOST_HELD * island.least[tangential]);
    }

    /// The impulse of a contact, or a link, nearest to a trial P - r y; its derivative, where wanted.
    static Vec<d> admissible(const C& k, const Vec<d>& trial, const std::array<double, 2>& r, State& state, Mat<d, d>* derivative) {
        if (k.link) return of_link(k, trial, r, state, derivative);
        return project<d>(k.bound, k.mode, k.given, trial, state, derivative);
    }

    [[gnu::noinline]] static Vec<d> of_link(const C& k, const Vec<d>& trial, const std::array<double, 2>& r, State& state, Mat<d, d>* derivative) {
        Vec<d> p{};
        if (derivative) *derivative = {};
        state = GIVEN;
        for (int i = 0; i < k.link->link->directions(); i++) {
            const auto [impulse, slope] = k.link->answer(i, trial[i], r[i > 0]);
            p[i] = impulse;
            if (derivative) (*derivative)[i][i] = slope;
        }
        return p;
    }

    static double own_compliance(const Mat<d, unknowns>& rows, const Mat<unknowns, unknowns>& inverse_mass, int first, int last) {
        double most = 0;
        for (int row = first; row < last; row++) most = std::max(most, dot(rows[row], mul(inverse_mass, rows[row])));
        return most;
    }

    /// r of a contact, normal and tangential: one over the diagonal of W, and with the proximal term of that, too;
    /// Newton's method cycles with a normal one that is not shorter the faster friction follows.
    static std::array<double, 2> lengths(const I& island, std::size_t contact, double softness) {
        std::array<double, 2> r;
        for (int t = 0; t < 2; t++) {
            const double own = island.own[contact][t] + softness * held_compliance(island, contact, t);
            r[t] = own > 0 ? 1 / own : 1;
        }
        if (softness > 0) r[0] /= 1 + FOLLOWED * island.contacts[contact]->bound.mu;
        return r;
    }

    /// own: the diagonal of W; share: what it is of the row sums of |W|, which Schwarz' inequality bounds.
    void set_compliances(I& island) {
        const std::size_t count = island.contacts.size();
        sum_.assign(island.w.size(), {0, 0});
        part_.resize(count);
        island.share.resize(count);
        island.own.resize(count);
        for (std::size_t i = 0; i < count; i++) {
            const C& k = *island.contacts[i];
            for (int side = 0; side < 2; side++) {
                const int body = side ? k.b : k.a;
                part_[i][side] = {0, 0};
                if (body < 0) continue;
                const Mat<d, unknowns>& rows = side ? k.rows_b : k.rows_a;
                part_[i][side] = {own_compliance(rows, island.inverse_mass[body], 0, 1),
                                  own_compliance(rows, island.inverse_mass[body], 1, d)};
                for (int t = 0; t < 2; t++) sum_[body][t] += std::sqrt(part_[i][side][t]);
            }
        }
        for (std::size_t i = 0; i < count; i++) {
            const C& k = *island.contacts[i];
            for (int t = 0; t < 2; t++) {
                double all = 0;
                island.own[i][t] = 0;
                for (int side = 0; side < 2; side++) {
                    const int body = side ? k.b : k.a;
                    if (body < 0) continue;
                    all += std::sqrt(part_[i][side][t]) * sum_[body][t];
                    island.own[i][t] += part_[i][side][t];
                }
                island.share[i][t] = all > 0 ? island.own[i][t] / all : 1;
            }
        }
        island.least = {INFINITY, INFINITY};
        for (std::size_t i = 0; i < count; i++)
            for (int t = 0; t < 2; t++)
                if (!island.contacts[i]->link) island.least[t] = std::min(island.least[t], island.own[i][t]);
    }

    /// Difference between P and its projection, 1 being what is tolerated; infinite beyond numbers.
    /// Writes y, trials, states and the breach.
    double error(I& island, double softness) {
        const std::size_t count = island.contacts.size();
        trial_.resize(count);
        largest_.resize(count);
        defect_.resize(count);
        double noise = 0;
        breach_ = 0;
        for (std::size_t i = 0; i < count; i++) {
            C& k = *island.contacts[i];
            const auto &share = island.share[i], r = lengths(island, i, softness);
            k.y = island.reading(k);
            if (softness > 0)
                for (int j = 0; j < d; j++) k.y[j] += softness * held_compliance(island, i, j > 0) * (k.impulse[j] - anchor_[i][j]);
            double moved = 0;
            for (int side = 0; side < 2; side++) {
                const int body = side ? k.b : k.a;
                if (body < 0) continue;
                for (int j = 0; j < unknowns; j++) moved += std::fabs((side ? k.rows_b : k.rows_a)[0][j] * island.w[body][j]);
            }
            largest_[i] = defect_[i] = 0;
            for (int j = 0; j < d; j++) {
                const double length = r[j > 0], step = length * k.y[j];
                trial_[i][j] = k.impulse[j] - step;
                noise = std::max({noise, std::fabs(k.impulse[j]), share[j > 0] * std::fabs(step), share[j > 0] * length * moved});
            }
            const Vec<d> nearest = admissible(k, trial_[i], r, k.state, nullptr);
            for (int j = 0; j < d; j++) {
                const double F = k.impulse[j] - nearest[j];
                largest_[i] = std::max(largest_[i], std::fabs(k.impulse[j]));
                defect_[i] = std::max(defect_[i], share[j > 0] * std::fabs(F));
                breach_ = std::max(breach_, std::fabs(F) / std::min(r[0], r[1]));
            }
        }
        if (!std::isfinite(noise)) return INFINITY;
        double worst = 0;
        for (std::size_t i = 0; i < count; i++) {
            if (!(defect_[i] > 0)) continue;
            worst = std::max(worst, defect_[i] / (TOLERANCE * largest_[i] + ROUND_OFF * noise));
        }
        return worst;
    }

    BlockLU<unknowns>& factors_for(const I& island) {
        if (island.w.size() == 1) {
            if (single_.size() != 1) single_.analyse(1, {});
            return single_;
        }
        std::uint64_t hash = island.w.size();
        for (const C* k : island.contacts)
            hash = (hash ^ ((static_cast<std::uint64_t>(k->a + 1) << 32) + static_cast<std::uint64_t>(k->b + 1))) * 1099511628211u;
        if (patterns_.size() > 200) patterns_.clear();
        BlockLU<unknowns>& found = patterns_[hash];
        if (found.size() != static_cast<int>(island.w.size())) {
            std::vector<std::pair<int, int>> links;
            for (const C* k : island.contacts)
                if (k->a >= 0 && k->b >= 0) links.push_back({k->a, k->b});
            found.analyse(static_cast<int>(island.w.size()), links);
        }
        return found;
    }

    /// Newton's method on the law with the proximal term, with full steps.
    bool newton(I& island, double softness, int steps, double target = 1) {
        const std::size_t count = island.contacts.size();
        stiffness_.resize(count);
        change_.resize(count);
        if (island.factored.size() != count) {
            island.factored.assign(count, -1);
            island.factored_stamp = -1;
        }
        BlockLU<unknowns>* factors = nullptr;
        double e = error(island, softness);
        for (int step = 0; e > target; step++) {
            if (step == steps || !(e < INFINITY)) return false;
            outcomes.newton++;
            if (!factors) factors = &factors_for(island);
            if (!linearise(island, softness, *factors)) return false;
            take_step(island, *factors);
            island.move();
            e = error(island, softness);
        }
        return true;
    }

    /// Writes H and h of each contact, P = P_now + h - H G x, and factorizes where states have changed.
    bool linearise(I& island, double softness, BlockLU<unknowns>& factors) {
        bool same = factors.stamp == island.factored_stamp && island.factored_softness == softness;
        for (std::size_t i = 0; i < island.contacts.size(); i++) {
            const C& k = *island.contacts[i];
            Mat<d, d> J;
            LU<d> K;
            State state{};
            const std::array<double, 2> r = lengths(island, i, softness);
            const Vec<d> nearest = admissible(k, trial_[i], r, state, &J);
            const int mark = static_cast<int>(state);
            // Slip in space turns its direction from iteration to iteration, and links bend.
            same = same && island.factored[i] == mark && (d == 2 || state != SLIP) && !k.link;
            island.factored[i] = mark;
            for (int a = 0; a < d; a++)
                for (int b = 0; b < d; b++) {
                    const double moved = r[b > 0] * J[a][b];
                    K.a[a][b] = (a == b) - J[a][b] + moved * softness * held_compliance(island, i, b > 0);
                    J[a][b] = moved;
                }
            if (!K.factorize()) return false;
            K.solve(J);
            stiffness_[i] = J;
            change_[i] = nearest - k.impulse;
            K.solve(change_[i]);
        }
        if (same) return true;
        island.assemble(stiffness_, factors);
        outcomes.factorizations++;
        island.factored_softness = softness;
        factors.stamp = island.factored_stamp = ++stamps_;
        if (factors.factorize()) return true;
        island.factored_stamp = -1;
        return false;
    }

    void take_step(I& island, BlockLU<unknowns>& factors) {
        x_.assign(island.w.size(), {});
        const std::size_t count = island.contacts.size();
        for (std::size_t i = 0; i < count; i++) island.push(*island.contacts[i], change_[i], x_);
        factors.solve(x_);
        for (std::size_t i = 0; i < count; i++) {
            C& k = *island.contacts[i];
            k.impulse += change_[i] - mul(stiffness_[i], island.moved(k, x_));
        }
    }

    double breach_ = 0;  // of the law at most, m/s, after the last look
    bool loose_ = false;
    long stamps_ = 0;
    BlockLU<unknowns> single_;
    std::unordered_map<std::uint64_t, BlockLU<unknowns>> patterns_;
    std::vector<double> largest_, defect_;
    std::vector<std::array<double, 2>> sum_;
    std::vector<std::array<std::array<double, 2>, 2>> part_;
    std::vector<Vec<d>> trial_, change_, anchor_, first_, best_;
    std::vector<Mat<d, d>> stiffness_;
    std::vector<Motion> x_;
};

}  // namespace rockslip
