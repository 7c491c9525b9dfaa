// Sparse LU of matrices of blocks with a symmetric pattern: pivots inside blocks only, elimination by
// minimum degree.
#pragma once

#include <set>
#include <utility>
#include <vector>

#include "linear.hpp"

namespace rockslip {

template <int n> class BlockLU {
  public:
    using Block = Mat<n, n>;

    long stamp = 0;  // number of the last factorization

    /// Finds the order of elimination and the fill-in for blocks linked by pairs.
    void analyse(int size, const std::vector<std::pair<int, int>>& links) {
        count_ = size;
        std::vector<std::set<int>> neighbours(size);
        for (auto [i, j] : links)
            if (i != j) {
                neighbours[i].insert(j);
                neighbours[j].insert(i);
            }
        std::set<std::pair<std::size_t, int>> queue;
        for (int i = 0; i < size; i++) queue.insert({neighbours[i].size(), i});
        place_.assign(size, -1);
        std::vector<std::vector<int>> columns(size);
        for (int k = 0; k < size; k++) {
            const int next = queue.begin()->second;
            queue.erase(queue.begin());
            place_[next] = k;
            columns[k].assign(neighbours[next].begin(), neighbours[next].end());
            for (int i : columns[k]) {
                queue.erase({neighbours[i].size(), i});
                neighbours[i].erase(next);
                for (int j : columns[k])
                    if (j != i) neighbours[i].insert(j);
                queue.insert({neighbours[i].size(), i});
            }
        }
        start_.assign(size + 1, 0);
        rows_.clear();
        for (int k = 0; k < size; k++) {
            for (int& i : columns[k]) i = place_[i];
            std::sort(columns[k].begin(), columns[k].end());
            rows_.insert(rows_.end(), columns[k].begin(), columns[k].end());
            start_[k + 1] = static_cast<int>(rows_.size());
        }
        targets_.clear();
        for (int k = 0; k < size; k++)
            for (int p = start_[k]; p < start_[k + 1]; p++)
                for (int q = start_[k]; q < p; q++) targets_.push_back(find(rows_[p], rows_[q]));
        diagonal_.resize(size);
        factors_.resize(size);
        lower_.resize(rows_.size());
        upper_.resize(rows_.size());
    }

    int size() const { return count_; }

    void clear() {
        std::fill(diagonal_.begin(), diagonal_.end(), Block{});
        std::fill(lower_.begin(), lower_.end(), Block{});
        std::fill(upper_.begin(), upper_.end(), Block{});
    }

    Block& diagonal(int i) { return diagonal_[place_[i]]; }

    /// Block (i, j) off the diagonal, of a pair that is linked.
    Block& off_diagonal(int i, int j) {
        const int a = place_[i], b = place_[j];
        return a > b ? lower_[find(a, b)] : upper_[find(b, a)];
    }

    /// Factorizes in place; false where a pivot block is singular.
    bool factorize() {
        const int* target = targets_.data();
        for (int k = 0; k < count_; k++) {
            factors_[k].a = diagonal_[k];
            if (!factors_[k].factorize()) return false;
            for (int p = start_[k]; p < start_[k + 1]; p++) factors_[k].solve(upper_[p]);
            for (int p = start_[k]; p < start_[k + 1]; p++) {
                add_product(diagonal_[rows_[p]], lower_[p], upper_[p], -1);
                for (int q = start_[k]; q < p; q++) {
                    const int t = *target++;
                    add_product(lower_[t], lower_[p], upper_[q], -1);
                    add_product(upper_[t], lower_[q], upper_[p], -1);
                }
            }
        }
        return true;
    }

    /// Solves in place, for a vector by blocks.
    void solve(std::vector<Vec<n>>& x) {
        if (count_ == 1) {
            factors_[0].solve(x[0]);
            return;
        }
        ordered_.resize(count_);
        for (int i = 0; i < count_; i++) ordered_[place_[i]] = x[i];
        for (int k = 0; k < count_; k++) {
            factors_[k].solve(ordered_[k]);
            for (int p = start_[k]; p < start_[k + 1]; p++)
                ordered_[rows_[p]] += -1.0 * mul(lower_[p], ordered_[k]);
        }
        for (int k = count_ - 1; k >= 0; k--)
            for (int p = start_[k]; p < start_[k + 1]; p++)
                ordered_[k] += -1.0 * mul(upper_[p], ordered_[rows_[p]]);
        for (int i = 0; i < count_; i++) x[i] = ordered_[place_[i]];
    }

  private:
    int find(int row, int column) const {
        const auto first = rows_.begin() + start_[column], last = rows_.begin() + start_[column + 1];
        return static_cast<int>(std::lower_bound(first, last, row) - rows_.begin());
    }

    int count_ = 0;
    std::vector<int> place_, start_, rows_, targets_;  // by place in the order of elimination
    std::vector<Block> diagonal_, lower_, upper_;
    std::vector<LU<n>> factors_;
    std::vector<Vec<n>> ordered_;
};

}  // namespace rockslip
