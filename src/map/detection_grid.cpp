#include <wayfare/map/detection_grid.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "map/blur.hpp"

namespace wayfare {
namespace {

std::vector<float> detections(const OccupancyGrid& grid, const CellBox& box, double hit_nats) {
  std::vector<float> n;
  n.reserve(static_cast<std::size_t>(box.width() * box.height()));
  for (int y = box.min.y; y <= box.max.y; ++y)
    for (int x = box.min.x; x <= box.max.x; ++x)
      n.push_back(static_cast<float>(std::max(0.0, grid.log_odds({x, y}).nats() / hit_nats)));
  return n;
}

bool usable(const DetectionViewOptions& o, double sigma_cells) {
  return o.max_detections >= 0.0 && std::isfinite(o.max_detections) && o.hit_probability > 0.5 &&
         o.hit_probability < 1.0 && sigma_cells >= 0.0 && sigma_cells <= 100.0 &&
         o.background > 0.0 && std::isfinite(o.background);
}

}  // namespace

Result<LikelihoodField> detection_grid(const OccupancyGrid& grid,
                                       const DetectionViewOptions& options) {
  const double sigma_cells = options.blur_sigma_m / grid.resolution_m();
  if (!usable(options, sigma_cells))
    return Error{ErrorCode::invalid,
                 "detection_grid: hit probability, blur or background out of range"};
  if (!grid.bounds()) return Error{ErrorCode::invalid, "detection_grid: the map has no detections"};
  const CellBox& box = *grid.bounds();
  LikelihoodField view;
  // Fails on a map that is too large before anything of its size is allocated.
  if (auto ok = view.reset(grid.resolution_m(), box, 0.5); !ok) return ok.error();
  std::vector<float> n =
      detections(grid, box, LogOdds::from_probability(options.hit_probability).nats());
  if (sigma_cells > 0.0)
    blur(n, static_cast<int>(box.width()), static_cast<int>(box.height()), sigma_cells, 0.0F);
  const double most =
      (options.max_detections > 0.0 ? options.max_detections
                                    : static_cast<double>(*std::max_element(n.begin(), n.end()))) +
      options.background;
  // Cells without detections have the same value inside the map and outside.
  if (auto ok = view.reset(grid.resolution_m(), box, options.background / most); !ok)
    return ok.error();
  std::size_t i = 0;
  for (int y = 0; y < view.height(); ++y) {
    std::uint16_t* row = view.data() + std::ptrdiff_t{y} * view.stride();
    for (int x = 0; x < view.width(); ++x) {
      const auto here = static_cast<double>(n[i++]);
      if (here == 0.0) continue;  // the table is zero already
      const double ln = std::log((here + options.background) / most);
      const double value = std::round((ln - view.log_floor()) / view.log_step());
      row[x] = static_cast<std::uint16_t>(
          std::clamp(value, 0.0, static_cast<double>(LikelihoodField::kMaxValue)));
    }
  }
  return view;
}

}  // namespace wayfare
