#include "slam/radar_slam/engine.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <wayfare/slam/detail/graph_slam/loss_detector.hpp>
#include <wayfare/slam/detail/graph_slam/wall_crossings.hpp>
#include <wayfare/slam/detail/motion.hpp>
#include <wayfare/slam/detail/scans.hpp>

namespace wayfare {
namespace {

constexpr double kNode_m = 0.4;
constexpr Angle kNodeTurn = Angle::degrees(20.0);

GraphSlamOptions graph_options(const RadarSlamOptions& o) {
  GraphSlamOptions options;
  options.T_base_laser = o.T_base_laser;
  options.max_range_m = std::min(options.max_range_m, o.lidar.max_range_m);
  return options;
}

/// Adds the observed cells of a grid to another.
void add_cells(OccupancyGrid& to, const OccupancyGrid& from) {
  from.for_each_tile([&](const Cell& first, std::span<const std::int16_t> cells) {
    for (std::size_t i = 0; i < cells.size(); ++i) {
      constexpr auto kSide = static_cast<std::size_t>(OccupancyGrid::Tiles::kSide);
      if (cells[i] == OccupancyGrid::kUnknown) continue;
      const Cell c{first.x + static_cast<int>(i % kSide), first.y + static_cast<int>(i / kSide)};
      to.update(c, LogOdds{cells[i]});
    }
  });
}

}  // namespace

RadarSlam::Engine::Engine(const detail::MakeParticleMatcher& make, const RadarSlamOptions& options)
    : make_(make),
      options_(options),
      joiner_(graph_options(options), detail::FieldMatching(graph_options(options))) {
  parts_.emplace(0, Part{ScanFilter(make, options, SE2d()), {}});
  statistics_.pieces = 1;
}

Result<void> RadarSlam::Engine::add_motion(const BiasedMotion& increment) {
  if (auto ok = current().filter.move(increment); !ok) return ok;
  if (last_scan_) moved_ = compose(moved_, increment);
  return {};
}

Result<void> RadarSlam::Engine::in_time(LogTime time, Sensor sensor) const {
  if (last_[sensor] && time <= *last_[sensor])
    return Error{ErrorCode::invalid, "the scan is not later than the one before"};
  if (last_scan_ && time < *last_scan_)
    return Error{ErrorCode::invalid, "the scan is earlier than another sensor's before it"};
  return {};
}

Result<RbpfOutcome> RadarSlam::Engine::process(const LaserScan& scan) {
  if (auto ok = detail::check_beams(scan); !ok) return ok.error();
  if (auto ok = in_time(scan.time, kLidar); !ok) return ok.error();
  return process(Input{scan.time, kLidar,
                       thin(end_points(scan, options_.T_base_laser.raw()),
                            static_cast<float>(options_.lidar.point_spacing_m),
                            static_cast<float>(options_.lidar.max_range_m)),
                       scan, moved_});
}

Result<RbpfOutcome> RadarSlam::Engine::process(LogTime time, const PointSet& points) {
  if (auto ok = in_time(time, kRadar); !ok) return ok.error();
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!points[i].allFinite())
      return Error{ErrorCode::invalid, "a detection of the scan is not finite"};
  return process(Input{time, kRadar,
                       thin(points, static_cast<float>(options_.radar.point_spacing_m),
                            static_cast<float>(options_.radar.max_range_m)),
                       std::nullopt, moved_});
}

Result<RbpfOutcome> RadarSlam::Engine::process(const Input& input) {
  if (is_lost(input.time)) begin_part();
  Part& part = current();
  const auto outcome = part.filter.process(input.time, input.sensor, input.points,
                                           input.scan ? &*input.scan : nullptr);
  if (current_ != 0) part.inputs.push_back(input);
  last_[input.sensor] = input.time;
  before_ = Motion{moved_.raw.mean, Eigen::Vector3d::Zero(), true};
  if (last_scan_) before_s_ = to_seconds(input.time - *last_scan_);
  last_scan_ = input.time;
  moved_ = {};
  if (input.sensor == kLidar) {
    const bool is_first = begins_piece_;
    add_node(input);
    if (outcome && outcome->updated && !is_first)
      unmatched_ = outcome->matched > 0 ? 0 : unmatched_ + 1;
  }
  count();
  return outcome;
}

