#include <wayfare/map/probability_grid.hpp>

#include <cmath>
#include <limits>
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

Result<CellBox> ProbabilityGrid::extent(const CellBox& bounds, double unknown_probability,
                                        int margin) {
  if (!(unknown_probability >= 0 && unknown_probability <= 1) || margin < 0 || margin > kMaxCell)
    return Error{ErrorCode::invalid,
                 "a probability grid: unknown probability or margin out of range"};
  const CellBox box = bounds.grown(margin);
  if (auto ok = check_size(box); !ok) return ok.error();
  return box;
}

Result<void> ProbabilityGrid::make(const OccupancyGrid& grid, double unknown_probability,
                                   int margin) {
  const auto refused = [this](Error error) {
    *this = {};
    return error;
  };
  if (!grid.bounds())
    return refused({ErrorCode::invalid, "a probability grid: no cell was observed"});
  const auto box = extent(*grid.bounds(), unknown_probability, margin);
  if (!box) return refused(box.error());
  unknown_ = static_cast<std::uint16_t>(std::lround(kOne * unknown_probability));
  if (auto ok = reset(grid.resolution_m(), *box, unknown_); !ok) return ok;
  copy(grid, *grid.bounds());
  return {};
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
  for (int level = options.levels - 1; level >= 0; --level) {
    OccupancyGridOptions shape = options.finest;
    shape.resolution_m *= 1 << level;
    grids_.emplace_back(shape);
  }
}

/// `lay_rays(resolution_m)` puts the rays of the scan into the raster and returns their origin. All
/// levels are checked before a cell of any of them changes.
template <class LayRays>
Result<void> MultiResolutionGrid::insert_everywhere(const LayRays& lay_rays) {
  std::vector<CellBox> changed;
  for (std::size_t i = 0; i < grids_.size(); ++i) {
    const auto from = lay_rays(grids_[i].resolution_m());
    if (!from) return from.error();
    if (raster_.rays().empty()) continue;
    const auto box = raster_.cover(*from);
    if (!box) return box.error();
    if (auto ok = check_room(i, *box); !ok) return ok;
    changed.push_back(*box);
  }
  if (changed.empty()) return {};  // no rays
  tables_.resize(grids_.size());
  for (std::size_t i = 0; i < changed.size(); ++i) {
    const auto from = lay_rays(grids_[i].resolution_m());
    const ScanUpdate update = detail::update_of(options_.model);
    if (auto ok = raster_.apply<OncePerScan>(grids_[i], *from, update); !ok) return ok;
    if (auto ok = follow(i, changed[i]); !ok) return ok;
  }
  return {};
}

Result<void> MultiResolutionGrid::insert(const SE2d& T_map_laser, const LaserScan& scan) {
  return insert_everywhere([&](double resolution_m) {
    return detail::lay_rays(raster_, resolution_m, T_map_laser, scan, options_.model);
  });
}

Result<void> MultiResolutionGrid::insert(const SE2d& T_map_points, const PointSet& points,
                                         const Eigen::Vector2d& origin) {
  return insert_everywhere([&](double resolution_m) {
    return detail::lay_rays<OncePerScan>(raster_, resolution_m, T_map_points, points,
                                         options_.model, origin);
  });
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

/// A table that is too small is rebuilt with a spare margin, so that rebuilding is rare.
int MultiResolutionGrid::margin(const OccupancyGrid& grid) {
  constexpr double kSpare_m = 5.0;
  return cell_coordinate(kSpare_m, grid.resolution_m());
}

/// Whether the table of the level can grow to contain `changed`.
Result<void> MultiResolutionGrid::check_room(std::size_t level, const CellBox& changed) const {
  if (level < tables_.size() && tables_[level].covers(changed)) return {};
  const OccupancyGrid& grid = grids_[level];
  CellBox box = grid.bounds().value_or(changed);
  box.extend(changed.min);
  box.extend(changed.max);
  const auto table = ProbabilityGrid::extent(box, options_.unknown_probability, margin(grid));
  return table ? Result<void>() : table.error();
}

Result<void> MultiResolutionGrid::follow(std::size_t level, const CellBox& changed) {
  const OccupancyGrid& grid = grids_[level];
  if (!grid.bounds() || tables_[level].update(grid, changed)) return {};
  // Of the old and the new table only one is in memory.
  tables_[level] = {};
  return tables_[level].make(grid, options_.unknown_probability, margin(grid));
}

}  // namespace wayfare
