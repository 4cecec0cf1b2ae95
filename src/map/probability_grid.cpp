#include <wayfare/map/probability_grid.hpp>

#include <cmath>
#include <limits>
#include <optional>
#include <span>

namespace wayfare {
namespace {

constexpr int kLeast = -std::numeric_limits<std::int16_t>::max();

/// p · kOne of every log-odds value from kLeast.
const std::vector<std::uint16_t>& probabilities() {
  static const auto table = [] {
    std::vector<std::uint16_t> values;
    for (int l = kLeast; l <= -kLeast; ++l) {
      const double odds = std::exp(LogOdds{static_cast<std::int16_t>(l)}.nats());
      values.push_back(
          static_cast<std::uint16_t>(std::lround(ProbabilityGrid::kOne * odds / (1 + odds))));
    }
    return values;
  }();
  return table;
}

}  // namespace

Result<void> ProbabilityGrid::check(const CellBox& box, double unknown_probability) {
  if (!(unknown_probability >= 0 && unknown_probability <= 1))
    return Error{ErrorCode::invalid, "a probability grid: unknown probability out of range"};
  return check_size(box);
}

Result<void> ProbabilityGrid::make(const OccupancyGrid& grid, double unknown_probability,
                                   int margin) {
  if (margin >= 0 && margin <= kMaxCell && grid.bounds())
    return make(grid, unknown_probability, grid.bounds()->grown(margin));
  *this = {};
  return Error{ErrorCode::invalid, grid.bounds() ? "a probability grid: margin out of range"
                                                 : "a probability grid: no cell was observed"};
}

Result<void> ProbabilityGrid::make(const OccupancyGrid& grid, double unknown_probability,
                                   const CellBox& box) {
  auto ok = check(box, unknown_probability);
  if (ok) {
    unknown_ = static_cast<std::uint16_t>(std::lround(kOne * unknown_probability));
    ok = reset(grid.resolution_m(), box, unknown_);
  }
  if (!ok) *this = {};
  const auto observed = ok && grid.bounds() ? common_cells(box, *grid.bounds()) : std::nullopt;
  if (observed) copy(grid, *observed);
  return ok;
}

bool ProbabilityGrid::update(const OccupancyGrid& grid, const CellBox& box) {
  if (!covers(box)) return false;
  copy(grid, box);
  return true;
}

void ProbabilityGrid::copy(const OccupancyGrid& grid, const CellBox& box) {
  const std::uint16_t* p = probabilities().data() - kLeast;
  grid.for_each_row(box, [&](const Cell& first, std::span<const std::int16_t> log_odds) {
    const Cell at = first - origin();
    std::uint16_t* to = data() + std::ptrdiff_t{at.y} * stride() + at.x;
    for (const std::int16_t l : log_odds) *to++ = l == OccupancyGrid::kUnknown ? unknown_ : p[l];
  });
}

MultiResolutionGrid::MultiResolutionGrid(const MultiResolutionOptions& options)
    : options_(options) {
  WAYFARE_EXPECTS(options.levels >= 1 && options.levels <= 8, "one to eight levels");
  WAYFARE_EXPECTS(options.table_reach_m > 0.0, "a reach of the tables that is positive");
  for (int level = options.levels - 1; level >= 0; --level) {
    OccupancyGridOptions shape = options.finest;
    shape.resolution_m *= 1 << level;
    grids_.emplace_back(shape);
  }
}

/// `lay_rays(resolution_m)` puts the rays of the scan into the raster and returns their origin. All
/// levels are checked before a cell of any of them changes.
template <class LayRays>
Result<void> MultiResolutionGrid::insert_everywhere(const LayRays& lay_rays, ScanRaster& raster) {
  std::vector<CellBox> changed;
  for (std::size_t i = 0; i < grids_.size(); ++i) {
    const auto from = lay_rays(grids_[i].resolution_m());
    if (!from) return from.error();
    if (raster.rays().empty()) continue;
    const auto box = raster.cover(*from);
    if (!box) return box.error();
    if (auto ok = check_room(i, *box, from->cell()); !ok) return ok;
    changed.push_back(*box);
  }
  if (changed.empty()) return {};  // no rays
  tables_.resize(grids_.size());
  for (std::size_t i = 0; i < changed.size(); ++i) {
    const auto from = lay_rays(grids_[i].resolution_m());
    const ScanUpdate update = detail::update_of(options_.model);
    if (auto ok = raster.apply<OncePerScan>(grids_[i], *from, update); !ok) return ok;
    ProbabilityGrid& table = tables_[i];
    const auto in_table = table.empty() ? std::nullopt : common_cells(changed[i], table.box());
    if (in_table) table.update(grids_[i], *in_table);
    if (auto ok = follow(i, from->cell()); !ok) return ok;
  }
  return {};
}

Result<void> MultiResolutionGrid::insert(const SE2d& T_map_laser, const LaserScan& scan) {
  return insert_everywhere(
      [&](double resolution_m) {
        return detail::lay_rays<OncePerScan>(raster_, resolution_m, T_map_laser, scan,
                                             options_.model);
      },
      raster_);
}

Result<void> MultiResolutionGrid::insert(const SE2d& T_map_points, const PointSet& points,
                                         const Eigen::Vector2d& origin, ScanRaster& raster) {
  return insert_everywhere(
      [&](double resolution_m) {
        return detail::lay_rays<OncePerScan>(raster, resolution_m, T_map_points, points,
                                             options_.model, origin);
      },
      raster);
}

std::size_t MultiResolutionGrid::memory_bytes() const {
  std::size_t sum = 0;
  for (const OccupancyGrid& grid : grids_)
    grid.for_each_tile(
        [&](const Cell&, std::span<const std::int16_t> cells) { sum += cells.size_bytes(); });
  for (const ProbabilityGrid& table : tables_)
    sum += sizeof(std::uint16_t) * static_cast<std::size_t>(table.stride()) *
           static_cast<std::size_t>(table.height() + 2 * PaddedTable::kBorder);
  return sum;
}

/// The cells in the tables' reach of `at`, and `more_m` beyond.
CellBox MultiResolutionGrid::near(std::size_t level, const Cell& at, double more_m) const {
  return CellBox{at, at}.grown(
      cell_coordinate(options_.table_reach_m + more_m, grids_[level].resolution_m()));
}

/// A table that is too small is rebuilt with a spare margin, so that rebuilding is rare.
CellBox MultiResolutionGrid::with_spare(std::size_t level, const CellBox& bounds,
                                        const Cell& at) const {
  constexpr double kSpare_m = 5.0;
  const CellBox all = bounds.grown(cell_coordinate(kSpare_m, grids_[level].resolution_m()));
  return common_cells(all, near(level, at, kSpare_m)).value_or(all);
}

/// Whether the table of the level can be moved to `at` when cells of `changed` were observed.
Result<void> MultiResolutionGrid::check_room(std::size_t level, const CellBox& changed,
                                             const Cell& at) const {
  CellBox bounds = grids_[level].bounds().value_or(changed);
  bounds.extend(changed.min);
  bounds.extend(changed.max);
  return ProbabilityGrid::check(with_spare(level, bounds, at), options_.unknown_probability);
}

/// Moves the table of the level to `at` where it does not contain all cells near.
Result<void> MultiResolutionGrid::follow(std::size_t level, const Cell& at) {
  const OccupancyGrid& grid = grids_[level];
  if (!grid.bounds()) return {};
  const auto needed = common_cells(*grid.bounds(), near(level, at, 0.0));
  if (!needed || tables_[level].covers(*needed)) return {};
  // Of the old and the new table only one is in memory.
  tables_[level] = {};
  return tables_[level].make(grid, options_.unknown_probability,
                             with_spare(level, *grid.bounds(), at));
}

Result<void> MultiResolutionGrid::focus(const Eigen::Vector2d& place_m) {
  for (std::size_t level = 0; level < tables_.size(); ++level)
    if (auto ok = follow(level, cell_of(place_m, grids_[level].resolution_m())); !ok) return ok;
  return {};
}

}  // namespace wayfare
