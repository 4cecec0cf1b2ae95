#include <wayfare/map/match_grid.hpp>

#include <algorithm>
#include <cmath>
#include <string>

namespace wayfare {

Result<void> PaddedTable::reset(double resolution_m, const CellBox& box, std::uint16_t fill) {
  width_ = height_ = 0;
  if (!(resolution_m > 0) || !std::isfinite(resolution_m))
    return Error{ErrorCode::invalid, "a map's table: the resolution must be positive"};
  const std::int64_t w = box.width() + 2 * kBorder, h = box.height() + 2 * kBorder;
  if (box.width() < 1 || box.height() < 1 || w > kMaxCells / h)
    return Error{ErrorCode::invalid, "a map's table: " + std::to_string(box.width()) + " x " +
                                         std::to_string(box.height()) + " cells cannot be held"};
  table_.assign(static_cast<std::size_t>(w * h), fill);
  resolution_m_ = resolution_m;
  origin_ = box.min;
  width_ = static_cast<int>(box.width());
  height_ = static_cast<int>(box.height());
  return {};
}

Result<void> MatchGrid::reset(double resolution_m, const CellBox& box, double floor_probability) {
  if (!(floor_probability > 0 && floor_probability < 1)) {
    *this = {};
    return Error{ErrorCode::invalid, "MatchGrid: the floor probability must lie within (0, 1)"};
  }
  log_floor_ = std::log(floor_probability);
  log_step_ = -log_floor_ / kMaxValue;
  return PaddedTable::reset(resolution_m, box, 0);
}

namespace {

std::vector<float> gaussian(double sigma_cells) {
  const int radius = static_cast<int>(std::ceil(3 * sigma_cells));
  std::vector<float> weights;
  float sum = 0;
  for (int i = -radius; i <= radius; ++i) {
    weights.push_back(static_cast<float>(std::exp(-0.5 * i * i / (sigma_cells * sigma_cells))));
    sum += weights.back();
  }
  for (float& w : weights) w /= sum;
  return weights;
}

/// Convolves lines of `n` values, `step` apart; what lies outside counts as `outside`.
void blur_line(float* line, int n, std::ptrdiff_t step, const std::vector<float>& weights,
               float outside, std::vector<float>& copy) {
  const int radius = static_cast<int>(weights.size() / 2);
  copy.assign(static_cast<std::size_t>(n + 2 * radius), outside);
  for (int i = 0; i < n; ++i) copy[static_cast<std::size_t>(i + radius)] = line[i * step];
  for (int i = 0; i < n; ++i) {
    float sum = 0;
    for (std::size_t k = 0; k < weights.size(); ++k)
      sum += weights[k] * copy[static_cast<std::size_t>(i) + k];
    line[i * step] = sum;
  }
}

void blur(std::vector<float>& p, int width, int height, double sigma_cells, float outside) {
  const std::vector<float> weights = gaussian(sigma_cells);
  std::vector<float> copy;
  for (int y = 0; y < height; ++y)
    blur_line(p.data() + std::ptrdiff_t{y} * width, width, 1, weights, outside, copy);
  for (int x = 0; x < width; ++x) blur_line(p.data() + x, height, width, weights, outside, copy);
}

std::vector<float> probabilities(const OccupancyGrid& grid, const CellBox& box, double unknown) {
  std::vector<float> p;
  p.reserve(static_cast<std::size_t>(box.width() * box.height()));
  for (int y = box.min.y; y <= box.max.y; ++y)
    for (int x = box.min.x; x <= box.max.x; ++x)
      p.push_back(static_cast<float>(grid.observed({x, y}) ? grid.probability({x, y}) : unknown));
  return p;
}

}  // namespace

Result<MatchGrid> match_grid(const OccupancyGrid& grid, const OccupancyViewOptions& options) {
  const double sigma_cells = options.blur_sigma_m / grid.resolution_m();
  if (!(sigma_cells >= 0 && sigma_cells <= 100) ||
      !(options.unknown_probability >= 0 && options.unknown_probability <= 1))
    return Error{ErrorCode::invalid, "match_grid: blur or unknown probability out of range"};
  if (!grid.bounds())
    return Error{ErrorCode::invalid, "match_grid: the occupancy grid holds no observed cell"};
  MatchGrid view;
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
          std::clamp(value, 0.0, static_cast<double>(MatchGrid::kMaxValue)));
    }
  }
  return view;
}

}  // namespace wayfare
