#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/map/detail/precomputation_grids.hpp>

#include "map/kernels/kernels.hpp"
#include "scenes.hpp"

namespace wayfare {

using kernels::Kernels;
using Ints = std::vector<std::int32_t>;
using Sums = std::vector<std::uint32_t>;

/// A grid with its tables, points, and a transformation that moves some of them outside.
struct KernelCase {
  LikelihoodField grid;
  PrecomputationGrids grids;
  std::vector<float> x, y;
  int n = 0, padded = 0;
  kernels::CellTransform transform{};

  explicit KernelCase(Rng& rng)
      : grid(random_grid(rng, 1 + static_cast<int>(rng.below(90)),
                         1 + static_cast<int>(rng.below(90)), {0, 0})),
        grids(grid),
        n(1 + static_cast<int>(rng.below(700))),
        padded((n + 15) / 16 * 16) {
    const double reach = rng.uniform(0.1, 5);
    for (int i = 0; i < padded; ++i) {
      x.push_back(static_cast<float>(rng.uniform(-reach, reach)));
      y.push_back(static_cast<float>(rng.uniform(-reach, reach)));
    }
    x[0] = 1e30F;  // saturates
    const double heading = rng.uniform(-4, 4);
    transform = {static_cast<float>(20 * std::cos(heading)),
                 static_cast<float>(20 * std::sin(heading)),
                 static_cast<float>(rng.uniform(-20, 60)),
                 static_cast<float>(rng.uniform(-20, 60)),
                 1048576.0F,
                 static_cast<int>(rng.below(40)) - 20,
                 static_cast<int>(rng.below(40)) - 20};
  }

  void place(const Kernels& k, Ints& u, Ints& v) const {
    u.resize(x.size());
    v.resize(x.size());
    k.place(x.data(), y.data(), padded, transform.c, transform.s, transform.ox, transform.oy,
            transform.limit, u.data(), v.data());
  }
  [[nodiscard]] kernels::BoundTable bounds(int level) const {
    const auto& l = grids.level(level);
    return {l.table.data(), 2 * level, l.width, l.height, l.columns};
  }
  /// The bound of the node that begins at a unit of a level.
  [[nodiscard]] std::uint32_t bound_at(int level, Cell unit) const {
    const auto& l = grids.level(level);
    unit.x = std::clamp(unit.x, -kernels::kBoundMarginX, l.width) + kernels::kBoundMarginX;
    unit.y = std::clamp(unit.y, -kernels::kBoundMarginY, l.height) + kernels::kBoundMarginY;
    return l
        .table[static_cast<std::size_t>((4 * unit.y + unit.x % 4) * l.columns + unit.x / 4 * 4)];
  }
  /// Sixteen nodes four units apart, column by column, of the group `group` positions along x from
  /// that of the transformation, by their definition.
  [[nodiscard]] Sums bounds_of(int level, int group = 0) const {
    Ints u, v;
    place(kernels::kernels_for(Isa::baseline), u, v);
    Sums sums(16, 0);
    for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i)
      for (int k = 0; k < 16; ++k)
        sums[static_cast<std::size_t>(k)] +=
            bound_at(level, {((u[i] + transform.du) >> (2 * level)) + 4 * (k / 4) + 16 * group,
                             ((v[i] + transform.dv) >> (2 * level)) + 4 * (k % 4)});
    return sums;
  }
  [[nodiscard]] Sums point_bounds(const Kernels& k, int level) const {
    Sums sums(16, 0);
    for (int first = 0; first < n; first += 64)
      k.point_bounds(x.data() + first, y.data() + first, std::min(64, n - first), transform,
                     bounds(level), sums.data());
    return sums;
  }
  [[nodiscard]] Sums block_scores(const Kernels& k, int rows) const {
    Ints u, v, at(x.size());
    place(k, u, v);
    k.index(u.data(), v.data(), padded, transform.du, transform.dv, grid.width(), grid.height(),
            grid.stride(), at.data());
    Sums sums(static_cast<std::size_t>(rows * kernels::kBlock));
    k.block_scores(grid.data(), grid.stride(), at.data(), n, rows, sums.data());
    return sums;
  }
  [[nodiscard]] Sums pair_scores(const Kernels& k) const {
    Ints u, v, at(x.size());
    place(k, u, v);
    k.index(u.data(), v.data(), padded, transform.du, transform.dv, grid.width(), grid.height(),
            grid.stride(), at.data());
    Sums sums(16);
    k.pair_scores(grids.pairs(), grid.stride(), at.data(), n, sums.data());
    return sums;
  }
  [[nodiscard]] std::vector<double> linearise(const Kernels& k) const {
    std::vector<double> sums(10);
    k.linearise(x.data(), y.data(), n, transform,
                {grid.data(), grid.stride(), grid.width(), grid.height()}, 9.26F, -0.0022F,
                sums.data());
    return sums;
  }
  template <class Squares>
  [[nodiscard]] std::vector<double> squares(Squares kernel) const {
    std::vector<double> sums(10);
    kernel(x.data(), y.data(), n, transform,
           {grid.data(), grid.stride(), grid.width(), grid.height()}, 4080.0F, sums.data());
    return sums;
  }
};

/// Calls `body(variant, portable)` for every variant this CPU supports.
template <class Body>
void for_each_variant(Body&& body) {
  for (const Isa isa : {Isa::baseline, Isa::avx2, Isa::avx512}) {
    if (!runs_here(isa)) continue;
    SCOPED_TRACE(static_cast<int>(isa));
    body(kernels::kernels_for(isa), kernels::kernels_for(Isa::baseline));
  }
}

}  // namespace wayfare
