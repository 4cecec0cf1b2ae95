#include <wayfare/map/occupancy_grid.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "map/kernels/kernels.hpp"

namespace wayfare {

void OccupancyGrid::update(std::span<const Cell> cells, LogOdds delta) {
  if (cells.empty()) return;
  CellBox box{cells[0], cells[0]};
  Cell tile = Tiles::tile_of(cells[0]);
  Tiles::Tile* in = &tiles_.writable(tile);
  for (const Cell& c : cells) {
    if (const Cell its = Tiles::tile_of(c); its != tile) {
      tile = its;
      in = &tiles_.writable(tile);
    }
    std::int16_t& l = (*in)[Tiles::offset_in_tile(c)];
    l = added(l, delta.fixed);
    box.extend(c);
  }
  extend_bounds(box);
}

namespace {

/// Rows, and parts of 16 columns, of a tile that a box meets.
struct Window {
  Cell tile;
  int first_row, rows, first_part, parts;

  explicit Window(const CellBox& box) : tile(OccupancyGrid::Tiles::tile_of(box.min)) {
    constexpr int kSide = OccupancyGrid::Tiles::kSide;
    const Cell from = box.min - Cell{tile.x * kSide, tile.y * kSide};
    first_row = from.y;
    rows = box.max.y - box.min.y + 1;
    first_part = from.x / 16;
    parts = (from.x + box.max.x - box.min.x) / 16 - first_part + 1;
  }
  [[nodiscard]] std::ptrdiff_t row_start() const {
    return std::ptrdiff_t{first_row} * OccupancyGrid::Tiles::kSide;
  }
};

}  // namespace

void OccupancyGrid::update_tile(const CellBox& box, std::span<const std::uint16_t> passes,
                                int max_passes, LogOdds delta) {
  if (delta.fixed == 0) return;
  const Window w(box);
  const std::ptrdiff_t first = w.row_start() + 16 * w.first_part;
  std::int16_t* cells = tiles_.writable(w.tile).data() + first;
  const std::uint16_t* counts = passes.data() + first;
  // More passes change nothing.
  const int step = std::abs(int{delta.fixed});
  const int most = std::min({max_passes, (high_ - low_ + step - 1) / step, 0x7fff});
  extend_bounds(box);
  if (fits_kernels(step)) {
    kernels::best_kernels().add_passes(
        cells, counts, w.rows, w.parts,
        {delta.fixed, low_, high_, kUnknown, static_cast<std::int16_t>(most)});
    return;
  }
  for (int r = 0; r < w.rows; ++r, cells += Tiles::kSide, counts += Tiles::kSide)
    for (int c = 0; c < 16 * w.parts; ++c)
      if (counts[c] > 0) cells[c] = added(cells[c], std::min<int>(counts[c], most) * delta.fixed);
}

void OccupancyGrid::update_tile(const CellBox& box, std::span<const std::uint64_t> rows,
                                LogOdds delta) {
  if (delta.fixed == 0) return;
  const Window w(box);
  std::int16_t* cells = tiles_.writable(w.tile).data() + w.row_start();
  const std::uint64_t* bits = rows.data() + w.first_row;
  extend_bounds(box);
  if (fits_kernels(std::abs(int{delta.fixed}))) {
    kernels::best_kernels().add_marks(cells, bits, w.rows, w.first_part, w.parts,
                                      {delta.fixed, low_, high_, kUnknown, 1});
    return;
  }
  for (int r = 0; r < w.rows; ++r, cells += Tiles::kSide)
    for (int c = 0; c < Tiles::kSide; ++c)
      if ((bits[r] >> c & 1) != 0) cells[c] = added(cells[c], delta.fixed);
}

}  // namespace wayfare
