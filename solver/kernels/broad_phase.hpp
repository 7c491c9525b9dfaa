// Pairs of bodies that may meet in a step: boxes with margins, swept and pruned along x.
#pragma once

#include <utility>
#include <vector>

#include "body.hpp"

namespace rockslip {

template <int d> class BroadPhase {
  public:
    /// Pairs (a, b), a < b, sorted, of the bodies listed; of two that are fixed none.
    const std::vector<std::pair<int, int>>& find(const std::vector<int>& listed, const std::vector<Body<d>>& bodies,
                                                 const std::vector<PlacedBody<d>>& placed,
                                                 const std::vector<double>& margin) {
        pairs_.clear();
        order_ = listed;
        std::sort(order_.begin(), order_.end(), [&](int i, int j) {
            const double left_i = placed[i].low[0] - margin[i], left_j = placed[j].low[0] - margin[j];
            return left_i < left_j || (left_i == left_j && i < j);
        });
        for (std::size_t p = 0; p < order_.size(); p++) {
            const int i = order_[p];
            const double end = placed[i].high[0] + margin[i];
            for (std::size_t q = p + 1; q < order_.size(); q++) {
                const int j = order_[q];
                if (placed[j].low[0] - margin[j] > end) break;
                if (!bodies[i].is_free() && !bodies[j].is_free()) continue;  // the ground and a platform only carry
                const double margins = margin[i] + margin[j];
                bool apart = false;
                for (int k = 1; k < d; k++)
                    apart |= placed[i].low[k] > placed[j].high[k] + margins || placed[j].low[k] > placed[i].high[k] + margins;
                if (!apart) pairs_.emplace_back(std::minmax(i, j));
            }
        }
        std::sort(pairs_.begin(), pairs_.end());
        return pairs_;
    }

  private:
    std::vector<int> order_;
    std::vector<std::pair<int, int>> pairs_;
};

}  // namespace rockslip
