#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>

#include <wayfare/core/contract.hpp>
#include <wayfare/map/cell.hpp>
#include <wayfare/map/cow_tiles.hpp>

namespace wayfare {

/// l = ln(p / (1 − p)) as a whole number of 1/1024.
struct LogOdds {
  static constexpr double kUnitsPerNat = 1024.0;
  std::int16_t fixed = 0;

  /// Saturates at ±31.9 (p within 1e-14 of 0 or 1); NaN gives 0.
  [[nodiscard]] static LogOdds from_nats(double l) {
    const double units = std::isnan(l) ? 0.0 : std::round(l * kUnitsPerNat);
    return {static_cast<std::int16_t>(std::clamp(units, -32700.0, 32700.0))};
  }
  [[nodiscard]] static LogOdds from_probability(double p) {
    return from_nats(std::log(p / (1.0 - p)));
  }
  [[nodiscard]] double nats() const { return fixed / kUnitsPerNat; }
  [[nodiscard]] double probability() const { return 1.0 / (1.0 + std::exp(-nats())); }
  auto operator<=>(const LogOdds&) const = default;
};

struct OccupancyGridOptions {
  /// Side of a cell, m. Smaller shows more and costs its square in memory.
  double resolution_m = 0.05;
  /// Log-odds are clamped to these, so that a cell that changes its mind can do so in a few scans.
  double min_probability = 0.02;
  double max_probability = 0.98;
};

/// Occupancy by log-odds `l ← clamp(l + l(inverse sensor model) − l₀)` with the prior p₀ = ½
/// (Zhang 2020, section 2.2). Cells nobody updated are unknown. Grows in every direction; copies share tiles.
class OccupancyGrid {
 public:
  using Tiles = CowTiles<std::int16_t>;
  static constexpr std::int16_t kUnknown = std::numeric_limits<std::int16_t>::min();

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

  [[nodiscard]] double resolution_m() const { return options_.resolution_m; }
  [[nodiscard]] const OccupancyGridOptions& options() const { return options_; }

  [[nodiscard]] bool observed(const Cell& c) const { return tiles_[c] != kUnknown; }
  /// Zero where unknown.
  [[nodiscard]] LogOdds log_odds(const Cell& c) const {
    const std::int16_t l = tiles_[c];
    return {l == kUnknown ? std::int16_t{0} : l};
  }
  /// One half where unknown.
  [[nodiscard]] double probability(const Cell& c) const { return log_odds(c).probability(); }

  /// The smallest box around every observed cell; none for an empty grid.
  [[nodiscard]] const std::optional<CellBox>& bounds() const { return bounds_; }

  void update(const Cell& c, LogOdds delta) {
    std::int16_t& l = tiles_.writable(Tiles::tile_of(c))[Tiles::offset_in_tile(c)];
    l = added(l, delta.fixed);
    extend_bounds({c, c});
  }

  /// Updates the cells from `first` along +x; a delta of zero leaves its cell as it was, unknown
  /// cells included. Deltas lie within ±32767.
  void update_row(Cell first, std::span<const std::int16_t> deltas);

  /// `visit(first cell of the tile, its 64×64 fixed-point log-odds, row-major)`, in order of (x, y)
  /// of the tiles; unknown cells hold kUnknown.
  template <class Visit>
  void for_each_tile(Visit&& visit) const {
    tiles_.for_each_tile([&](const Cell& tile, std::span<const std::int16_t> cells) {
      visit(Cell{tile.x * Tiles::kSide, tile.y * Tiles::kSide}, cells);
    });
  }
  /// For readers that walk tile by tile.
  [[nodiscard]] const Tiles& tiles() const { return tiles_; }

 private:
  [[nodiscard]] std::int16_t added(std::int16_t l, std::int16_t delta) const {
    const int sum = (l == kUnknown ? 0 : l) + delta;
    return static_cast<std::int16_t>(std::clamp<int>(sum, low_, high_));
  }
  void extend_bounds(const CellBox& box) {
    if (!bounds_) bounds_ = box;
    bounds_->extend(box.min);
    bounds_->extend(box.max);
  }

  OccupancyGridOptions options_;
  std::int16_t low_, high_;
  Tiles tiles_{kUnknown};
  std::optional<CellBox> bounds_;
};

inline void OccupancyGrid::update_row(Cell first, std::span<const std::int16_t> deltas) {
  const auto touched = [](std::int16_t d) { return d != 0; };
  const auto begin = std::find_if(deltas.begin(), deltas.end(), touched);
  if (begin == deltas.end()) return;
  const auto end = std::find_if(deltas.rbegin(), deltas.rend(), touched).base();
  first.x += static_cast<int>(begin - deltas.begin());
  const int count = static_cast<int>(end - begin);
  extend_bounds({first, {first.x + count - 1, first.y}});
  const std::int16_t* delta = &*begin;
  for (int done = 0; done < count;) {
    const Cell at{first.x + done, first.y};
    const int n = std::min(count - done, Tiles::kSide - (at.x & (Tiles::kSide - 1)));
    std::int16_t* l = &tiles_.writable(Tiles::tile_of(at))[Tiles::offset_in_tile(at)];
    for (int i = 0; i < n; ++i) l[i] = delta[i] == 0 ? l[i] : added(l[i], delta[i]);
    delta += n;
    done += n;
  }
}

}  // namespace wayfare
