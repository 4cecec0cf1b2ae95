#include <wayfare/gnss/single_point.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>

#include <wayfare/gnss/ephemerides.hpp>

#include "gnss/robust_solve.hpp"

namespace wayfare {
namespace {

using robust::Solution;
using robust::System;

/// Beyond every orbit, and every error of a receiver's clock.
constexpr double kFarthest_m = 1e9;

bool is_place(const Eigen::Vector3d& p) {
  return p.allFinite() && p.cwiseAbs().maxCoeff() < kFarthest_m;
}

/// Whether a satellite comes for the first time: measurements of one are not independent.
struct FirstOnly {
  std::array<std::array<bool, 256>, kGnssSystems> seen{};
  bool operator()(SatelliteId s) {
    return !std::exchange(seen[static_cast<std::size_t>(s.system)][s.number], true);
  }
};

/// The usable ranges in order, and their systems.
struct RangeSet {
  std::vector<const CorrectedRange*> ranges;
  std::array<int, kGnssSystems> column{};  ///< of each system's clock; −1: none
  int systems = 0;
};

RangeSet ranges_of(const RangeEpoch& epoch) {
  RangeSet set;
  set.column.fill(-1);
  FirstOnly is_first;
  for (const CorrectedRange& r : epoch.satellites) {
    const bool usable = std::abs(r.range_m) < kFarthest_m && r.range_sigma_m > 0.0 &&
                        std::isfinite(r.range_sigma_m) && is_place(r.position_ecef_m);
    if (!usable || !is_first(r.satellite)) continue;
    set.ranges.push_back(&r);
    int& column = set.column[index_of(r.satellite.system)];
    if (column < 0) column = 3 + set.systems++;
  }
  return set;
}

/// The range equations linearised at `x` (position, clocks), with known offsets as priors.
System linearise(const RangeSet& set, const Eigen::VectorXd& x, const SinglePointOptions& options) {
  System s(static_cast<int>(x.size()));
  for (const CorrectedRange* r : set.ranges) {
    const Eigen::Vector3d to_satellite = r->position_ecef_m - x.head<3>();
    const double distance = to_satellite.norm();
    Eigen::VectorXd row = Eigen::VectorXd::Zero(x.size());
    row.head<3>() = -to_satellite / distance;
    const int clock = set.column[index_of(r->satellite.system)];
    row[clock] = 1.0;
    s.add(row, r->range_m - distance - x[clock], r->range_sigma_m);
  }
  const int gps = set.column[index_of(GnssSystem::gps)];
  for (const GnssSystem system : kAllGnssSystems) {
    const auto& known = options.offsets[index_of(system)];
    const int clock = set.column[index_of(system)];
    if (!known || clock < 0 || gps < 0 || clock == gps) continue;
    Eigen::VectorXd row = Eigen::VectorXd::Zero(x.size());
    row[clock] = 1.0, row[gps] = -1.0;
    s.add_prior(row, known->offset_m - (x[clock] - x[gps]), std::max(known->sigma_m, 0.01));
  }
  return s;
}

std::string systems_text(const RangeSet& set) {
  std::string text;
  for (const GnssSystem system : kAllGnssSystems) {
    const auto count = std::count_if(set.ranges.begin(), set.ranges.end(),
                                     [&](const auto* r) { return r->satellite.system == system; });
    if (count == 0) continue;
    text += (text.empty() ? "" : ", ") + std::to_string(count) + " of " + name_of(system);
  }
  return text.empty() ? "none" : text;
}

Error too_few(const RangeSet& set, const std::string& what) {
  return Error{ErrorCode::degenerate, what + " (" + systems_text(set) + ")", "single point"};
}

/// For equations of this redundancy.
robust::Options robust_options(const SinglePointOptions& options, int redundancy) {
  return {options.exclude_faults,
          chi_square_threshold(std::max(redundancy, 1), options.false_alarm), options.robust_scale,
          options.exclusion_sigma};
}

/// Gauss-Newton iterations until the position converges.
Result<Solution> iterate(const RangeSet& set, const SinglePointOptions& options,
                         Eigen::VectorXd& x) {
  // Far from the solution, nonlinearity looks like faults; exclusion starts once it is near, or as
  // near as the faults allow.
  bool near = false;
  for (int iteration = 0; iteration < 40; ++iteration) {
    const System equations = linearise(set, x, options);
    robust::Options how = robust_options(options, equations.redundancy());
    how.exclude = near && options.exclude_faults;
    const std::optional<Solution> solution = robust::solve(equations, how);
    if (!solution)
      return too_few(
          set, "the satellites do not determine a position: their directions are too similar");
    x += solution->step;
    if (!x.allFinite() || x.head<3>().norm() > 1e9) break;
    const double moved_m = solution->step.head<3>().norm();
    if (near && moved_m < 1e-4) return *solution;
    near = near || moved_m < 1e3;
  }
  return Error{ErrorCode::numerical, "the position does not converge", "single point"};
}

bool is_valid(const ReflectionModel& m) {
  const bool positive = m.direct.range_m(1.0, 45.0) > 0.0 && m.decrease_dbhz > 0.0 &&
                        m.excess_sigma_m > 0.0 && m.odds_at_45_dbhz >= 0.0;
  return positive && m.variance_factor >= 1.0 && std::abs(m.excess_m) < 1e6 &&
         m.odds_at_45_dbhz < 1e6 && m.excess_sigma_m < 1e6 && m.variance_factor < 1e6;
}

/// Of the ranges at `x`, where a reflected range is longer.
std::optional<Solution> solve_reflected(const RangeSet& set, const Eigen::VectorXd& x,
                                        const SinglePointOptions& options) {
  const ReflectionModel& model = *options.reflections;
  const Geodetic here = geodetic_from_ecef(x.head<3>());
  robust::Mixture mixture{{}, {}, model.excess_m, model.excess_sigma_m, model.variance_factor};
  for (const CorrectedRange* r : set.ranges) {
    const double cn0 = std::isfinite(r->cn0_dbhz) ? std::clamp(r->cn0_dbhz, 15.0, 50.0) : 45.0;
    const double elevation = line_of_sight(here, r->position_ecef_m).elevation_rad;
    const double odds = model.odds_at_45_dbhz * std::exp((45.0 - cn0) / model.decrease_dbhz);
    mixture.direct_sigma.push_back(model.direct.range_m(std::max(elevation, 0.1), cn0));
    mixture.probability.push_back(odds / (1.0 + odds));
  }
  return robust::solve_mixture(linearise(set, x, options), mixture);
}

/// Limits that errors of this covariance exceed with probability `risk`.
void fill_protection(double risk, SinglePoint& point) {
  const Eigen::Matrix3d& p = point.position_covariance_ned_m2;
  // Rayleigh's distribution bounds that of any direction, and the normal one.
  const double factor = -2.0 * std::log(std::clamp(risk, 1e-15, 1.0));
  point.horizontal_protection_m = std::sqrt(factor * (p(0, 0) + p(1, 1)));
  point.vertical_protection_m = std::sqrt(factor * p(2, 2));
}

void fill_geometry(const System& equations, const Solution& solution,
                   const Eigen::Matrix3d& ecef_ned, bool reflections, SinglePoint& point) {
  const Eigen::Matrix3d to_ned = ecef_ned.transpose();
  point.position_covariance_ned_m2 =
      to_ned * solution.covariance.topLeftCorner<3, 3>() * to_ned.transpose();
  // Dilution of precision weighs all used satellites equally.
  const Eigen::MatrixXd q = equations.unweighted_covariance(
      reflections ? Eigen::VectorXd::Ones(solution.weight.size()) : solution.weight);
  const Eigen::Matrix3d q_ned = to_ned * q.topLeftCorner<3, 3>() * to_ned.transpose();
  const double clocks = q.diagonal().tail(q.rows() - 3).sum();
  point.dop.horizontal = std::sqrt(q_ned(0, 0) + q_ned(1, 1));
  point.dop.vertical = std::sqrt(q_ned(2, 2));
  point.dop.position = std::sqrt(q_ned.trace());
  point.dop.time = std::sqrt(q(3, 3));
  point.dop.geometry = std::sqrt(q_ned.trace() + clocks);
}

/// Velocity and clock drift from the range rates, if sufficient.
void solve_velocity(const RangeEpoch& epoch, const SinglePointOptions& options,
                    const Eigen::Matrix3d& ecef_ned, SinglePoint& point) {
  System equations(4);
  std::vector<std::size_t> which;
  FirstOnly is_first;
  for (std::size_t i = 0; i < epoch.satellites.size(); ++i) {
    const CorrectedRange& r = epoch.satellites[i];
    const bool usable = std::abs(r.range_rate_mps) < 1e6 && r.range_rate_sigma_mps > 0.0 &&
                        std::isfinite(r.range_rate_sigma_mps) && r.velocity_ecef_mps.allFinite();
    if (!usable || !is_first(r.satellite)) continue;
    const Eigen::Vector3d u = (r.position_ecef_m - point.position_ecef_m).normalized();
    Eigen::VectorXd row(4);
    row << -u, 1.0;
    equations.add(row, r.range_rate_mps - u.dot(r.velocity_ecef_mps), r.range_rate_sigma_mps);
    which.push_back(i);
  }
  if (equations.redundancy() < 0) return;
  const std::optional<Solution> solution =
      robust::solve(equations, robust_options(options, equations.redundancy()));
  if (!solution || solution->step.head<3>().norm() > 1e4) return;
  point.velocity_ned_mps = ecef_ned.transpose() * solution->step.head<3>();
  point.velocity_covariance_ned =
      ecef_ned.transpose() * solution->covariance.topLeftCorner<3, 3>() * ecef_ned;
  point.clock_drift_mps = solution->step[3];
  for (std::size_t k = 0; k < which.size(); ++k) {
    SatelliteResidual& r = point.residuals[which[k]];
    r.rate_mps = solution->residual[static_cast<Eigen::Index>(k)];
    r.rate_used = solution->weight[static_cast<Eigen::Index>(k)] > 0.0;
  }
}

void fill_residuals(const RangeEpoch& epoch, const RangeSet& set, const Solution& solution,
                    SinglePoint& point) {
  std::size_t next = 0;
  for (const CorrectedRange& r : epoch.satellites) {
    SatelliteResidual residual;
    residual.satellite = r.satellite;
    residual.sight = line_of_sight(point.position, r.position_ecef_m);
    residual.range_sigma_m = r.range_sigma_m;
    residual.rate_sigma_mps = r.range_rate_sigma_mps;
    residual.cn0_dbhz = r.cn0_dbhz;
    if (next < set.ranges.size() && set.ranges[next] == &r) {
      const auto k = static_cast<Eigen::Index>(next++);
      residual.range_m = solution.residual[k];
      residual.range_used = solution.weight[k] > 0.0;
      point.used += residual.range_used ? 1 : 0;
    }
    point.residuals.push_back(residual);
  }
}

/// The clocks of the systems in use, and the true time by the first of them. `all`: of ranges that
/// do not count as used, too.
void fill_clocks(const RangeSet& set, const Eigen::VectorXd& x, bool all, SinglePoint& point) {
  for (const SatelliteResidual& r : point.residuals) {
    const std::size_t s = index_of(r.satellite.system);
    if (r.range_used || (all && !std::isnan(r.range_m))) point.clock_bias_m[s] = x[set.column[s]];
  }
  const auto& clocks = point.clock_bias_m;
  const auto first =
      std::find_if(clocks.begin(), clocks.end(), [](double clock) { return !std::isnan(clock); });
  point.instant = point.time;
  if (first != clocks.end()) point.instant = point.time - from_seconds(*first / kSpeedOfLight_mps);
}

}  // namespace

double chi_square_threshold(int degrees_of_freedom, double probability) {
  if (degrees_of_freedom < 1) return 0.0;
  // The normal quantile by bisection of its tail, once per epoch.
  double low = -10.0, high = 10.0;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (0.5 * std::erfc(middle / std::numbers::sqrt2) > probability ? low : high) = middle;
  }
  const double n = degrees_of_freedom, v = 2.0 / (9.0 * n);
  return n * std::pow(std::max(1.0 - v + low * std::sqrt(v), 0.0), 3);
}

