// Measurement updates with detected walls.

#include <cmath>
#include <numbers>
#include <vector>

#include "nav/corridor_ins/engine.hpp"

namespace wayfare {
namespace {

using namespace corridor_state;
using Row = Eigen::Matrix<double, 1, kSize>;

/// After a corner the end wall becomes a side wall: its points must not be used twice.
bool end_is_side_wall(const corridor::Predicted& p, const CorridorWalls& detected) {
  constexpr double kAcross_rad = 0.5;
  if (!p.walls.end) return false;
  const double off = (p.walls.end->alpha - detected.direction).radians();
  return std::abs(std::remainder(off, std::numbers::pi)) > kAcross_rad;
}

}  // namespace

void CorridorIns::Engine::use_walls(const corridor::Predicted& predicted,
                                    CorridorScanUpdate& update) {
  const CorridorWalls& detected = *update.walls;
  const bool lost = scan_time_ && *scan_time_ - walls_time_ > options_.lost_after;
  const bool same = walls_.has_walls() && use_sides(predicted, detected);
  if (same) {
    rejections_ = 0;
    update.outcome = WallOutcome::used;
    ++report_.scans_used;
    walls_.enter_missing_side(detected, filter_);
  } else if (!walls_.has_walls() || lost || rejections_ >= options_.rejections_to_reacquire) {
    begin_corridor(detected, update);
  } else {
    ++rejections_;
    ++report_.refused_walls;
    update.outcome = WallOutcome::refused;
    if (rejections_ == 1) log_event(*scan_time_, "walls do not match their prediction");
  }
  if (options_.use_end_walls) update.end_used = use_end(predicted, detected, update);
  if (options_.memory == WallMemory::one_scan) remember_this_scan(detected);
}

void CorridorIns::Engine::begin_corridor(const CorridorWalls& detected,
                                         CorridorScanUpdate& update) {
  rejections_ = 0;
  ++report_.corridors;
  update.outcome = WallOutcome::reacquired;
  walls_.enter(detected, filter_);
  if (options_.memory == WallMemory::corridor) log_event(*scan_time_, "walls acquired");
  if (options_.square_sigma_rad > 0.0) set_square(detected);
}

void CorridorIns::Engine::set_square(const CorridorWalls& detected) {
  constexpr double kTolerance_rad = 0.2, kLong_m = 2.0;
  const auto is_long = [](const auto& wall) {
    return wall && wall->end_m - wall->begin_m > kLong_m;
  };
  if (!is_long(detected.left) && !is_long(detected.right)) return;
  const double direction = filter_.state()[kDirection];
  if (!first_direction_rad_) first_direction_rad_ = direction;
  const double off = std::remainder(direction - *first_direction_rad_, 0.5 * std::numbers::pi);
  if (std::abs(off) > kTolerance_rad) return;
  Row row = Row::Zero();
  row[kDirection] = 1.0;
  filter_.update([&](const CorridorVector&) {
    return ScalarMeasurement<double, Row>{-off, row,
                                          options_.square_sigma_rad * options_.square_sigma_rad};
  });
}

void CorridorIns::Engine::remember_this_scan(const CorridorWalls& detected) {
  walls_.enter(detected, filter_);
  if (detected.end && options_.use_end_walls) {
    walls_.enter_end(*detected.end, filter_);
  } else {
    walls_.forget_end();
  }
}

bool CorridorIns::Engine::use_sides(const corridor::Predicted& p, const CorridorWalls& detected) {
  const bool left = p.walls.left && detected.left, right = p.walls.right && detected.right;
  if (!left && !right) return false;
  if (use_rows(p, detected, left, right)) return true;
  if (!left || !right) return false;
  const bool one = use_rows(p, detected, true, false) || use_rows(p, detected, false, true);
  report_.refused_sides += one ? 1 : 0;
  return one;
}

bool CorridorIns::Engine::use_rows(const corridor::Predicted& p, const CorridorWalls& detected,
                                   bool left, bool right) {
  Eigen::Vector3d all(wrap_to_pi((detected.direction - p.walls.direction).radians()), 0.0, 0.0);
  if (left) all[1] = detected.left->offset_m - p.walls.left->offset_m;
  if (right) all[2] = detected.right->offset_m - p.walls.right->offset_m;
  std::vector<int> rows{0};
  if (left) rows.push_back(1);
  if (right) rows.push_back(2);
  const auto n = static_cast<Eigen::Index>(rows.size());
  Eigen::VectorXd innovation = all(rows);
  corridor::Rows h = p.rows(rows, Eigen::all);
  Eigen::MatrixXd r = detected.covariance(rows, rows);
  return filter_.update_block<Eigen::Dynamic>(innovation, h, r, gates_[n]);
}

bool CorridorIns::Engine::use_end(const corridor::Predicted& p, const CorridorWalls& detected,
                                  const CorridorScanUpdate& update) {
  if (end_is_side_wall(p, detected)) walls_.forget_end();
  if (!detected.end || update.outcome == WallOutcome::refused || end_is_side_wall(p, detected))
    return false;
  if (p.walls.end) {
    const Eigen::Vector2d innovation(
        wrap_to_pi((detected.end->alpha - p.walls.end->alpha).radians()),
        detected.end->rho_m - p.walls.end->rho_m);
    Eigen::Matrix2d r;
    r << detected.end->covariance(1, 1), detected.end->covariance(0, 1),
        detected.end->covariance(0, 1), detected.end->covariance(0, 0);
    if (filter_.update_block<2>(innovation, p.end_rows, r, gates_[2])) {
      end_rejections_ = 0;
      ++report_.end_walls_used;
      return true;
    }
    ++report_.refused_end_walls;
    if (++end_rejections_ < options_.rejections_to_reacquire) return false;
  }
  end_rejections_ = 0;
  walls_.enter_end(*detected.end, filter_);
  return false;
}

}  // namespace wayfare
