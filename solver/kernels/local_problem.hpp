// The law of contact for all contacts of an island at once:
//
//     y = c + G w,   M (w - w_free) = G^T P,                                              (M55)
//     0 <= P_n  complementary to  y_n >= 0,   |P_t| <= mu P_n + c, y_t opposite to P_t at the bound, 0 inside,
//
// as roots of P - project(P - r y) (Alart and Curnier 1991). Newton's method solves for the motions w
// of the bodies, by sparse factors of M + G^T H G. Rows of rigid bodies are redundant as a rule: the
// proximal term q W_own (P - anchor), added to y, makes the impulses unique; what it leaves of the law
// is taken out at the end as far as round-off lets it (`finish`). Where Newton's method cycles through
// states, `interior_point.hpp` finds where it goes on from.
#pragma once

#include <unordered_map>

#include "interior_point.hpp"

namespace rockslip {

/// How often what was needed.
struct Outcomes {
    long solves = 0, warm = 0, newton = 0, factorizations = 0, searched = 0;
    long softened = 0, interior = 0, failed = 0, loose = 0;
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
        set_lengths(island);
        island.move();
        island.factored_stamp = -1;
        if (error(island, 0) <= ENOUGH) {
            outcomes.warm++;
            return true;
        }
        save(island, first_);
        if (by_proximal_point(island)) return true;
        for (Start start : {Start::INTERIOR, Start::STUCK}) {
            restore(island, first_);
            if (!begin_at(island, start)) continue;
            for (C* k : island.contacts) k->anchor = k->impulse;
            if (by_proximal_point(island)) return true;
        }
        outcomes.failed++;
        restore(island, first_);
        return false;
    }

    /// Takes out what the proximal term has left of the law; with final rows. False where more than
    /// round-off is left of it. Forces at rest are to last: they are brought further.
    bool finish(I& island, bool at_rest = false) {
        double e = refine(island, at_rest);
        // With much friction the law with the term has solutions of its own, far from those without.
        for (Start start : {Start::INTERIOR, Start::STUCK}) {
            if (is_solved(e)) break;
            const double breach = breach_;
            save(island, first_);
            if (begin_at(island, start)) e = refine(island, at_rest);
            else breach_ = INFINITY;
            if (breach_ < breach) continue;
            restore(island, first_);
            e = error(island, 0);
        }
        loose_ = e > ENOUGH;
        if (loose_) {
            outcomes.loose++;
            outcomes.loosest = std::max(outcomes.loosest, e);
        }
        return is_solved(e);
    }

