#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include <wayfare/map/detection_grid.hpp>

namespace wayfare {
namespace {

constexpr int kMaxRadius = 15;  // of the kernel, cells

Error invalid(const char* what) {
  return {ErrorCode::invalid, std::string("DetectionFieldMaker: ") + what};
}

bool usable(const DetectionViewOptions& o, double sigma_cells) {
  return o.hit_probability > 0.5 && o.hit_probability < 1.0 && sigma_cells >= 0.0 &&
         3.0 * sigma_cells <= kMaxRadius && o.background > 0.0 && std::isfinite(o.background) &&
         o.max_detections > 0.0 && std::isfinite(o.max_detections);
}

/// The cells the points can reach, none if they are not finite.
std::optional<CellBox> reachable(const PointSet& points, const SE2d& pose, const FieldReach& reach,
                                 double resolution_m) {
  Eigen::Array2d low = Eigen::Array2d::Constant(1e300), high = -low;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Array2d p = pose * Eigen::Vector2d(points[i].cast<double>());
    if (!p.allFinite()) return std::nullopt;
    low = low.min(p);
    high = high.max(p);
  }
  const double margin =
      reach.translation_m + reach.heading_rad * static_cast<double>(points.max_norm_m());
  if (!((high - low).maxCoeff() + 2.0 * margin < 1e4) || !(high.abs().maxCoeff() < 1e6))
    return std::nullopt;
  const Eigen::Vector2d edge = Eigen::Vector2d::Constant(margin);
  return CellBox{cell_of(Eigen::Vector2d(low) - edge, resolution_m),
                 cell_of(Eigen::Vector2d(high) + edge, resolution_m)};
}

}  // namespace

void DetectionFieldMaker::prepare_kernel(double sigma_cells) {
  if (sigma_cells == sigma_cells_) return;
  sigma_cells_ = sigma_cells;
  radius_ = static_cast<int>(std::ceil(3.0 * sigma_cells));
  kernel_.clear();
  float sum = 0.0F;
  for (int y = -radius_; y <= radius_; ++y)
    for (int x = -radius_; x <= radius_; ++x) {
      const double d2 = x * x + y * y;
      kernel_.push_back(sigma_cells > 0.0
                            ? static_cast<float>(std::exp(-0.5 * d2 / (sigma_cells * sigma_cells)))
                            : 1.0F);
      sum += kernel_.back();
    }
  for (float& k : kernel_) k /= sum;
}

/// Adds the kernel at every detection, including those just outside `box`.
void DetectionFieldMaker::spread(const OccupancyGrid& grid, const CellBox& box, double hit_nats) {
  using Tiles = OccupancyGrid::Tiles;
  const auto per_unit = static_cast<float>(1.0 / (LogOdds::kUnitsPerNat * hit_nats));
  const int width = static_cast<int>(box.width()), height = static_cast<int>(box.height());
  density_.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 0.0F);
  const int side = 2 * radius_ + 1;
  const auto add = [&](int x, int y, float n) {
    const int x0 = std::max(x - radius_, 0), x1 = std::min(x + radius_, width - 1);
    const int y0 = std::max(y - radius_, 0), y1 = std::min(y + radius_, height - 1);
    for (int v = y0; v <= y1; ++v) {
      float* row = density_.data() + std::ptrdiff_t{v} * width;
      const float* k = kernel_.data() + std::ptrdiff_t{v - y + radius_} * side - x + radius_;
      for (int u = x0; u <= x1; ++u) row[u] += n * k[u];
    }
  };
  const Cell low = box.min - Cell{radius_, radius_}, high = box.max + Cell{radius_, radius_};
  for (int ty = low.y & -Tiles::kSide; ty <= high.y; ty += Tiles::kSide)
    for (int tx = low.x & -Tiles::kSide; tx <= high.x; tx += Tiles::kSide) {
      const auto* tile = grid.tiles().find(Tiles::tile_of({tx, ty}));
      if (tile == nullptr) continue;
      for (int y = std::max(ty, low.y); y < std::min(ty + Tiles::kSide, high.y + 1); ++y)
        for (int x = std::max(tx, low.x); x < std::min(tx + Tiles::kSide, high.x + 1); ++x) {
          const std::int16_t l = (*tile)[Tiles::offset_in_tile({x, y})];
          if (l > 0) add(x - box.min.x, y - box.min.y, per_unit * static_cast<float>(l));
        }
    }
}

void DetectionFieldMaker::write(const DetectionViewOptions& options, LikelihoodField& view) const {
  const auto background = static_cast<float>(options.background);
  const auto per_nat = static_cast<float>(1.0 / view.log_step());
  const float* n = density_.data();
  for (int y = 0; y < view.height(); ++y) {
    std::uint16_t* row = view.data() + std::ptrdiff_t{y} * view.stride();
    for (int x = 0; x < view.width(); ++x, ++n) {
      if (*n == 0.0F) continue;
      const float value = std::log1p(*n / background) * per_nat;
      row[x] = static_cast<std::uint16_t>(
          std::min(value + 0.5F, static_cast<float>(LikelihoodField::kMaxValue)));
    }
  }
}

Result<void> DetectionFieldMaker::make(const OccupancyGrid& grid, const PointSet& points,
                                       const SE2d& T_map_points, const FieldReach& reach,
                                       const DetectionViewOptions& options, LikelihoodField& view) {
  const auto empty_with = [&](Error e) -> Result<void> {
    view = LikelihoodField();
    return e;
  };
  const double resolution = grid.resolution_m();
  if (!usable(options, options.blur_sigma_m / resolution) ||
      !(reach.translation_m >= 0 && reach.heading_rad >= 0))
    return empty_with(invalid("an option is out of range (the kernel may reach 15 cells)"));
  if (points.empty()) return empty_with(invalid("no points"));
  const auto box = reachable(points, T_map_points, reach, resolution);
  if (!box) return empty_with(invalid("a point or the pose is not finite or too far away"));
  const double floor = options.background / (options.max_detections + options.background);
  if (auto ok = view.reset(resolution, *box, floor); !ok) return ok;
  prepare_kernel(options.blur_sigma_m / resolution);
  spread(grid, *box, LogOdds::from_probability(options.hit_probability).nats());
  write(options, view);
  return {};
}

}  // namespace wayfare
