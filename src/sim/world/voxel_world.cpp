#include <wayfare/sim/worlds.hpp>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "sim/world/places.hpp"

namespace wayfare::sim {
namespace {

using Eigen::Vector2d;

// Voxels between two heights as an image of solid cells, with the path kept clear.
class VoxelSlice {
 public:
  VoxelSlice(std::span<const Eigen::Vector3d> voxels_m, std::span<const Vector2d> path_m,
             const VoxelWorldParams& params)
      : params_(params) {
    Vector2d lower = path_m[0], upper = path_m[0];
    for (const Eigen::Vector3d& v : voxels_m) {
      if (v.z() < params.lowest_m || v.z() > params.highest_m) continue;
      lower = lower.cwiseMin(v.head<2>());
      upper = upper.cwiseMax(v.head<2>());
    }
    constexpr double kMargin_m = 1.5;
    origin_m_ = (lower.array() - kMargin_m).matrix();
    const Vector2d extent = (upper - lower).array() + 2.0 * kMargin_m;
    mask_.cell_m = params.voxel_m;
    mask_.width = 1 + static_cast<int>(extent.x() / params.voxel_m);
    mask_.height = 1 + static_cast<int>(extent.y() / params.voxel_m);
    count(voxels_m);
    for (const Vector2d& place : places_along({path_m.begin(), path_m.end()})) clear(place);
    enclose();
  }

  [[nodiscard]] const Vector2d& origin_m() const { return origin_m_; }
  [[nodiscard]] Result<FloorPlan> plan() const { return FloorPlan::from_cells(mask_); }

 private:
  [[nodiscard]] int column_of(double x) const {
    return static_cast<int>(std::floor((x - origin_m_.x()) / params_.voxel_m));
  }
  [[nodiscard]] int row_of(double y) const {
    return mask_.height - 1 - static_cast<int>(std::floor((y - origin_m_.y()) / params_.voxel_m));
  }

  void count(std::span<const Eigen::Vector3d> voxels_m) {
    mask_.solid.assign(mask_.index(0, mask_.height), 0);
    for (const Eigen::Vector3d& v : voxels_m) {
      if (v.z() < params_.lowest_m || v.z() > params_.highest_m) continue;
      std::uint8_t& cell = mask_.solid[mask_.index(column_of(v.x()), row_of(v.y()))];
      if (cell < 255) ++cell;
    }
    for (std::uint8_t& cell : mask_.solid) cell = cell >= params_.min_stacked ? 1 : 0;
  }

  void clear(const Vector2d& place) {
    const int reach = 1 + static_cast<int>(params_.clear_m / params_.voxel_m);
    const int c = column_of(place.x()), r = row_of(place.y());
    for (int row = std::max(1, r - reach); row <= std::min(mask_.height - 2, r + reach); ++row)
      for (int col = std::max(1, c - reach); col <= std::min(mask_.width - 2, c + reach); ++col)
        mask_.solid[mask_.index(col, row)] = 0;
  }

  void enclose() {
    for (int c = 0; c < mask_.width; ++c)
      mask_.solid[mask_.index(c, 0)] = mask_.solid[mask_.index(c, mask_.height - 1)] = 1;
    for (int r = 0; r < mask_.height; ++r)
      mask_.solid[mask_.index(0, r)] = mask_.solid[mask_.index(mask_.width - 1, r)] = 1;
  }

  const VoxelWorldParams& params_;
  Vector2d origin_m_ = Vector2d::Zero();
  CellMask mask_;
};

// Voxels of the slice and path within an image that fits in memory.
Result<void> check_extent(std::span<const Eigen::Vector3d> voxels_m,
                          std::span<const Eigen::Vector3d> path_m, const VoxelWorldParams& params) {
  constexpr double kMaxCells = 1 << 26, kFarthest_m = 1e5;
  Eigen::Array2d lower = Eigen::Array2d::Constant(kFarthest_m), upper = -lower;
  const auto add = [&](const Eigen::Vector3d& p) {
    if (!p.allFinite() || p.head<2>().cwiseAbs().maxCoeff() > kFarthest_m) return false;
    lower = lower.min(p.head<2>().array());
    upper = upper.max(p.head<2>().array());
    return true;
  };
  for (std::size_t i = 0; i < path_m.size(); ++i)
    if (!add(path_m[i]))
      return Error{ErrorCode::invalid,
                   "position " + std::to_string(i) + " of the path is not finite or beyond 100 km"};
  for (std::size_t i = 0; i < voxels_m.size(); ++i) {
    const double z = voxels_m[i].z();
    if (z < params.lowest_m || z > params.highest_m) continue;
    if (!add(voxels_m[i]))
      return Error{ErrorCode::invalid,
                   "voxel " + std::to_string(i) + " is not finite or beyond 100 km"};
  }
  if (((upper - lower + 4.0) / params.voxel_m).prod() > kMaxCells)
    return Error{ErrorCode::invalid, "the world of voxels has more than 67 million cells"};
  return {};
}

}  // namespace

Result<World> world_of_voxels(std::span<const Eigen::Vector3d> voxels_m,
                              std::span<const Eigen::Vector3d> path_m,
                              const VoxelWorldParams& params, const Rng& rng) {
  std::vector<Vector2d> route;
  for (const Eigen::Vector3d& at : path_m)
    if (route.empty() || (at.head<2>() - route.back()).norm() >= params.step_m)
      route.emplace_back(at.head<2>());
  if (!(params.voxel_m > 0.0) || !(params.clear_m >= 0.0) || !std::isfinite(params.clear_m) ||
      params.min_stacked < 1)
    return Error{ErrorCode::invalid, "a world of voxels needs a positive voxel size"};
  if (auto ok = check_extent(voxels_m, path_m, params); !ok) return ok.error();
  if (route.size() < 3)
    return Error{ErrorCode::invalid, "the path through the voxels is shorter than two steps"};
  VoxelSlice slice(voxels_m, route, params);
  auto plan = slice.plan();
  if (!plan) return plan.error();
  for (Vector2d& place : route) place -= slice.origin_m();
  FurnishParams furnish;
  // A wall of cells has two faces, and steps that are no corners.
  furnish.corner_wall_m = 4.0 * params.voxel_m;
  return furnished_world(std::move(plan).value(), std::move(route), {}, furnish, rng);
}

}  // namespace wayfare::sim