    /// Impulses that the law admits and that obey it nearly, where nothing settles them.
    bool approximate(I& island) {
        sweep(island);
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

    /// By how much the law is broken at most, m/s, after the last look.
    double breach() const { return breach_; }

  private:
    static constexpr double TOLERANCE = 1e-12;         // of an impulse, relative to the largest of its contact
    static constexpr double ROUND_OFF = 64 * 2.2e-16;  // relative to the largest of all
    static constexpr double ENOUGH = 10;               // times what is tolerated: no need to go on
    static constexpr double SOFTNESS = 1e-5;           // q of the proximal term
    static constexpr double HARDEST = 1e-9;            // least q, where the law is nearly singular
    static constexpr double MOST_HELD = 3;             // of the compliance in it, times the least in the island
    static constexpr double SOFTEST = 1e4;
    static constexpr int FULL_STEPS = 10, ROUNDS = 60, PROXIMAL_ROUNDS = 40, FINISHING_ROUNDS = 30, SWEEPS = 1500;

    /// From where Newton's method goes on when it has failed.
    enum class Start {
        INTERIOR,  // what the interior point method finds
        STUCK,     // all that presses sticks: bodies that are wedged hold themselves so
    };

    /// Writes the impulses of a start; false where it is not found.
    bool begin_at(I& island, Start start) {
        if (start == Start::INTERIOR) {
            outcomes.interior++;
            return interior_point_.solve(island, factors_for(island));
        }
        friction_.resize(island.contacts.size());
        for (std::size_t i = 0; i < friction_.size(); i++) {
            friction_[i] = island.contacts[i]->bound.mu;
            if (friction_[i] > 0) island.contacts[i]->bound.mu = INFINITY;
        }
        const bool found = by_proximal_point(island);
        for (std::size_t i = 0; i < friction_.size(); i++) island.contacts[i]->bound.mu = friction_[i];
        return found;
    }

    /// Whether no more than round-off is left of the law after the last look, which found an error.
    bool is_solved(double e) const { return breach_ < tolerated_breach || (e < 1e6 && breach_ < 3 * tolerated_breach); }

    /// Solves again and again with the term held at the impulses of the last solution; returns the error.
    double refine(I& island, bool at_rest) {
        const double enough = at_rest ? 0.01 : ENOUGH;
        double e = error(island, 0), q = SOFTNESS;
        for (int round = 0; round < FINISHING_ROUNDS && e > enough; round++) {
            save(island, kept_);
            anchor_ = kept_;
            const bool settled = newton(island, q, FULL_STEPS + 8, std::min(enough, 1.0));
            const double next = settled || at_rest ? error(island, 0) : INFINITY;
            const bool stalls = !(next <= 0.5 * e);
            if (next < e) e = next;
            else {
                restore(island, kept_);
                e = error(island, 0);
            }
            if (!stalls) continue;
            // Where bodies are nearly wedged, the term holds impulses as strongly as the law moves them.
            if (e <= ENOUGH || q <= HARDEST) break;
            q *= 0.01;
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

    /// r: one over a bound of the row sums of |W|, by Schwarz' inequality; own: the diagonal of W.
    void set_lengths(I& island) {
        const std::size_t count = island.contacts.size();
        sum_.assign(island.w.size(), {0, 0});
        part_.resize(count);
        island.length.resize(count);
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
                island.length[i][t] = all > 0 ? 1 / all : 1;
            }
        }
        island.least = {INFINITY, INFINITY};
        for (std::size_t i = 0; i < count; i++)
            for (int t = 0; t < 2; t++)
                if (!island.contacts[i]->link) island.least[t] = std::min(island.least[t], island.own[i][t]);
    }

    /// Difference between P and its projection, 1 being what is tolerated; infinite beyond numbers.
    /// Writes y, trials, states, the merit (sum of own F^2) and the breach.
    double error(I& island, double softness) {
        const std::size_t count = island.contacts.size();
        trial_.resize(count);
        largest_.resize(count);
        defect_.resize(count);
        double noise = 0;
        merit_ = 0;
        for (std::size_t i = 0; i < count; i++) {
            C& k = *island.contacts[i];
            const auto &r = island.length[i], &own = island.own[i];
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
                noise = std::max({noise, std::fabs(k.impulse[j]), std::fabs(step), length * moved});
            }
            const Vec<d> nearest = admissible(k, trial_[i], r, k.state, nullptr);
            for (int j = 0; j < d; j++) {
                const double F = k.impulse[j] - nearest[j];
                largest_[i] = std::max(largest_[i], std::fabs(k.impulse[j]));
                defect_[i] = std::max(defect_[i], std::fabs(F));
                merit_ += own[j > 0] * F * F;
            }
        }
        if (!std::isfinite(noise)) return INFINITY;
        double worst = 0;
        breach_ = 0;
        for (std::size_t i = 0; i < count; i++) {
            if (!(defect_[i] > 0)) continue;
            worst = std::max(worst, defect_[i] / (TOLERANCE * largest_[i] + ROUND_OFF * noise));
            breach_ = std::max(breach_, defect_[i] / std::min(island.length[i][0], island.length[i][1]));
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

    /// Newton's method on the law with the proximal term. Full steps come first, which are quick where
    /// they converge; where friction couples contacts that open, stick and slide in turn they cycle,
    /// and later steps must reduce the merit, from where it was least.
    bool newton(I& island, double softness, int rounds, double target = 1) {
        const std::size_t count = island.contacts.size();
        stiffness_.resize(count);
        change_.resize(count);
        before_.resize(count);
        if (island.factored.size() != count) {
            island.factored.assign(count, -1);
            island.factored_stamp = -1;
        }
        BlockLU<unknowns>* factors = nullptr;
        double least = INFINITY, past = INFINITY, e = error(island, softness);
        for (int round = 0;; round++) {
            if (e <= target) return true;
            if (round == rounds || !(e < INFINITY)) return false;
            const bool full = round < FULL_STEPS;
            if (round <= FULL_STEPS && merit_ < least) {
                least = merit_;
                best_.resize(count);
                for (std::size_t i = 0; i < count; i++) best_[i] = island.contacts[i]->impulse;
            }
            if (round == FULL_STEPS && merit_ > least) {
                restore(island, best_);
                e = error(island, softness);
            }
            if (!full && (round - FULL_STEPS) % 8 == 0) {
                if (merit_ > 0.5 * past) return false;
                past = merit_;
            }
            const double merit_before = merit_;
            outcomes.newton++;
            if (!factors) factors = &factors_for(island);
            if (!linearise(island, softness, *factors)) return false;
            take_step(island, *factors);
            island.move();
            e = error(island, softness);
            if (full || e <= target || merit_ <= 0.999 * merit_before) continue;
            outcomes.searched++;
            e = search(island, softness, merit_before);
        }
    }

    /// Writes H and h of each contact, P = P_now + h - H G x, and factorizes where states have changed.
    bool linearise(I& island, double softness, BlockLU<unknowns>& factors) {
        bool same = factors.stamp == island.factored_stamp && island.factored_softness == softness;
        for (std::size_t i = 0; i < island.contacts.size(); i++) {
            const C& k = *island.contacts[i];
            before_[i] = k.impulse;
            Mat<d, d> J;
            LU<d> K;
            State state{};
            const Vec<d> nearest = admissible(k, trial_[i], island.length[i], state, &J);
            const int mark = static_cast<int>(state);
            // Slip in space turns its direction from iteration to iteration, and links bend.
            same = same && island.factored[i] == mark && (d == 2 || state != SLIP) && !k.link;
            island.factored[i] = mark;
            for (int a = 0; a < d; a++)
                for (int b = 0; b < d; b++) {
                    const double r = island.length[i][b > 0];
                    K.a[a][b] = (a == b) - J[a][b] + J[a][b] * r * softness * held_compliance(island, i, b > 0);
                    J[a][b] *= r;
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

    /// The part of the last step that lowers the merit enough, else most; returns the error there.
    double search(I& island, double softness, double merit_before) {
        const std::size_t count = island.contacts.size();
        for (std::size_t i = 0; i < count; i++) change_[i] = island.contacts[i]->impulse - before_[i];
        const auto go = [&](double part) {
            for (std::size_t i = 0; i < count; i++) island.contacts[i]->impulse = before_[i] + part * change_[i];
            island.move();
            return error(island, softness);
        };
        double part = 1, best = 1, lowest = merit_, e = 0;
        for (int halving = 0; halving < 12; halving++) {
            part *= 0.5;
            e = go(part);
            if (merit_ < lowest) {
                lowest = merit_;
                best = part;
            }
            if (merit_ <= (1 - 1e-3 * part) * merit_before) break;
        }
        return best == part ? e : go(best);
    }

    /// Newton's method with the term held at the anchors of the contacts, which has one solution
    /// however many rows say the same; where it fails, by the proximal point algorithm with a softer
    /// term, which becomes harder again from solution to solution.
    bool by_proximal_point(I& island) {
        const std::size_t count = island.contacts.size();
        double q = SOFTNESS;
        bool first = true;
        anchor_.resize(count);
        last_.resize(count);
        for (std::size_t i = 0; i < count; i++) anchor_[i] = island.contacts[i]->anchor;
        for (int round = 0; round < PROXIMAL_ROUNDS; round++) {
            for (std::size_t i = 0; i < count; i++) {
                last_[i] = island.contacts[i]->impulse;
                if (!first) anchor_[i] = last_[i];
            }
            if (newton(island, q, ROUNDS)) {
                if (q <= SOFTNESS) return true;
                q = std::max(SOFTNESS, 0.1 * q);
                continue;
            }
            restore(island, last_);
            if (first) outcomes.softened++;
            first = false;
            q *= 100;
            if (q > SOFTEST) return false;
        }
        return false;
    }

    /// Gauss and Seidel's method: one contact after another, each by Newton's method with r of its own.
    void sweep(I& island) {
        for (int round = 0; round < SWEEPS; round++) {
            if (round % 10 == 0 && error(island, 0) <= 1) return;
            for (std::size_t i = 0; i < island.contacts.size(); i++) {
                C& k = *island.contacts[i];
                Vec<d> y = island.reading(k);
                const Vec<d> before = k.impulse;
                Mat<d, d> W{};
                for (int side = 0; side < 2; side++) {
                    const int body = side ? k.b : k.a;
                    if (body < 0) continue;
                    const Mat<d, unknowns>& rows = side ? k.rows_b : k.rows_a;
                    for (int c = 0; c < d; c++) {
                        const Motion moved = mul(island.inverse_mass[body], rows[c]);
                        for (int a = 0; a < d; a++) W[a][c] += dot(rows[a], moved);
                    }
                }
                std::array<double, 2> r;
                for (int t = 0; t < 2; t++) r[t] = island.own[i][t] > 0 ? 1 / island.own[i][t] : 1;
                for (int inner = 0; inner < 30; inner++) {
                    Vec<d> trial;
                    for (int j = 0; j < d; j++) trial[j] = k.impulse[j] - r[j > 0] * y[j];
                    Mat<d, d> J;
                    State state{};
                    Vec<d> step = admissible(k, trial, r, state, &J) - k.impulse;
                    if (norm(step) <= 1e-15 * norm(k.impulse)) break;
                    LU<d> K;
                    for (int a = 0; a < d; a++)
                        for (int b = 0; b < d; b++) {
                            K.a[a][b] = (a == b) - J[a][b];
                            for (int c = 0; c < d; c++) K.a[a][b] += J[a][c] * r[c > 0] * W[c][b];
                        }
                    if (!K.factorize()) break;
                    K.solve(step);
                    k.impulse += step;
                    y += mul(W, step);
                }
                const Vec<d> change = k.impulse - before;
                if (k.a >= 0) island.w[k.a] += mul(island.inverse_mass[k.a], transposed_mul(k.rows_a, change));
                if (k.b >= 0) island.w[k.b] += mul(island.inverse_mass[k.b], transposed_mul(k.rows_b, change));
            }
        }
        island.move();
    }

    double breach_ = 0, merit_ = 0;
    bool loose_ = false;
    long stamps_ = 0;
    InteriorPoint<d> interior_point_;
    BlockLU<unknowns> single_;
    std::unordered_map<std::uint64_t, BlockLU<unknowns>> patterns_;
    std::vector<std::array<double, 2>> sum_;
    std::vector<std::array<std::array<double, 2>, 2>> part_;
    std::vector<double> largest_, defect_, friction_;
    std::vector<Vec<d>> trial_, change_, before_, best_, anchor_, last_, first_, kept_;
    std::vector<Mat<d, d>> stiffness_;
    std::vector<Motion> x_;
};

}  // namespace rockslip
