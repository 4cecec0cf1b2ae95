#include <wayfare/nav/corridor_ins.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <utility>

#include <wayfare/core/statistics.hpp>

#include "nav/corridor_ins/corridor_marks.hpp"
#include "nav/corridor_ins/motion_watch.hpp"
#include "nav/corridor_ins/start_filter.hpp"
#include "nav/corridor_ins/wall_finder.hpp"
#include "nav/corridor_ins/wall_states.hpp"

namespace wayfare {
namespace {

using namespace corridor;

/// After a corner the end wall becomes a side wall: its points must not be used twice.
bool end_is_side_wall(const Predicted& p, const CorridorWalls& detected) {
  constexpr double kAcross_rad = 0.5;
  if (!p.walls.end) return false;
  const double off = (p.walls.end->alpha - detected.direction).radians();
  return std::abs(std::remainder(off, std::numbers::pi)) > kAcross_rad;
}

}  // namespace

/// Implementation of CorridorIns.
class CorridorIns::Engine {
 public:
  Engine(const CorridorInsOptions& options, const SE2d& start)
      : options_(options),
        filter_(start_filter(options, start)),
        process_(options.noise),
        watch_(options),
        finder_(options),
        walls_(options.T_base_laser.raw()) {
    for (int dof = 1; dof <= 3; ++dof)
      gates_[dof] = chi_square_quantile(1.0 - options.gate_probability, dof);
  }

  Result<void> add_motion(const MotionSample& s) {
    const auto refuse = [this](const char* why) {
      ++report_.refused_samples;
      return Error{ErrorCode::invalid, why, {}};
    };
    if (!plausible(s))
      return refuse("the turn rate or speed of a motion sample is not below 1000 rad/s or m/s");
    if (time_ && s.time <= *time_) return refuse("a motion sample is not after the previous one");
    // The first sample only gives the start time.
    if (time_) step(s, s.time - *time_);
    time_ = s.time;
    return {};
  }

  Result<CorridorScanUpdate> add_scan(const LaserScan& scan) {
    if (scan_time_ && scan.time <= *scan_time_)
      return Error{ErrorCode::invalid, "a scan is not after the previous one", {}};
    CorridorScanUpdate update;
    if (is_too_soon(scan.time)) {
      ++report_.skipped_scans;
      update.outcome = WallOutcome::skipped;
      return update;
    }
    if (!scan_time_) walls_time_ = scan.time;
    scan_time_ = scan.time;
    ++report_.scans;
    if (!options_.use_walls) return update;
    const Predicted predicted = walls_.predict(filter_);
    finder_.find(scan, predicted, walls_.has_walls(),
                 rejections_ < options_.rejections_to_reacquire, report_, update);
    if (update.walls) {
      use_walls(predicted, update);
      if (options_.marks_sigma_m > 0.0) update.marks_used = use_marks(scan, update);
      walls_time_ = scan.time;
    } else {
      report_.longest_outage = std::max(report_.longest_outage, scan.time - walls_time_);
      if (options_.memory == WallMemory::one_scan) walls_.forget_walls(), walls_.forget_end();
    }
    if (options_.building_sigma_rad > 0.0 && first_direction_rad_)
      update.heading_used = use_building(scan);
    return update;
  }

  [[nodiscard]] const Filter& filter() const { return filter_; }
  [[nodiscard]] const CorridorReport& report() const { return report_; }

 private:
  void log_event(LogTime time, std::string what) {
    if (report_.events.size() < 100) report_.events.push_back({time, std::move(what)});
  }

  /// With a margin for the jitter of times.
  [[nodiscard]] bool is_too_soon(LogTime time) const {
    return scan_time_ &&
           1.02 * to_seconds(time - *scan_time_) < to_seconds(options_.least_scan_interval);
  }

  void step(const MotionSample& s, Duration dt) {
    const auto checked = watch_.check(s, dt);
    report_.saturated_samples += checked.saturated ? 1 : 0;
    report_.slipping_samples += checked.slipping ? 1 : 0;
    if (checked.saturated && !saturated_) log_event(s.time, "gyro beyond its range");
    if (checked.slip_began) log_event(s.time, "wheels slip");
    saturated_ = checked.saturated;
    filter_.predict(process_, checked.input);
    // Without walls a large covariance does no harm.
    if (options_.use_walls && is_lost(filter_.covariance())) restart(s.time);
    if (checked.input.at_rest) calibrate_at_rest(checked.input);
  }

