#include <wayfare/map/likelihood_field.hpp>

#include <algorithm>
#include <cmath>
#include <string>

#include "map/blur.hpp"

namespace wayfare {

Result<void> PaddedTable::check_size(const CellBox& box) {
  const std::int64_t w = box.width() + 2 * kBorder, h = box.height() + 2 * kBorder;
  if (box.width() < 1 || box.height() < 1 || w > kMaxCells / h)
    return Error{ErrorCode::invalid, "map table: " + std::to_string(box.width()) + " x " +
                                         std::to_string(box.height()) + " cells are too many"};
  return {};
}

Result<void> PaddedTable::reset(double resolution_m, const CellBox& box, std::uint16_t fill) {
  width_ = 0;
  height_ = 0;
  if (!(resolution_m > 0) || !std::isfinite(resolution_m))
    return Error{ErrorCode::invalid, "map table: the resolution must be positive"};
  if (auto ok = check_size(box); !ok) return ok;
  const std::int64_t w = box.width() + 2 * kBorder, h = box.height() + 2 * kBorder;
  table_.assign(static_cast<std::size_t>(w * h), fill);
  resolution_m_ = resolution_m;
  origin_ = box.min;
  width_ = static_cast<int>(box.width());
  height_ = static_cast<int>(box.height());
  return {};
}

Result<void> LikelihoodField::reset(double resolution_m, const CellBox& box,
                                    double floor_probability) {
  if (!(floor_probability > 0 && floor_probability < 1)) {
    *this = {};
    return Error{ErrorCode::invalid,
                 "LikelihoodField: the floor probability must lie within (0, 1)"};
  }
  log_floor_ = std::log(floor_probability);
  log_step_ = -log_floor_ / kMaxValue;
  return PaddedTable::reset(resolution_m, box, 0);
}

namespace {

std::vector<float> probabilities(const OccupancyGrid& grid, const CellBox& box, double unknown) {
  std::vector<float> p;
  p.reserve(static_cast<std::size_t>(box.width() * box.height()));
  for (int y = box.min.y; y <= box.max.y; ++y)
    for (int x = box.min.x; x <= box.max.x; ++x)
      p.push_back(static_cast<float>(grid.observed({x, y}) ? grid.probability({x, y}) : unknown));
  return p;
}

}  // namespace

Result<LikelihoodField> likelihood_field(const OccupancyGrid& grid,
                                         const OccupancyViewOptions& options) {
  const double sigma_cells = options.blur_sigma_m / grid.resolution_m();
  if (!(sigma_cells >= 0 && sigma_cells <= 100) ||
      !(options.unknown_probability >= 0 && options.unknown_probability <= 1))
    return Error{ErrorCode::invalid, "likelihood_field: blur or unknown probability out of range"};
  if (!grid.bounds())
    return Error{ErrorCode::invalid, "likelihood_field: the occupancy grid has no observed cell"};
  LikelihoodField view;
  const CellBox& box = *grid.bounds();
  if (auto ok = view.reset(grid.resolution_m(), box, options.floor_probability); !ok)
    return ok.error();
  std::vector<float> p = probabilities(grid, box, options.unknown_probability);
  const float outside = static_cast<float>(options.unknown_probability);
  if (sigma_cells > 0) blur(p, view.width(), view.height(), sigma_cells, outside);
  std::size_t i = 0;
  for (int y = 0; y < view.height(); ++y) {
    std::uint16_t* row = view.data() + std::ptrdiff_t{y} * view.stride();
    for (int x = 0; x < view.width(); ++x) {
      const double ln = std::log(std::max(1e-12, static_cast<double>(p[i++])));
      const double value = std::round((ln - view.log_floor()) / view.log_step());
      row[x] = static_cast<std::uint16_t>(
          std::clamp(value, 0.0, static_cast<double>(LikelihoodField::kMaxValue)));
    }
  }
  return view;
}

}  // namespace wayfare
