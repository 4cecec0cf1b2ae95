#include "scores.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include <Eigen/LU>

#include <wayfare/eval/table.hpp>
#include <wayfare/map/detail/scan_raster.hpp>
#include <wayfare/map/inverse_lidar.hpp>
#include <wayfare/match/correlative.hpp>
#include <wayfare/match/pose_proposal.hpp>
#include <wayfare/slam/detail/motion.hpp>

#include "support/heat_map.hpp"
#include "support/scan_points.hpp"

namespace wayfare::examples {
namespace {

/// A scan, its pose and the map it is matched to.
struct Question {
  std::string sensor;
  RbpfSensorOptions options;
  PointSet points;  ///< in the robot's axes
  SE2d pose;
  OccupancyGrid map;
};

PointSet in_axes_of(const SE2d& pose, std::span<const Eigen::Vector2d> points_m) {
  const SE2d back = pose.inverse();
  PointSet points;
  for (const Eigen::Vector2d& p : points_m) points.push_back((back * p).cast<float>());
  return points;
}

Question lidar_question(const Recording& recording, const Trajectory& path, const ScoreOptions& o,
                        const LaserScan& scan) {
  const RadarSlamOptions slam;
  Question q{"LiDAR", slam.lidar, {}, *pose_at(path, scan.time), OccupancyGrid(slam.lidar.grid)};
  q.points = thin(end_points(scan, recording.T_base_laser.raw()),
                  static_cast<float>(slam.lidar.point_spacing_m),
                  static_cast<float>(slam.lidar.max_range_m));
  ScanRaster raster;
  std::optional<SE2d> mapped;
  for (const LaserScan& before : recording.scans) {
    if (before.time >= o.at || before.time >= scan.time) break;
    const auto pose = pose_at(path, before.time);
    if (!pose || (mapped && !reaches(mapped->inverse() * *pose, slam.lidar.map_travel_m,
                                     slam.lidar.map_turn)))
      continue;
    mapped = pose;
    // A scan that cannot be mapped is left out, as in radar_slam.
    (void)insert_scan(q.map, *pose * recording.T_base_laser.raw(), before, slam.lidar_model,
                      raster);
  }
  return q;
}

Question radar_question(const Recording& recording, const Trajectory& path, const ScoreOptions& o,
                        const RadarScan& first) {
  const RadarSlamOptions slam;
  Question q{"radar", slam.radar, {}, *pose_at(path, first.time), OccupancyGrid(slam.radar.grid)};
  ScanChoice scan, before;
  scan.from = first.time;
  scan.frames = o.frames;
  before.until = first.time - Duration(1);
  q.points = in_axes_of(q.pose, place_scans(recording, path, scan).radar_m);
  const LogOdds hit = LogOdds::from_probability(slam.radar_hit_probability);
  for (const Eigen::Vector2d& p : place_scans(recording, path, before).radar_m)
    q.map.update(cell_of(p, q.map.resolution_m()), hit);
  return q;
}

/// The first measurement from `at` on that the path has a pose for.
template <class Measurement>
const Measurement* first_from(const std::vector<Measurement>& all, const Trajectory& path,
                              LogTime at) {
  for (const Measurement& m : all)
    if (m.time >= at && pose_at(path, m.time)) return &m;
  return nullptr;
}

Result<LikelihoodField> field_of(const Question& q, const ScoreOptions& o) {
  const double turn = Angle::degrees(std::max(o.window_deg, 3.0 * o.motion_deg)).radians();
  const FieldReach reach{std::max(o.window_m, 3.0 * o.motion_m) + q.map.resolution_m(), turn};
  LikelihoodField field;
  const auto made =
      q.options.density
          ? DetectionFieldMaker().make(q.map, q.points, q.pose, reach, *q.options.density, field)
          : OccupancyFieldMaker().make(q.map, q.points, q.pose, reach, q.options.field, field);
  if (!made) return made.error();
  return field;
}

std::size_t index_of(int column, int row, int columns) {
  return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
         static_cast<std::size_t>(column);
}

/// Cells of a map's frame with values, of which the largest is the brightest.
struct Heat {
  Eigen::Vector2d corner_m;
  double cell_m = 0.0;
  int columns = 0, rows = 0;
  std::vector<double> values;  ///< in [0, 1], from the lowest row on

