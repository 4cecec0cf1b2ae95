#include <wayfare/map/likelihood_field.hpp>

#include <algorithm>
#include <cmath>
#include <string>

#include "map/kernels/kernels.hpp"

namespace wayfare {
namespace {

constexpr int kPhases = 4;  // positions of a point within a cell, per axis
constexpr float kLimit = 1 << 20;

}  // namespace

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

void LikelihoodFieldMaker::prepare_kernels(const LikelihoodFieldOptions& options) {
  if (options == prepared_ && !kernels_.empty()) return;
  const double sigma = options.sigma_m / options.resolution_m;
  const double log_floor = std::log(options.floor_probability);
  radius_ = static_cast<int>(std::ceil(sigma * std::sqrt(-2 * log_floor)));
  const int rows = 2 * radius_ + 1;
  kernel_width_ = (rows + 15) / 16 * 16;
  kernels_.assign(static_cast<std::size_t>(kPhases * kPhases * rows * kernel_width_), 0);
  std::uint16_t* out = kernels_.data();
  for (int phase = 0; phase < kPhases * kPhases; ++phase) {
    const int column = phase % kPhases, row = phase / kPhases;
    const double qx = (column + 0.5) / kPhases - 0.5, qy = (row + 0.5) / kPhases - 0.5;
    for (int y = -radius_; y <= radius_; ++y, out += kernel_width_)
      for (int x = -radius_; x <= radius_; ++x) {
        const double square = (x - qx) * (x - qx) + (y - qy) * (y - qy);
        const double part = 1 - -0.5 * square / (sigma * sigma) / log_floor;
        out[x + radius_] = static_cast<std::uint16_t>(
            std::lround(LikelihoodField::kMaxValue * std::max(0.0, part)));
      }
  }
  prepared_ = options;
}

Result<CellBox> LikelihoodFieldMaker::place(std::span<const PlacedPoints> scans,
                                            double resolution_m) {
  std::size_t total = 0;
  for (const PlacedPoints& s : scans) total += s.points->padded_x_m().size();
  x_.resize(total);
  y_.resize(total);
  base_ = cell_of(scans.empty() ? Eigen::Vector2d::Zero() : scans[0].T_map_points.translation(),
                  resolution_m);
  const double scale = kPhases / resolution_m;
  std::size_t at = 0;
  for (const PlacedPoints& s : scans) {
    const auto x = s.points->padded_x_m(), y = s.points->padded_y_m();
    const SE2d& pose = s.T_map_points;
    kernels::best_kernels().place(
        x.data(), y.data(), static_cast<int>(x.size()),
        static_cast<float>(pose.rotation().cos() * scale),
        static_cast<float>(pose.rotation().sin() * scale),
        static_cast<float>(pose.x() * scale - kPhases * static_cast<double>(base_.x)),
        static_cast<float>(pose.y() * scale - kPhases * static_cast<double>(base_.y)), kLimit,
        x_.data() + at, y_.data() + at);
    at += x.size();
  }
  if (total == 0) return Error{ErrorCode::invalid, "likelihood_field: no points"};
  std::int32_t x0, x1, y0, y1;
  kernels::best_kernels().min_max(x_.data(), static_cast<int>(total), &x0, &x1);
  kernels::best_kernels().min_max(y_.data(), static_cast<int>(total), &y0, &y1);
  constexpr std::int32_t kEdge = static_cast<std::int32_t>(kLimit);
  if (x0 == -kEdge || y0 == -kEdge || x1 == kEdge || y1 == kEdge)
    return Error{ErrorCode::invalid,
                 "likelihood_field: a point or pose is not finite, or farther "
                 "than 2^18 cells from the first pose"};
  // Padded points repeat real ones, so the box is correct.
  return CellBox{Cell{x0 >> 2, y0 >> 2} + base_, Cell{x1 >> 2, y1 >> 2} + base_};
}

Result<void> LikelihoodFieldMaker::make(std::span<const PlacedPoints> scans,
                                        const LikelihoodFieldOptions& options,
                                        LikelihoodField& grid) {
  const auto empty_with = [&](Error e) -> Result<void> {
    grid = LikelihoodField();
    return e;
  };
  const double sigma = options.sigma_m / options.resolution_m;
  const double floor = options.floor_probability;
  if (!(options.resolution_m > 0) || !(sigma > 0) || !(floor > 0 && floor < 1) ||
      !(sigma * std::sqrt(-2 * std::log(floor)) <= 30))
    return empty_with({ErrorCode::invalid,
                       "likelihood_field: resolution, sigma or floor out of range (the kernel may "
                       "reach 30 cells)"});
  for (const PlacedPoints& s : scans) {
    if (s.points == nullptr)
      return empty_with({ErrorCode::invalid, "likelihood_field: a pose without points"});
    const double pose_sum = s.T_map_points.translation().sum() + s.T_map_points.rotation().cos();
    if (!std::isfinite(pose_sum) || std::abs(pose_sum) / options.resolution_m > kMaxCell)
      return empty_with({ErrorCode::invalid, "likelihood_field: a pose is not finite"});
  }
  const auto box = place(scans, options.resolution_m);
  if (!box) return empty_with(box.error());
  prepare_kernels(options);
  if (auto ok = grid.reset(options.resolution_m, box->grown(radius_), floor); !ok) return ok;

  const auto stamp = kernels::best_kernels().stamp;
  const int rows = 2 * radius_ + 1;
  const Cell corner = box->min - base_;
  const std::ptrdiff_t kernel_size = std::ptrdiff_t{rows} * kernel_width_;
  std::size_t at = 0;
  for (const PlacedPoints& s : scans) {
    for (std::size_t i = at; i < at + s.points->size(); ++i) {
      const int phase = (y_[i] & 3) * kPhases + (x_[i] & 3);
      const int column = (x_[i] >> 2) - corner.x, row = (y_[i] >> 2) - corner.y;
      stamp(grid.data() + std::ptrdiff_t{row} * grid.stride() + column, grid.stride(),
            kernels_.data() + phase * kernel_size, kernel_width_, rows);
    }
    at += s.points->padded_x_m().size();
  }
  return {};
}

Result<LikelihoodField> likelihood_field(std::span<const PlacedPoints> scans,
                                         const LikelihoodFieldOptions& options) {
  LikelihoodField grid;
  LikelihoodFieldMaker maker;
  if (auto ok = maker.make(scans, options, grid); !ok) return ok.error();
  return grid;
}

}  // namespace wayfare