/// Whether odometry leaps, or several scans in a row did not match; only where LiDAR scans, by
/// which pieces are joined, have been taken.
bool RadarSlam::Engine::is_lost(LogTime time) {
  constexpr int kLostScans = 5;
  if (!last_scan_ || begins_piece_) return false;
  const double step_s = to_seconds(time - *last_scan_);
  Motion expected;
  if (before_ && before_s_ > 0.0)
    expected.increment = SE2d::exp(before_->increment.log() * (step_s / before_s_));
  const Motion motion{moved_.raw.mean, Eigen::Vector3d::Zero(), true};
  const bool leaps = detail::LossDetector::leaps(motion, expected, step_s);
  statistics_.odometry_leaps += leaps ? 1 : 0;
  return leaps || unmatched_ >= kLostScans;
}

void RadarSlam::Engine::begin_part() {
  place_nodes();
  double x_m = 0.0;
  for (const SE2d& pose : nodes_.graph().poses) x_m = std::max(x_m, pose.x());
  current_ = nodes_.pieces();
  const SE2d beside(x_m + 2.0 * graph_options(options_).max_range_m, 0.0, Angle());
  parts_.emplace(current_, Part{ScanFilter(make_, options_, beside), {}});
  begins_piece_ = true;
  unmatched_ = 0;
  ++statistics_.pieces;
}

/// If the scan is far enough from the latest node.
void RadarSlam::Engine::add_node(const Input& input) {
  if (input.points.size() < options_.lidar.min_points) return;
  const auto pose = current().filter.pose();
  const SE2d at = pose->T_map_base.raw();
  const std::size_t scan = current().filter.size() - 1;
  if (begins_piece_) {
    nodes_.start(at, input.points);
  } else {
    if (!reaches(nodes_.pose(nodes_.latest()).inverse() * at, kNode_m, kNodeTurn)) return;
    nodes_.append(at, input.points, Eigen::Matrix3d::Identity());
    nodes_.graph().edges.clear();
  }
  begins_piece_ = false;
  scans_.push_back({current_, scan});
  if (parts_.size() < 2) return;
  place_nodes();
  while (join(joiner_.search_latest(nodes_))) {
  }
}

/// By the paths of the best particles so far.
void RadarSlam::Engine::place_nodes() {
  std::map<int, Trajectory> paths;
  for (const auto& [number, part] : parts_) paths[number] = part.filter.trajectory();
  for (std::size_t k = 0; k < scans_.size(); ++k)
    nodes_.graph().poses[k] = paths[scans_[k].part][scans_[k].scan].T_map_base.raw();
  joiner_.nodes_changed();
}

void RadarSlam::Engine::search_all_joins() {
  if (parts_.size() < 2 || begins_piece_) return;
  place_nodes();
  while (join(joiner_.search_all(nodes_))) {
  }
  count();
}

/// By the edge nearest to the beginning of the later part.
bool RadarSlam::Engine::join(const std::vector<PoseEdge<SE2d>>& edges) {
  if (edges.empty()) return false;
  const int to = nodes_.part_of(edges.front().to), from = nodes_.part_of(edges.front().from);
  const auto end = [&](const PoseEdge<SE2d>& e) { return to > from ? e.to : e.from; };
  const PoseEdge<SE2d>& e = *std::ranges::min_element(edges, {}, end);
  const SE2d T_from_to = nodes_.pose(e.from) * e.measurement * nodes_.pose(e.to).inverse();
  append(std::min(from, to), std::max(from, to), to > from ? T_from_to : T_from_to.inverse());
  nodes_.join(edges);
  nodes_.graph().edges.clear();
  ++statistics_.joins;
  place_nodes();
  return true;
}

