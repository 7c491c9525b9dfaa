// Numbers in sets that are joined one after another.
#pragma once

#include <vector>

namespace rockslip {

class DisjointSets {
  public:
    /// Makes a set of each of some numbers below a count.
    void part(const std::vector<int>& numbers, std::size_t count) {
        above_.resize(count);
        for (int i : numbers) above_[i] = i;
    }

    /// The number that stands for the set of a number.
    int top(int i) {
        while (above_[i] != i) i = above_[i] = above_[above_[i]];
        return i;
    }

    void join(int i, int j) { above_[top(i)] = top(j); }

  private:
    std::vector<int> above_;
};

}  // namespace rockslip
