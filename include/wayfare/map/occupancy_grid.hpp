#pragma once

// Occupancy grids by log-odds on tiles that copies share.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
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

  /// The same for each of `cells`.
  void update(std::span<const Cell> cells, LogOdds delta);

  /// Adds `delta` to each cell of a tile as often as it was passed, but at most `max_passes` times.
  /// `passes` are row-major from the first cell of the tile, 64 a row; `box` encloses those that
  /// are not zero. Other cells are unchanged, unknown ones included.
  void update_tile(const CellBox& box, std::span<const std::uint16_t> passes, int max_passes,
                   LogOdds delta);
  /// The same for cells that were passed once: bit c of word r is set for column c of row r.
  void update_tile(const CellBox& box, std::span<const std::uint64_t> rows, LogOdds delta);

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
  /// Whether a limit and a step together fit 16 bits.
  [[nodiscard]] bool fits_kernels(int step) const {
    return std::max<int>(high_, -low_) + step <= std::numeric_limits<std::int16_t>::max();
  }
  [[nodiscard]] std::int16_t added(std::int16_t l, int delta) const {
    const int sum = (l == kUnknown ? 0 : l) + delta;
    return static_cast<std::int16_t>(std::clamp<int>(sum, low_, high_));
  }
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
      const auto columns = static_cast<std::size_t>(right - left) + 1;
      for (Cell at{left, std::max(box.min.y, corner.y)}; at.y <= top; ++at.y)
        visit(at, std::span(*tile).subspan(Tiles::offset_in_tile(at), columns));
    }
}

}  // namespace wayfare