/// Gives the scans of the later part to the earlier one, and goes on where the robot is.
void RadarSlam::Engine::append(int part, int later, const SE2d& T_part_later) {
  constexpr double kSigma_m = 0.1;
  constexpr Angle kSigma = Angle::degrees(2.0);
  const Eigen::Matrix3d covariance =
      Eigen::Vector3d(kSigma_m, kSigma_m, kSigma.radians()).cwiseAbs2().asDiagonal();
  Part& to = parts_.at(part);
  Part& from = parts_.at(later);
  const std::size_t before = to.filter.size();
  const SE2d latest = to.filter.trajectory().back().T_map_base.raw();
  const SE2d first = T_part_later * from.filter.trajectory().front().T_map_base.raw();
  for (std::size_t i = 0; i < from.inputs.size(); ++i) {
    Input& input = from.inputs[i];
    if (i == 0) {
      input.motion = {{latest.inverse() * first, covariance}};
      to.filter.relocate(input.motion.raw);
    } else {
      (void)to.filter.move(input.motion);
    }
    (void)to.filter.process(input.time, input.sensor, input.points,
                            input.scan ? &*input.scan : nullptr);
    if (part != 0) to.inputs.push_back(std::move(input));
  }
  for (NodeScan& s : scans_)
    if (s.part == later) s = {part, before + s.scan};
  if (current_ == part) {
    const SE2d end = to.filter.trajectory().back().T_map_base.raw();
    to.filter.relocate({end.inverse() * latest, covariance});
  }
  parts_.erase(later);
  if (current_ == later) current_ = part;
}

bool RadarSlam::Engine::is_small(int part) const {
  if (part == 0) return false;
  const bool has_nodes = part < nodes_.pieces();
  return !has_nodes || detail::PieceJoiner<detail::FieldMatching>::is_small(nodes_, part);
}

void RadarSlam::Engine::count() {
  PieceStatistics pieces = statistics_;
  const std::size_t begun = pieces.pieces;
  joiner_.count(nodes_, pieces);
  pieces.pieces = begun;
  pieces.scans_apart = 0;
  RbpfStatistics sum;
  for (const auto& [number, part] : parts_) {
    const RbpfStatistics& s = part.filter.statistics();
    sum.scans += s.scans;
    sum.updates += s.updates;
    sum.without_points += s.without_points;
    sum.matches += s.matches;
    sum.matches_refused += s.matches_refused;
    sum.matches_gated += s.matches_gated;
    sum.resampled += s.resampled;
    sum.loops_closed += s.loops_closed;
    sum.matcher_errors.add(s.matcher_errors);
    if (is_small(number)) pieces.scans_apart += s.scans;
  }
  static_cast<PieceStatistics&>(sum) = pieces;
  statistics_ = std::move(sum);
}

Trajectory RadarSlam::Engine::trajectory() const {
  if (parts_.size() == 1) return filter().trajectory();
  Trajectory all;
  for (const auto& [number, part] : parts_) {
    const Trajectory path = part.filter.trajectory();
    all.insert(all.end(), path.begin(), path.end());
  }
  std::ranges::stable_sort(all, {}, &StampedPose::time);
  return all;
}

RbpfMaps RadarSlam::Engine::maps() const {
  RbpfMaps maps = parts_.at(0).filter.maps();
  for (const auto& [number, part] : parts_) {
    if (number == 0 || is_small(number)) continue;
    add_cells(maps.lidar, part.filter.maps().lidar);
    add_cells(maps.radar, part.filter.maps().radar);
  }
  maps.gyro_bias = filter().maps().gyro_bias;
  return maps;
}

WallCrossings RadarSlam::Engine::wall_crossings() const {
  OccupancyGrid walls;
  ScanRaster raster;
  const Eigen::Vector2d laser = options_.T_base_laser.raw().translation();
  std::vector<PlacedPoints> scans;
  for (int k = 0; k < nodes_.size(); ++k) {
    if (is_small(nodes_.part_of(k))) continue;
    // A scan too large for the raster is left out of the map.
    (void)insert_points(walls, nodes_.pose(k), nodes_.points(k), {}, raster, laser);
    if (k % 3 == 0) scans.push_back({&nodes_.points(k), nodes_.pose(k)});
  }
  return detail::wall_crossings(scans, walls, laser);
}

}  // namespace wayfare