  [[nodiscard]] io::PlotImage image() const {
    io::PlotImage below{{static_cast<std::size_t>(columns), static_cast<std::size_t>(rows), 3, {}},
                        corner_m.x(),
                        corner_m.x() + columns * cell_m,
                        corner_m.y(),
                        corner_m.y() + rows * cell_m};
    for (int row = rows; row-- > 0;)
      for (int column = 0; column < columns; ++column) {
        const io::Colour c = heat_colour(values[index_of(column, row, columns)]);
        below.image.pixels.insert(below.image.pixels.end(), c.begin(), c.end());
      }
    return below;
  }
};

/// Of the best heading at each position; nats below the best.
std::vector<double> below_best(const ScoreSurface& s) {
  std::vector<double> best;
  for (int y = -s.half_y; y <= s.half_y; ++y)
    for (int x = -s.half_x; x <= s.half_x; ++x) {
      double top = s.at({{x, y}, -s.half_heading});
      for (int k = -s.half_heading; k <= s.half_heading; ++k)
        top = std::max(top, s.at({{x, y}, k}));
      best.push_back(top);
    }
  const double top = *std::max_element(best.begin(), best.end());
  for (double& b : best) b = top - b;
  return best;
}

/// Positions higher than their eight neighbours and within `nats` of the best.
int peaks_of(const std::vector<double>& below, int columns, double nats) {
  int peaks = 0;
  const int rows = static_cast<int>(below.size()) / columns;
  const auto at = [&](int x, int y) { return below[index_of(x, y, columns)]; };
  for (int y = 1; y + 1 < rows; ++y)
    for (int x = 1; x + 1 < columns; ++x) {
      bool peak = at(x, y) < nats;
      for (int i = 0; i < 9 && peak; ++i)
        peak = i == 4 || at(x, y) < at(x - 1 + i % 3, y - 1 + i / 3);
      peaks += peak ? 1 : 0;
    }
  return peaks;
}

void add_point(io::Plot& plot, const char* name, const Eigen::Vector2d& p) {
  plot.series.push_back({name, {p.x()}, {p.y()}, io::Mark::points});
}

Result<void> add_surface(const Question& q, const LikelihoodField& field, const ScoreOptions& o,
                         Scores& scores) {
  MatchOptions match;
  match.independent_points = q.options.independent_points;
  CorrelativeMatcher matcher;
  const auto surface = matcher.surface(
      field, q.points, q.pose, {o.window_m, o.window_m, Angle::degrees(o.window_deg)}, match);
  if (!surface) return surface.error();
  const std::vector<double> below = below_best(*surface);
  const double depth = std::max(1e-9, *std::max_element(below.begin(), below.end()));
  const double cell = surface->resolution_m;
  Heat heat{
      q.pose.translation() - cell * Eigen::Vector2d(surface->half_x + 0.5, surface->half_y + 0.5),
      cell,
      2 * surface->half_x + 1,
      2 * surface->half_y + 1,
      {}};
  for (const double b : below) heat.values.push_back(1.0 - b / depth);
  scores.surface = io::top_view("Score of a " + q.sensor + " scan, ln p of its best heading");
  scores.surface.image = heat.image();
  const auto best = static_cast<int>(std::min_element(below.begin(), below.end()) - below.begin());
  const int column = best % heat.columns, row = best / heat.columns;
  add_point(scores.surface, "best score",
            heat.corner_m + cell * (Eigen::Vector2d(column, row) + Eigen::Vector2d::Constant(0.5)));
  add_point(scores.surface, "pose on the path", q.pose.translation());
  scores.facts.emplace_back("points", std::to_string(q.points.size()));
  scores.facts.emplace_back("range of ln p", eval::fixed(depth, 1));
  scores.facts.emplace_back(
      "peaks", std::to_string(peaks_of(below, heat.columns, 3.0)) + " within 3 nats of the best");
  return {};
}

/// The same samples weighted by scan, motion and τ.
struct Samples {
  std::vector<SE2d> poses;
  std::vector<double> scan, motion, tau;
};

Result<Samples> sample(const Question& q, const LikelihoodField& field, const ScoreOptions& o) {
  const double turn = Angle::degrees(o.motion_deg).radians();
  const Gaussian<SE2d> motion{
      q.pose,
      Eigen::Vector3d(o.motion_m, o.motion_m, turn).cwiseAbs2().asDiagonal().toDenseMatrix()};
  const Gaussian<SE2d> flat{q.pose, 1e6 * motion.covariance};
  const PoseProposalOptions options{.samples = o.samples,
                                    .headings = std::min(40, o.samples),
                                    .independent_points = q.options.independent_points,
                                    .divide_by_proposal = true};
  Samples samples;
  PoseProposal proposal;
  for (auto [prior, weights] :
       {std::pair(&flat, &samples.scan), std::pair(&motion, &samples.tau)}) {
    Rng rng(o.seed);  // the same lattice
    const auto drawn = proposal.draw(field, q.points, motion, *prior, rng, options);
    if (!drawn) return drawn.error();
    samples.poses.clear();
    for (const WeightedPose& s : proposal.samples()) {
      samples.poses.push_back(s.T_map_points);
      weights->push_back(s.weight);
    }
  }
  const Eigen::Matrix3d information = motion.covariance.inverse();
  for (const SE2d& pose : samples.poses) {
    const Eigen::Vector3d off = pose.minus(motion.mean);
    samples.motion.push_back(std::exp(-0.5 * off.dot(information * off)));
  }
  return samples;
}

void scale_to_one(std::vector<double>& values) {
  const double top = *std::max_element(values.begin(), values.end());
  if (top > 0.0)
    for (double& v : values) v /= top;
}

Heat tau_heat(const Samples& s, double cell_m) {
  Eigen::Array2d low = s.poses.front().translation().array(), high = low;
  for (const SE2d& pose : s.poses) {
    low = low.min(pose.translation().array());
    high = high.max(pose.translation().array());
  }
  const auto count = [&](int axis) {
    return static_cast<int>(std::floor((high[axis] - low[axis]) / cell_m)) + 1;
  };
  Heat heat{low.matrix(), cell_m, count(0), count(1), {}};
  heat.values.assign(index_of(0, heat.rows, heat.columns), 0.0);
  for (std::size_t i = 0; i < s.poses.size(); ++i) {
    const Eigen::Vector2d at = (s.poses[i].translation() - heat.corner_m) / cell_m;
    const int column = std::min(static_cast<int>(at.x()), heat.columns - 1),
              row = std::min(static_cast<int>(at.y()), heat.rows - 1);
    heat.values[index_of(column, row, heat.columns)] += s.tau[i];
  }
  scale_to_one(heat.values);
  return heat;
}

/// Density along one axis of the robot, its largest value 1.
io::Series profile(const char* name, const Question& q, const Samples& s,
                   const std::vector<double>& weights, int axis, double reach_m) {
  const double cell = q.map.resolution_m();
  const int half = static_cast<int>(std::ceil(reach_m / cell));
  std::vector<double> sums(2 * static_cast<std::size_t>(half) + 1, 0.0);
  for (std::size_t i = 0; i < s.poses.size(); ++i) {
    const double off = (q.pose.inverse() * s.poses[i].translation())[axis];
    const int bin = static_cast<int>(std::lround(off / cell)) + half;
    if (bin >= 0 && bin <= 2 * half) sums[static_cast<std::size_t>(bin)] += weights[i];
  }
  scale_to_one(sums);
  io::Series series{name, {}, {}};
  for (int bin = -half; bin <= half; ++bin)
    series.add(bin * cell, sums[static_cast<std::size_t>(bin + half)]);
  return series;
}

io::Plot profiles(const Question& q, const Samples& s, int axis, double reach_m) {
  io::Plot plot{axis == 0 ? "Along the robot's heading, " + q.sensor
                          : "Across the robot's heading, " + q.sensor,
                axis == 0 ? "ahead [m]" : "to the left [m]",
                "density, largest 1",
                {}};
  plot.series = {profile("scan", q, s, s.scan, axis, reach_m),
                 profile("motion", q, s, s.motion, axis, reach_m),
                 profile("tau", q, s, s.tau, axis, reach_m)};
  return plot;
}

/// Standard deviation of weighted samples along the robot's axes.
std::string spread(const Question& q, const Samples& s, const std::vector<double>& weights) {
  double total = 0.0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero(), second = first;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    const Eigen::Vector3d off = s.poses[i].minus(q.pose);
    total += weights[i];
    first += weights[i] * off;
    second += weights[i] * off.cwiseAbs2();
  }
  const Eigen::Vector3d sigma =
      (second / total - (first / total).cwiseAbs2()).cwiseMax(0.0).cwiseSqrt();
  return eval::fixed(sigma.x(), 3) + " m along, " + eval::fixed(sigma.y(), 3) + " m across, " +
         eval::fixed(Angle::radians(sigma.z()).degrees(), 2) + " deg";
}

Result<Scores> scores_of(const Question& q, const ScoreOptions& o) {
  if (!q.map.bounds())
    return Error{ErrorCode::invalid, "there is no " + q.sensor + " map before " +
                                         eval::fixed(o.at.seconds(), 3) + " s"};
  Scores scores{q.sensor, q.sensor == "radar" ? "radar" : "lidar", {}, {}, {}, {}, {}};
  const auto field = field_of(q, o);
  if (!field) return field.error();
  if (auto done = add_surface(q, *field, o, scores); !done) return done.error();
  const auto samples = sample(q, *field, o);
  if (!samples) return samples.error();
  scores.tau = io::top_view("Samples of tau, " + q.sensor + ", summed over their headings");
  scores.tau.image = tau_heat(*samples, q.map.resolution_m()).image();
  const auto top = std::max_element(samples->tau.begin(), samples->tau.end());
  add_point(scores.tau, "largest tau",
            samples->poses[static_cast<std::size_t>(top - samples->tau.begin())].translation());
  add_point(scores.tau, "pose on the path", q.pose.translation());
  const double reach_m = 3.0 * o.motion_m;
  scores.along = profiles(q, *samples, 0, reach_m);
  scores.across = profiles(q, *samples, 1, reach_m);
  scores.facts.emplace_back("samples", std::to_string(samples->poses.size()));
  scores.facts.emplace_back("scan", spread(q, *samples, samples->scan));
  scores.facts.emplace_back("motion", spread(q, *samples, samples->motion));
  scores.facts.emplace_back("tau", spread(q, *samples, samples->tau));
  return scores;
}

}  // namespace

Result<std::vector<Scores>> scores_at(const Recording& recording, const Trajectory& path,
                                      const ScoreOptions& o) {
  std::vector<Question> questions;
  if (const LaserScan* scan = first_from(recording.scans, path, o.at))
    questions.push_back(lidar_question(recording, path, o, *scan));
  if (const RadarScan* frame = first_from(recording.radar, path, o.at))
    questions.push_back(radar_question(recording, path, o, *frame));
  if (questions.empty())
    return Error{ErrorCode::not_found, "there is no scan from the chosen time on"};
  std::vector<Scores> all;
  for (const Question& q : questions) {
    auto scores = scores_of(q, o);
    if (!scores) return scores.error();
    all.push_back(*std::move(scores));
  }
  return all;
}

}  // namespace wayfare::examples