Result<SinglePoint> single_point(const RangeEpoch& epoch, const SinglePointOptions& options,
                                 const Eigen::Vector3d& near_ecef_m) {
  if (options.reflections && !is_valid(*options.reflections))
    return Error{ErrorCode::invalid, "the parameters of the model of reflections are not usable",
                 "single point"};
  const RangeSet set = ranges_of(epoch);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(3 + set.systems);
  if (is_place(near_ecef_m)) x.head<3>() = near_ecef_m;
  const int have = static_cast<int>(set.ranges.size());
  const int needed = set.ranges.empty() ? 4 : have - linearise(set, x, options).redundancy();
  if (have < needed) {
    const int clocks = std::max(set.systems, 1);
    return too_few(set, "a position with " + std::to_string(clocks) +
                            (clocks == 1 ? " clock" : " clocks") + " needs " +
                            std::to_string(needed) + " satellites, there are " +
                            std::to_string(have));
  }
  Result<Solution> solution = iterate(set, options, x);
  if (!solution) return solution.error();
  if (options.reflections) {
    if (std::optional<Solution> mixed = solve_reflected(set, x, options)) {
      x += mixed->step;
      *solution = *std::move(mixed);
    }
  }

  SinglePoint point;
  point.time = epoch.time;
  point.position_ecef_m = x.head<3>();
  point.position = geodetic_from_ecef(point.position_ecef_m);
  point.chi_square = solution->chi_square;
  point.degrees_of_freedom = solution->redundancy;
  point.consistent =
      solution->redundancy < 1 ||
      solution->chi_square <= chi_square_threshold(solution->redundancy, options.false_alarm);
  const Eigen::Matrix3d ecef_ned = rotation_ecef_ned(point.position);
  fill_geometry(linearise(set, x, options), *solution, ecef_ned, options.reflections.has_value(),
                point);
  fill_protection(options.integrity_risk, point);
  if (options.reflections)
    point.consistent = point.horizontal_protection_m <= options.alert_limit_m;
  if (!point.consistent && !options.answer_inconsistent)
    return Error{ErrorCode::invalid,
                 "the ranges are inconsistent, and no consistent subset was found", "single point"};
  if (!(point.dop.position <= options.max_pdop))
    return too_few(set, "the satellites' geometry is too poor: PDOP " +
                            std::to_string(static_cast<long>(std::min(point.dop.position, 1e9))));
  fill_residuals(epoch, set, *solution, point);
  fill_clocks(set, x, options.reflections.has_value(), point);
  solve_velocity(epoch, options, ecef_ned, point);
  return point;
}

