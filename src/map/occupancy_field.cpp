#include <wayfare/map/likelihood_field.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "map/kernels/kernels.hpp"

namespace wayfare {
namespace {

constexpr int kBlockBits = 4, kBlock = 1 << kBlockBits;  // divides a tile's side
constexpr int kBins = 32, kBinBits = 7;                  // of log-odds 0 … 4 nats
constexpr float kFarthestCell = 1 << 20;

using Tiles = OccupancyGrid::Tiles;

struct MarkedBlock {
  const Tiles::Tile* tile;
  Cell corner;

  /// The maps of many particles do not fit the caches: a block is read some blocks later.
  void prefetch() const {
    const std::int16_t* row = tile->data() + Tiles::offset_in_tile(corner);
    for (int y = 0; y < kBlock; ++y, row += Tiles::kSide) __builtin_prefetch(row);
  }
};

Error invalid_field(const char* what) {
  return {ErrorCode::invalid, std::string("OccupancyField: ") + what};
}

}  // namespace

void OccupancyFieldMaker::prepare_kernels(const OccupancyFieldOptions& o, double resolution_m) {
  if (o == prepared_ && resolution_m == prepared_resolution_m_ && !kernels_.empty()) return;
  const double sigma = o.sigma_m / resolution_m, log_floor = std::log(o.floor_probability);
  radius_ = static_cast<int>(std::ceil(sigma * std::sqrt(-2 * log_floor)));
  const int rows = 2 * radius_ + 1;
  kernel_width_ = (rows + 15) / 16 * 16;
  kernels_.assign(static_cast<std::size_t>(kBins * rows * kernel_width_), 0);
  threshold_ = std::max<std::int16_t>(0, LogOdds::from_probability(o.min_probability).fixed);
  std::uint16_t* out = kernels_.data();
  for (int bin = 0; bin < kBins; ++bin) {
    const double log_odds = ((bin << kBinBits) + (1 << (kBinBits - 1))) / LogOdds::kUnitsPerNat;
    const double peak = -std::log1p(std::exp(-log_odds));
    for (int y = -radius_; y <= radius_; ++y, out += kernel_width_)
      for (int x = -radius_; x <= radius_; ++x) {
        const double part = 1 - (peak - 0.5 * (x * x + y * y) / (sigma * sigma)) / log_floor;
        out[x + radius_] = static_cast<std::uint16_t>(
            std::lround(LikelihoodField::kMaxValue * std::max(0.0, part)));
      }
  }
  prepared_ = o;
  prepared_resolution_m_ = resolution_m;
}

Result<CellBox> OccupancyFieldMaker::place(const PointSet& points, const SE2d& pose,
                                           double resolution_m) {
  const auto n = static_cast<int>(points.padded_x_m().size());
  u_.resize(points.padded_x_m().size());
  v_.resize(u_.size());
  base_ = cell_of(pose.translation(), resolution_m);
  const double scale = 1 / resolution_m;
  const auto& kernel = kernels::best_kernels();
  kernel.place(points.padded_x_m().data(), points.padded_y_m().data(), n,
               static_cast<float>(pose.rotation().cos() * scale),
               static_cast<float>(pose.rotation().sin() * scale),
               static_cast<float>(pose.x() * scale - base_.x),
               static_cast<float>(pose.y() * scale - base_.y), kFarthestCell, u_.data(), v_.data());
  CellBox box;
  kernel.min_max(u_.data(), n, &box.min.x, &box.max.x);
  kernel.min_max(v_.data(), n, &box.min.y, &box.max.y);
  constexpr int kEdge = 1 << 20;
  if (box.min.x <= -kEdge || box.min.y <= -kEdge || box.max.x >= kEdge || box.max.y >= kEdge)
    return invalid_field("a point is not finite or too far away");
  return CellBox{box.min + base_, box.max + base_};
}

/// Marks the blocks with a cell whose kernel reaches a possible position of a point.
void OccupancyFieldMaker::mark(const PointSet& points, const FieldReach& reach,
                               double resolution_m) {
  const auto columns = static_cast<std::size_t>(blocks_.width());
  marks_.assign(static_cast<std::size_t>(blocks_.cells()), 0);
  const float fixed =
      static_cast<float>(reach.translation_m / resolution_m) + static_cast<float>(radius_) + 1;
  const float per_m = static_cast<float>(reach.heading_rad / resolution_m);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector2f p = points[i];
    const int margin = static_cast<int>(fixed + per_m * (std::abs(p.x()) + std::abs(p.y())));
    const int u = u_[i] + base_.x, v = v_[i] + base_.y;
    const int x0 = std::max((u - margin) >> kBlockBits, blocks_.min.x) - blocks_.min.x;
    const int x1 = std::min((u + margin) >> kBlockBits, blocks_.max.x) - blocks_.min.x;
    const int y0 = std::max((v - margin) >> kBlockBits, blocks_.min.y) - blocks_.min.y;
    const int y1 = std::min((v + margin) >> kBlockBits, blocks_.max.y) - blocks_.min.y;
    for (int y = y0; y <= y1; ++y) {
      std::uint8_t* row = marks_.data() + static_cast<std::size_t>(y) * columns;
      for (int x = x0; x <= x1; ++x) row[x] = 1;
    }
  }
}

