#pragma once

// Occupancy grids by log-odds on tiles that copies share.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <limits>
#include <optional>
#include <span>

#include <wayfare/core/contract.hpp>
#include <wayfare/core/detail/reset_on_move.hpp>
#include <wayfare/map/cell.hpp>
#include <wayfare/map/detail/copy_on_write_tiles.hpp>

namespace wayfare {

/// l = ln(p / (1 − p)) in fixed point, units of 1/1024.
struct LogOdds {
  static constexpr double kUnitsPerNat = 1024.0;  ///< units of `fixed` per nat
  std::int16_t fixed = 0;                         ///< log-odds in units of 1/1024 nat

  /// Saturates at ±31.9 (p within 1e-14 of 0 or 1); NaN gives 0.
  [[nodiscard]] static LogOdds from_nats(double l) {
    const double units = std::isnan(l) ? 0.0 : std::round(l * kUnitsPerNat);
    return {static_cast<std::int16_t>(std::clamp(units, -32700.0, 32700.0))};
  }
  /// ln(p / (1 − p)), saturated as from_nats.
  [[nodiscard]] static LogOdds from_probability(double p) {
    return from_nats(std::log(p / (1.0 - p)));
  }
  /// l.
  [[nodiscard]] double nats() const { return fixed / kUnitsPerNat; }
  /// p = 1 / (1 + exp(−l)).
  [[nodiscard]] double probability() const { return 1.0 / (1.0 + std::exp(-nats())); }
  /// In the order of probability.
  auto operator<=>(const LogOdds&) const = default;
};

/// Cells and clamping of an OccupancyGrid.
struct OccupancyGridOptions {
  /// Side of a cell, m. Memory grows with its inverse square.
  double resolution_m = 0.05;
  /// Log-odds are clamped to these, so that a cell can change its state within a few scans.
  double min_probability = 0.02;
  double max_probability = 0.98;  ///< above one half, below one
};

/// Occupancy by log-odds `l ← clamp(l + l(inverse sensor model) − l₀)` with the prior p₀ = ½
/// (Zhang 2020, section 2.2). Cells that were not updated are unknown. Grows in every direction;
/// copies share tiles. A moved-from grid is empty and keeps its options.
class OccupancyGrid {
 public:
  /// Tiles of 64×64 cells, shared between copies until written.
  using Tiles = CopyOnWriteTiles<std::int16_t>;
  /// fixed-point value of a cell without an update.
  static constexpr std::int16_t kUnknown = std::numeric_limits<std::int16_t>::min();

  /// An empty grid. Requires a positive resolution and probabilities on both sides of one half.
  explicit OccupancyGrid(const OccupancyGridOptions& options = {})
      : options_(options),
        low_(LogOdds::from_probability(options.min_probability).fixed),
        high_(LogOdds::from_probability(options.max_probability).fixed) {
    WAYFARE_EXPECTS(options.resolution_m > 0 && std::isfinite(options.resolution_m),
                    "the resolution must be positive");
    WAYFARE_EXPECTS(0 < options.min_probability && options.min_probability <= 0.5 &&
                        0.5 <= options.max_probability && options.max_probability < 1,
                    "the clamping probabilities must enclose one half");
  }

  /// Side of a cell, m.
  [[nodiscard]] double resolution_m() const { return options_.resolution_m; }
  /// As given.
  [[nodiscard]] const OccupancyGridOptions& options() const { return options_; }

  /// Whether the cell was updated.
  [[nodiscard]] bool observed(const Cell& c) const { return tiles_[c] != kUnknown; }
  /// Zero where unknown.
  [[nodiscard]] LogOdds log_odds(const Cell& c) const {
    const std::int16_t l = tiles_[c];
    return {l == kUnknown ? std::int16_t{0} : l};
  }
  /// One half where unknown.
  [[nodiscard]] double probability(const Cell& c) const { return log_odds(c).probability(); }

  /// The smallest box around every observed cell; none for an empty grid.
  [[nodiscard]] const std::optional<CellBox>& bounds() const { return bounds_.value; }

  /// Adds `delta` to the log-odds of a cell, clamped; an unknown cell starts from zero.
  void update(const Cell& c, LogOdds delta) {
    std::int16_t& l = tiles_.writable(Tiles::tile_of(c))[Tiles::offset_in_tile(c)];
    l = added(l, delta.fixed);
    extend_bounds({c, c});
  }

  /// Adds `delta` times its mark to every cell of the tiles that intersect `box`, and sets the
  /// marks to zero. `marks` are row-major with rows `stride` apart, from the first cell of the tile
  /// of box.min to the row of box.max. Cells marked zero are unchanged, unknown ones included, as
  /// are all cells for a delta of zero. Marks wider than a byte may exceed 1.
  template <class Mark>
  void update_marked(const CellBox& box, Mark* marks, std::ptrdiff_t stride, LogOdds delta);

  /// `visit(first cell of the tile, its 64×64 fixed-point log-odds, row-major)`, in order of (x, y)
  /// of the tiles; unknown cells are kUnknown.
  template <class Visit>
  void for_each_tile(Visit&& visit) const {
    tiles_.for_each_tile([&](const Cell& tile, std::span<const std::int16_t> cells) {
      visit(Cell{tile.x * Tiles::kSide, tile.y * Tiles::kSide}, cells);
    });
  }
  /// `visit(first cell, its and the next cells' fixed-point log-odds)` for the rows of `box` in
  /// each tile that exists, tile by tile.
  template <class Visit>
  void for_each_row(const CellBox& box, const Visit& visit) const;
  /// Its storage, e.g. to see what copies share.
  [[nodiscard]] const Tiles& tiles() const { return tiles_; }