namespace {

/// Alternates range correction and position until the position converges.
Result<SinglePoint> converge(const ObservationEpoch& epoch, const Ephemerides& ephemerides,
                             const SinglePointOptions& options, Eigen::Vector3d near) {
  std::vector<RefusedRange> refused;
  // Geometry and consistency are checked at the end only.
  SinglePointOptions intermediate = options;
  intermediate.max_pdop = std::numeric_limits<double>::infinity();
  intermediate.answer_inconsistent = true;
  for (int iteration = 0; iteration < 8; ++iteration) {
    refused.clear();
    const RangeEpoch ranges =
        correct_ranges(epoch, ephemerides, near, options.corrections, &refused);
    Result<SinglePoint> point = single_point(ranges, intermediate, near);
    if (!point) return point.error();
    const bool converged = near.norm() > 1e6 && (point->position_ecef_m - near).norm() < 1.0;
    if (converged) {
      point = single_point(ranges, options, near);
      if (point) point->refused = std::move(refused);
      return point;
    }
    near = point->position_ecef_m;
  }
  return Error{ErrorCode::numerical, "the range corrections do not converge", "single point"};
}

}  // namespace

Result<SinglePoint> single_point(const ObservationEpoch& epoch, const Ephemerides& ephemerides,
                                 const SinglePointOptions& options,
                                 const Eigen::Vector3d& near_ecef_m) {
  if (near_ecef_m.allFinite() && near_ecef_m.norm() > 1e6)
    if (auto point = converge(epoch, ephemerides, options, near_ecef_m)) return point;
  // A wrong approximate position hides satellites below the horizon.
  return converge(epoch, ephemerides, options, Eigen::Vector3d::Zero());
}

}  // namespace wayfare
