// What contacts remember from step to step.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "friction.hpp"

namespace rockslip {

/// What a contact leaves for the next step.
template <int d> struct Remembered {
    std::uint64_t id;
    Vec<d> impulse;           // of the step
    Vec<d> velocity_impulse;  // at velocity level
    Vec<d> offset;            // tangential: from the place where it stuck
    double gap;
    bool closed;
    FrictionHistory friction;
    long step;  // number of the step that wrote it
};

/// Contacts of pairs of bodies as the last step left them.
template <int d> class ContactMemory {
  public:
    struct PairMemory {
        int a, b;
        std::vector<Remembered<d>> contacts;
    };

    const Remembered<d>* find(int a, int b, std::uint64_t id) const {
        const auto pair = lower(a, b);
        if (pair == pairs_.end() || pair->a != a || pair->b != b) return nullptr;
        for (const Remembered<d>& each : pair->contacts)
            if (each.id == id) return &each;
        return nullptr;
    }

    /// The record of a contact, made where there is none.
    Remembered<d>& record(int a, int b, std::uint64_t id) {
        auto pair = pairs_.begin() + (lower(a, b) - pairs_.cbegin());
        if (pair == pairs_.end() || pair->a != a || pair->b != b) pair = pairs_.insert(pair, {a, b, {}});
        for (Remembered<d>& each : pair->contacts)
            if (each.id == id) return each;
        pair->contacts.push_back({});
        pair->contacts.back().id = id;
        return pair->contacts.back();
    }

    /// Forgets what no step since a number has written.
    void forget_before(long step) {
        for (PairMemory& pair : pairs_) {
            auto old = [&](const Remembered<d>& each) { return each.step < step; };
            pair.contacts.erase(std::remove_if(pair.contacts.begin(), pair.contacts.end(), old), pair.contacts.end());
        }
        auto empty = [](const PairMemory& pair) { return pair.contacts.empty(); };
        pairs_.erase(std::remove_if(pairs_.begin(), pairs_.end(), empty), pairs_.end());
    }

    /// Number of contacts that were closed at the end of a step.
    int closed_at(long step) const {
        int closed = 0;
        for (const PairMemory& pair : pairs_)
            for (const Remembered<d>& each : pair.contacts) closed += each.closed && each.step == step;
        return closed;
    }

    std::vector<PairMemory>& pairs() { return pairs_; }

  private:
    typename std::vector<PairMemory>::const_iterator lower(int a, int b) const {
        return std::lower_bound(pairs_.begin(), pairs_.end(), std::make_pair(a, b), [](const PairMemory& each, const std::pair<int, int>& key) {
            return std::make_pair(each.a, each.b) < key;
        });
    }

    std::vector<PairMemory> pairs_;
};

}  // namespace rockslip