 private:
  [[nodiscard]] std::int16_t added(std::int16_t l, std::int16_t delta) const {
    const int sum = (l == kUnknown ? 0 : l) + delta;
    return static_cast<std::int16_t>(std::clamp<int>(sum, low_, high_));
  }
  template <class Mark>
  void update_tile(const Cell& tile, int rows, Mark* marks, std::ptrdiff_t stride, LogOdds delta);
  template <class Mark>
  void add_marks(std::int16_t* cells, const Mark* marks, int delta) const;
  void extend_bounds(const CellBox& box) {
    std::optional<CellBox>& bounds = bounds_.value;
    if (!bounds) bounds = box;
    bounds->extend(box.min);
    bounds->extend(box.max);
  }

  OccupancyGridOptions options_;
  std::int16_t low_, high_;
  Tiles tiles_{kUnknown};
  ResetOnMove<std::optional<CellBox>> bounds_;
};

template <class Visit>
void OccupancyGrid::for_each_row(const CellBox& box, const Visit& visit) const {
  const Cell first = Tiles::tile_of(box.min), last = Tiles::tile_of(box.max);
  for (int ty = first.y; ty <= last.y; ++ty)
    for (int tx = first.x; tx <= last.x; ++tx) {
      const Tiles::Tile* tile = tiles_.find({tx, ty});
      if (tile == nullptr) continue;
      const Cell corner{tx * Tiles::kSide, ty * Tiles::kSide};
      const int left = std::max(box.min.x, corner.x);
      const int right = std::min(box.max.x, corner.x + Tiles::kSide - 1);
      const int top = std::min(box.max.y, corner.y + Tiles::kSide - 1);
      const auto columns = static_cast<std::size_t>(right - left + 1);
      for (Cell at{left, std::max(box.min.y, corner.y)}; at.y <= top; ++at.y)
        visit(at, std::span(*tile).subspan(Tiles::offset_in_tile(at), columns));
    }
}

template <class Mark>
void OccupancyGrid::update_marked(const CellBox& box, Mark* marks, std::ptrdiff_t stride,
                                  LogOdds delta) {
  const Cell first = Tiles::tile_of(box.min), last = Tiles::tile_of(box.max);
  for (int y = first.y; y <= last.y; ++y) {
    const int rows = std::min(Tiles::kSide, box.max.y - y * Tiles::kSide + 1);
    for (int x = first.x; x <= last.x; ++x)
      update_tile({x, y}, rows,
                  marks + std::ptrdiff_t{y - first.y} * Tiles::kSide * stride +
                      std::ptrdiff_t{x - first.x} * Tiles::kSide,
                  stride, delta);
  }
}

template <class Mark>
void OccupancyGrid::update_tile(const Cell& tile, int rows, Mark* marks, std::ptrdiff_t stride,
                                LogOdds delta) {
  constexpr int kSide = Tiles::kSide;
  Tiles::Tile* cells = nullptr;
  Mark columns[kSide] = {};  // bitwise or over the rows
  int low = kSide, high = -1;
  for (int r = 0; r < rows; ++r, marks += stride) {
    Mark any = 0;
    for (int i = 0; i < kSide; ++i) any = static_cast<Mark>(any | marks[i]);
    if (any == 0) continue;
    if (delta.fixed != 0) {
      if (cells == nullptr) cells = &tiles_.writable(tile);
      add_marks(cells->data() + std::ptrdiff_t{r} * kSide, marks, delta.fixed);
      for (int i = 0; i < kSide; ++i) columns[i] = static_cast<Mark>(columns[i] | marks[i]);
    }
    std::fill(marks, marks + kSide, Mark{0});
    low = std::min(low, r);
    high = r;
  }
  if (cells == nullptr) return;
  const auto marked = [](Mark m) { return m != 0; };
  const auto left = std::find_if(columns, columns + kSide, marked) - columns;
  const auto right =
      kSide - 1 -
      (std::find_if(std::rbegin(columns), std::rend(columns), marked) - std::rbegin(columns));
  const Cell corner{tile.x * kSide, tile.y * kSide};
  extend_bounds(
      {corner + Cell{static_cast<int>(left), low}, corner + Cell{static_cast<int>(right), high}});
}

/// Loops of constant length, which compilers vectorise.
template <class Mark>
void OccupancyGrid::add_marks(std::int16_t* cells, const Mark* marks, int delta) const {
  if constexpr (sizeof(Mark) > 1) {
    for (int i = 0; i < Tiles::kSide; ++i) {
      const int l = cells[i] == kUnknown ? 0 : cells[i];
      const int sum = std::clamp<int>(l + marks[i] * delta, low_, high_);
      cells[i] = static_cast<std::int16_t>(marks[i] != 0 ? sum : cells[i]);
    }
  } else {
    // Clamped before the addition, so that the sum fits 16 bits.
    constexpr int kMax = std::numeric_limits<std::int16_t>::max();
    const auto low = static_cast<std::int16_t>(std::clamp(low_ - delta, -kMax, kMax));
    const auto high = static_cast<std::int16_t>(std::clamp(high_ - delta, -kMax, kMax));
    for (int i = 0; i < Tiles::kSide; ++i) {
      const std::int16_t old = cells[i];
      std::int16_t l = old == kUnknown ? std::int16_t{0} : old;
      l = l < low ? low : l;
      l = l > high ? high : l;
      l = static_cast<std::int16_t>(l + delta);
      cells[i] = marks[i] != 0 ? l : old;
    }
  }
}

}  // namespace wayfare