/// The points rotate about the pose, so each stays on its circle.
CellBox OccupancyFieldMaker::reachable_blocks(const CellBox& box, float max_norm_m,
                                              const FieldReach& reach, double resolution_m) const {
  const double norm = static_cast<double>(max_norm_m);
  const double fixed = reach.translation_m / resolution_m + radius_ + 2;
  const int moved =
      static_cast<int>(std::min(fixed + reach.heading_rad * norm / resolution_m, 1e5));
  const int circle = static_cast<int>(std::min(fixed + norm / resolution_m, 1e5));
  const auto low = [&](int edge, int centre) {
    return std::max(edge - moved, centre - circle) >> kBlockBits;
  };
  const auto high = [&](int edge, int centre) {
    return std::min(edge + moved, centre + circle) >> kBlockBits;
  };
  return {{low(box.min.x, base_.x), low(box.min.y, base_.y)},
          {high(box.max.x, base_.x), high(box.max.y, base_.y)}};
}

void OccupancyFieldMaker::stamp_block(const Tiles::Tile& tile, const Cell& corner,
                                      LikelihoodField& view) {
  const auto stamp = kernels::best_kernels().stamp;
  const int rows = 2 * radius_ + 1;
  const std::int16_t* row = tile.data() + Tiles::offset_in_tile(corner);
  for (int y = 0; y < kBlock; ++y, row += Tiles::kSide) {
    std::int16_t max_log_odds = row[0];
    for (int x = 1; x < kBlock; ++x) max_log_odds = std::max(max_log_odds, row[x]);
    if (max_log_odds <= threshold_) continue;
    std::uint16_t* target =
        view.data() + corner.x - view.origin().x - radius_ +
        std::ptrdiff_t{corner.y + y - view.origin().y - radius_} * view.stride();
    for (int x = 0; x < kBlock; ++x) {
      if (row[x] <= threshold_) continue;
      const int bin = std::min(row[x] >> kBinBits, kBins - 1);
      stamp(target + x, view.stride(), kernels_.data() + bin * rows * kernel_width_, kernel_width_,
            rows);
    }
  }
}

Result<void> OccupancyFieldMaker::make(const OccupancyGrid& grid, const PointSet& points,
                                       const SE2d& T_map_points, const FieldReach& reach,
                                       const OccupancyFieldOptions& options,
                                       LikelihoodField& view) {
  const auto empty_with = [&](Error e) -> Result<void> {
    view = LikelihoodField();
    return e;
  };
  const double resolution = grid.resolution_m(), floor = options.floor_probability;
  const double radius_m = options.sigma_m * std::sqrt(-2 * std::log(floor));
  if (!(floor > 0 && floor < 1) || !(options.sigma_m > 0) || !(radius_m <= 15 * resolution) ||
      !(options.min_probability > 0 && options.min_probability < 1) ||
      !(reach.translation_m >= 0 && reach.heading_rad >= 0))
    return empty_with(invalid_field("an option is out of range (the kernel may reach 15 cells)"));
  if (points.empty()) return empty_with(invalid_field("no points"));
  if (!T_map_points.translation().allFinite() || !std::isfinite(T_map_points.heading().radians()))
    return empty_with(invalid_field("the pose is not finite"));
  auto box = place(points, T_map_points, resolution);
  if (!box) return empty_with(box.error());
  prepare_kernels(options, resolution);
  // No point moves farther than all around its circle.
  const FieldReach within{reach.translation_m, std::min(reach.heading_rad, 2.0 * std::numbers::pi)};
  blocks_ = reachable_blocks(*box, points.max_norm_m(), within, resolution);
  const Cell low = blocks_.min, high = blocks_.max;
  const CellBox covered{{low.x * kBlock, low.y * kBlock},
                        {high.x * kBlock + kBlock - 1, high.y * kBlock + kBlock - 1}};
  if (auto ok = view.reset(resolution, covered.grown(radius_), floor); !ok) return ok;
  mark(points, within, resolution);
  std::vector<MarkedBlock> blocks;
  blocks.reserve(static_cast<std::size_t>(std::count(marks_.begin(), marks_.end(), 1)));
  const std::uint8_t* marked = marks_.data();
  for (int y = blocks_.min.y; y <= blocks_.max.y; ++y)
    for (int x = blocks_.min.x; x <= blocks_.max.x; ++x, ++marked) {
      if (*marked == 0) continue;
      const Cell corner{x * kBlock, y * kBlock};
      const auto* tile = grid.tiles().find(Tiles::tile_of(corner));
      if (tile != nullptr) blocks.push_back({tile, corner});
    }
  constexpr std::size_t kAhead = 4;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (i + kAhead < blocks.size()) blocks[i + kAhead].prefetch();
    stamp_block(*blocks[i].tile, blocks[i].corner, view);
  }
  return {};
}

}  // namespace wayfare