  void restart(LogTime time) {
    filter_ = restart_filter(options_, filter_);
    walls_.forget_walls(), walls_.forget_end();
    first_direction_rad_.reset();
    restarted_ = true;
    log_event(time, "heading or position unknown");
  }

  /// While the wheels stand the gyro reads bias and noise only.
  void calibrate_at_rest(const CorridorInput& u) {
    ++report_.rest_samples;
    const double walk = options_.noise.angle_random_walk_rad_per_sqrt_s;
    filter_.update(
        [&](const CorridorState& x) {
          return ScalarMeasurement<double, SparseRow<double, 2>>{
              u.turn_rate_rad_s - (x.get<BiasWalk>()[0] + x.get<Bias>()[0]),
              {{x.index<BiasWalk>(), x.index<Bias>()}, {1.0, 1.0}},
              walk * walk / u.dt_s};
        },
        6.0);
  }

  void use_walls(const Predicted& predicted, CorridorScanUpdate& update) {
    const CorridorWalls& detected = *update.walls;
    const bool lost = scan_time_ && *scan_time_ - walls_time_ > options_.lost_after;
    if (walls_.has_walls() && use_sides(predicted, detected)) {
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

  void begin_corridor(const CorridorWalls& detected, CorridorScanUpdate& update) {
    rejections_ = 0;
    ++report_.corridors;
    update.outcome = WallOutcome::reacquired;
    walls_.enter(detected, filter_);
    if (options_.memory == WallMemory::corridor) log_event(*scan_time_, "walls acquired");
    if (options_.square_sigma_rad > 0.0) set_square(detected);
  }

  /// Constrains nearly parallel or orthogonal walls to be exactly so relative to the first ones.
  void set_square(const CorridorWalls& detected) {
    constexpr double kTolerance_rad = 0.2, kLong_m = 2.0;
    const auto is_long = [](const auto& wall) {
      return wall && wall->end_m - wall->begin_m > kLong_m;
    };
    if (!is_long(detected.left) && !is_long(detected.right)) return;
    const double direction = filter_.state().get<Sides>()[0];
    // After a restart the first direction only defines the others: the heading is unknown.
    if (!first_direction_rad_) {
      first_direction_rad_ = direction;
      if (restarted_) return;
    }
    const double off = std::remainder(direction - *first_direction_rad_, 0.5 * std::numbers::pi);
    if (std::abs(off) > kTolerance_rad) return;
    filter_.update([&](const CorridorState& x) {
      return ScalarMeasurement<double, SparseRow<double, 1>>{
          -off, {{x.index<Sides>()}, {1.0}}, options_.square_sigma_rad * options_.square_sigma_rad};
    });
  }

  /// The heading relative to the building, whose walls are along or across the first ones.
  bool use_building(const LaserScan& scan) {
    constexpr double kNear_rad = 0.25, kFar_rad = 0.6, kLeastShare = 0.5;
    const double sigma = sigma_of(variances<Heading>(filter_.covariance())[0]);
    const Angle expected =
        Angle::radians(*first_direction_rad_ - filter_.state().get<Heading>()[0]) -
        options_.T_base_laser.raw().heading();
    const auto seen = finder_.detector().square_direction(
        scan, expected, Angle::radians(std::clamp(3.0 * sigma, kNear_rad, kFar_rad)));
    if (!seen || seen->length_m < kLeastShare * seen->total_m) return false;
    ++report_.headings_used;
    const double off =
        std::remainder((expected - seen->direction).radians(), 0.5 * std::numbers::pi);
    const double sigma2 = options_.building_sigma_rad * options_.building_sigma_rad;
    filter_.update([&](const CorridorState& x) {
      return ScalarMeasurement<double, SparseRow<double, 1>>{
          off, {{x.index<Heading>()}, {1.0}}, sigma2};
    });
    return true;
  }

  void remember_this_scan(const CorridorWalls& detected) {
    walls_.enter(detected, filter_);
    if (detected.end && options_.use_end_walls) {
      walls_.enter_end(*detected.end, filter_);
    } else {
      walls_.forget_end();
    }
  }

  /// Updates with direction and both offsets; if rejected, with one side or the other.
  bool use_sides(const Predicted& p, const CorridorWalls& detected) {
    const bool left = p.walls.left && detected.left, right = p.walls.right && detected.right;
    if (!left && !right) return false;
    if (left && right && use_rows<3>(p, detected, {0, 1, 2})) return true;
    const bool one =
        (left && use_rows<2>(p, detected, {0, 1})) || (right && use_rows<2>(p, detected, {0, 2}));
    if (!left || !right) return one;
    report_.refused_sides += one ? 1 : 0;
    return one;
  }

  /// `rows` of direction, left and right.
  template <int n>
  bool use_rows(const Predicted& p, const CorridorWalls& detected, const int (&rows)[n]) {
    Eigen::Vector3d all(wrap_to_pi((detected.direction - p.walls.direction).radians()), 0.0, 0.0);
    if (p.walls.left && detected.left) all[1] = detected.left->offset_m - p.walls.left->offset_m;
    if (p.walls.right && detected.right)
      all[2] = detected.right->offset_m - p.walls.right->offset_m;
    using Rows = SparseRows<double, n, 6>;
    return use(VectorMeasurement<double, n, Rows>{
        all(rows),
        {p.sides.rows.index, p.sides.rows.value(rows, Eigen::all)},
        detected.covariance(rows, rows)});
  }

  template <int n, class Rows>
  bool use(const VectorMeasurement<double, n, Rows>& m) {
    return filter_.update([&](const CorridorState&) { return m; }, gates_[n]).accepted;
  }

  bool use_end(const Predicted& p, const CorridorWalls& detected,
               const CorridorScanUpdate& update) {
    if (end_is_side_wall(p, detected)) walls_.forget_end();
    if (!detected.end || update.outcome == WallOutcome::refused || end_is_side_wall(p, detected))
      return false;
    if (p.walls.end) {
      const Eigen::Vector2d innovation(
          wrap_to_pi((detected.end->alpha - p.walls.end->alpha).radians()),
          detected.end->rho_m - p.walls.end->rho_m);
      if (use(SeenEnd{innovation, p.end.rows, angle_first(*detected.end)})) {
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

  /// The way along the corridor by the edges of its walls, unless a wall across gives it.
  bool use_marks(const LaserScan& scan, const CorridorScanUpdate& update) {
    if (update.outcome == WallOutcome::reacquired && walls_.has_line_across()) walls_.forget_end();
    if (update.outcome != WallOutcome::used || walls_.has_end()) return false;
    auto edges = finder_.detector().edges(scan, *update.walls);
    if (!walls_.has_line_across() || marks_.are_passed()) {
      walls_.enter_line_across(*update.walls, filter_);
      marks_.begin(std::move(edges));
      return false;
    }
    const SeenEnd seen = walls_.predict(filter_).end;
    const auto shift = marks_.match(edges, seen.innovation[1]);
    const bool used = shift && use_shift(*shift, seen);
    report_.marks_used += used ? 1 : 0;
    report_.refused_marks += shift && !used ? 1 : 0;
    return used;
  }

  /// Of the line across through the laser where the marks began.
  bool use_shift(const CorridorMarks::Shift& shift, const SeenEnd& seen) {
    SparseRow<double, 5> row{seen.rows.index, {}};
    Eigen::Map<Eigen::Matrix<double, 1, 5>>(row.value.data()) = seen.rows.value.row(1);
    const double sigma = std::hypot(shift.sigma_m, options_.marks_sigma_m);
    return filter_
        .update(
            [&](const CorridorState&) {
              return ScalarMeasurement<double, SparseRow<double, 5>>{-shift.shift_m, row,
                                                                     sigma * sigma};
            },
            gates_[1])
        .accepted;
  }

  CorridorInsOptions options_;
  Filter filter_;
  CorridorMotion process_;
  MotionWatch watch_;
  WallFinder finder_;
  WallStates walls_;
  CorridorMarks marks_;
  CorridorReport report_;
  double gates_[4] = {};
  std::optional<LogTime> time_, scan_time_;
  std::optional<double> first_direction_rad_;
  LogTime walls_time_;
  int rejections_ = 0, end_rejections_ = 0;
  bool saturated_ = false, restarted_ = false;
};

CorridorIns::CorridorIns(const CorridorInsOptions& options, const SE2d& start)
    : engine_(detail::make_owned<Engine>(options, start)) {}

Result<void> CorridorIns::add_motion(const MotionSample& sample) {
  return engine_->add_motion(sample);
}
Result<CorridorScanUpdate> CorridorIns::add_scan(const LaserScan& scan) {
  return engine_->add_scan(scan);
}

const CorridorState& CorridorIns::state() const { return engine_->filter().state(); }
const SquareOf<CorridorState>& CorridorIns::covariance() const {
  return engine_->filter().covariance();
}
const CorridorReport& CorridorIns::report() const { return engine_->report(); }

}  // namespace wayfare
